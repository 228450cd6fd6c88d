/// What a scene that comes with a hand promises: a relaxed hand on a G6X3R bears its contacts at 1 kHz.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "haptic_core/analysis/hand_certificate.h"
#include "scene/scene_file.h"

namespace haptic {
namespace {

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

}  // namespace
}  // namespace haptic
