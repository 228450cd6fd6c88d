/// What a scene that comes with a hand promises: a relaxed hand on a G6X3R bears its contacts at 1 kHz, and its scripted path
/// stays where the strings can be taut without pulling the grip.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "haptic_core/analysis/hand_certificate.h"
#include "haptic_core/base/error.h"
#include "haptic_core/spidar/tension_distribution.h"
#include "haptic_core/world/world.h"
#include "scene/resource_path.h"
#include "scene/scene_file.h"

namespace haptic {
namespace shipped_scenes_test {

std::string textOf(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

TEST(ShippedScenes, HandsBearTheirContacts) {
  const DeviceDef device = loadDevice(std::string(HAPTIC_SCENES) + "/../devices/spidar_g6x3r.yaml");
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(HAPTIC_SCENES)) {
    if (entry.path().extension() != ".urdf" || textOf(entry.path()).find("<haptic:pointer") == std::string::npos) continue;
    SceneDef scene = loadScene(entry.path().string());
    scene.world.settings.step = 1e-3;
    ++scenes;
    for (const HandDef& hand : scene.hands) {
      const HandCertificate c = certifyHand(scene.world, hand.pointer, {hand.workspace.scale, hand.force_scale}, device);
      EXPECT_TRUE(c.holds()) << entry.path().filename() << ": " << c.text();
    }
  }
  EXPECT_GE(scenes, 12);
}

// Strings only pull: beyond that region no tensions above the least balance one another, whatever the scene asks for. That
// region of a G6X3R is lopsided: 25 mm to the sides go with 15 mm to the right, not with 15 mm to the left.
TEST(ShippedScenes, PathsStayWhereTheStringsBalance) {
  constexpr double kFelt = 0.05;  // [N]
  const DeviceDef device = loadDevice(std::string(HAPTIC_SCENES) + "/../devices/spidar_g6x3r.yaml");
  const StringKinematics kinematics(device);
  TensionDistribution tensions(device, kinematics);
  int paths = 0;
  for (const auto& entry : std::filesystem::directory_iterator(HAPTIC_SCENES)) {
    if (entry.path().extension() != ".urdf") continue;
    for (const HandDef& hand : loadScene(entry.path().string()).hands) {
      ++paths;
      double most = 0, when = 0;
      for (double time = 0; time < std::min(10.0, hand.path.duration()); time += 0.01) {
        tensions.setStructure(kinematics.scaledStructure(hand.path.at(time)));
        const double pull = tensions.present(Wrench{}).F_G_B.force.norm();
        if (pull > most) most = pull, when = time;
      }
      EXPECT_LT(most, kFelt) << entry.path().filename() << " at " << when << " s";
    }
  }
  EXPECT_GE(paths, 25);
}

TEST(ShippedScenes, LargeOnesAreFoundByTheirNames) {
  SceneOptions options;
  options.scene_folders = {HAPTIC_SCENES};
  EXPECT_EQ(loadScene("workshop", options).world.pointers.size(), 1u);
  EXPECT_THROW(loadScene("workshop_wall", options), SetupError) << "it is a model of a large scene";
  const std::vector<std::string> known = knownScenes(options.scene_folders);
  for (const char* name : {"city", "pile300", "touch_cube", "workshop"}) EXPECT_EQ(std::count(known.begin(), known.end(), name), 1) << name;
  EXPECT_EQ(std::count(known.begin(), known.end(), "heap100"), 0);
}

/// All 30 tools lie or hang still from the first second on.
TEST(ShippedScenes, ToolsOfTheWorkshopHang) {
  SceneOptions options;
  options.scene_folders = {HAPTIC_SCENES};
  SceneDef scene = loadScene("workshop", options);
  World world(scene.world);
  for (int i = 0; i < 1000; ++i) world.step();
  EXPECT_EQ(world.report().standing, 30);
}

}  // namespace shipped_scenes_test
}  // namespace haptic
