/// Scenes with more or fewer bodies: everything that names a body names the same one afterwards.
#include "scene/scene_bodies.h"

#include <gtest/gtest.h>

#include <map>

#include "haptic_core/loop/command.h"
#include "haptic_core/loop/session.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/world.h"
#include "scene/robot_tree.h"
#include "temporary_files.h"

namespace haptic {
namespace bodies_test {

/// A box that is drawn.
std::string drawnBox(const std::string& name) {
  std::string text = boxLink(name, 1, 0.1);
  return text.insert(text.find("<collision>"), "<visual><geometry><sphere radius=\"0.1\"/></geometry></visual>");
}

/// Three boxes, a pointer on the last, a sensor and a motion on the middle one, a pair of the first and the last that does not collide.
SceneDef threeBoxes(TemporaryFiles& files) {
  std::string text = "<link name=\"world\"/>\n";
  int i = 0;
  for (const char* name : {"a", "b", "c"}) {
    text += drawnBox(name) + joint(std::string(name) + "_free", "floating", "world", name, "", std::to_string(i++) + " 0 1");
  }
  text += "<haptic:pointer link=\"c\"/><haptic:sensor name=\"felt\" type=\"contact\" link=\"b\" with=\"c\"/>"
          "<haptic:motion link=\"b\" topic=\"way\"/><haptic:collision_filter link1=\"a\" link2=\"c\"/>\n";
  return loadScene(files.write("three.urdf", robot(text)));
}

SceneDef model(TemporaryFiles& files, const std::string& text, const std::string& prefix, const SceneDef& running) {
  ModelSettings settings;
  settings.prefix = prefix;
  settings.X_WM.p = Vector3(0, 5, 1);
  settings.floats_unless_world = true;
  return loadModel(files.write("model.urdf", robot(text)), settings, running.world.settings, {});
}

TEST(Bodies, AModelStandsWhereItIsAskedTo) {
  TemporaryFiles files;
  const SceneDef scene = threeBoxes(files);
  const std::string text = boxLink("base", 1, 0.1) + boxLink("tip", 1, 0.1) +
                           joint("hinge", "continuous", "base", "tip", "<axis xyz=\"0 0 1\"/>", "0.3 0 0");
  const SceneDef arm = model(files, text, "arm/", scene);
  EXPECT_EQ(arm.world.articulations[0].links[0].joint.type, JointType::kFloating);
  EXPECT_EQ(arm.world.articulations[0].links[1].joint.name, "arm/hinge");
  EXPECT_EQ(arm.world.articulations[0].X_WA.p, Vector3(0, 5, 1));
  EXPECT_EQ(arm.world.settings.step, scene.world.settings.step);
  const std::string foot = "<link name=\"world\"/>\n" + joint("foot", "fixed", "world", "base", "", "0 0 1");
  const SceneDef hung = model(files, text + foot, "arm/", scene);
  EXPECT_EQ(hung.world.articulations[0].links[0].joint.type, JointType::kFixed);
}

TEST(Bodies, IndicesFollowWhatGoes) {
  TemporaryFiles files;
  const SceneDef scene = threeBoxes(files);
  const ChangedScene changed = withoutModel(scene, "a");
  EXPECT_EQ(changed.kept, (std::vector<int>{1, 2}));
  EXPECT_EQ(changed.links, (std::vector<std::string>{"a"}));
  const WorldDef& world = changed.scene.world;
  EXPECT_EQ(world.pointers[0].articulation, 1);
  ASSERT_EQ(world.sensors.size(), 1u);
  EXPECT_EQ(world.sensors[0].articulation, 0);
  EXPECT_EQ(world.sensors[0].with_articulation, 1);
  ASSERT_EQ(world.motions.size(), 1u);
  EXPECT_EQ(world.motions[0].articulation, 0);
  EXPECT_EQ(changed.scene.told_motions[0].motion, 0);
  EXPECT_TRUE(world.filters.empty()) << "one of the pair has gone";
  for (const VisualDef& visual : changed.scene.visuals) EXPECT_EQ(visual.name, world.articulations[visual.articulation].links[0].name);
  World running(scene.world);
  NextWorld next(running, world, changed.kept);
  EXPECT_TRUE(running.exchange(next));

  const ChangedScene without_b = withoutModel(scene, "b");
  EXPECT_TRUE(without_b.scene.world.sensors.empty());
  EXPECT_TRUE(without_b.scene.world.motions.empty());
  EXPECT_TRUE(without_b.scene.told_motions.empty());
  EXPECT_EQ(without_b.scene.world.filters[0].articulation_b, 1);
  EXPECT_THROW(withoutModel(scene, "c"), SetupError) << "a hand moves it";
  EXPECT_THROW(withoutModel(scene, "d"), SetupError) << "there is none";
}

TEST(Bodies, IndicesOfAModelAreItsOwn) {
  TemporaryFiles files;
  const SceneDef scene = threeBoxes(files);
  const SceneDef box = model(files, drawnBox("box") + "<haptic:sensor name=\"felt\" type=\"contact\" link=\"box\"/>"
                                                             "<haptic:motion link=\"box\" topic=\"other\"/>\n", "one/", scene);
  const ChangedScene changed = withModel(scene, box);
  EXPECT_EQ(changed.kept, (std::vector<int>{0, 1, 2, -1}));
  EXPECT_EQ(changed.links, (std::vector<std::string>{"one/box"}));
  const WorldDef& world = changed.scene.world;
  EXPECT_EQ(world.sensors[1].name, "one/felt");
  EXPECT_EQ(world.sensors[1].articulation, 3);
  EXPECT_EQ(world.motions[1].articulation, 3);
  EXPECT_EQ(changed.scene.told_motions[1].motion, 1);
  EXPECT_EQ(changed.scene.visuals.back().articulation, 3);
  EXPECT_THROW(withModel(changed.scene, box), SetupError) << "its links are there already";
  SceneDef on_a_path = box;
  on_a_path.world.motions[0].time = {0, 1};
  EXPECT_THROW(withModel(scene, on_a_path), SetupError) << "its time is the scene's";
  // And it goes again, with all that is its own.
  const ChangedScene back = withoutModel(changed.scene, "one");
  EXPECT_EQ(fingerprint(back.scene.world), fingerprint(scene.world));
  EXPECT_EQ(back.scene.world.sensors.size(), 1u);
  EXPECT_EQ(back.scene.told_motions.size(), 1u);
}

TEST(Bodies, AModelBringsNoHandsAndNoSettings) {
  TemporaryFiles files;
  const SceneDef scene = threeBoxes(files);
  const SceneDef held = model(files, drawnBox("box") + "<haptic:pointer link=\"box\"/>\n", "one/", scene);
  EXPECT_THROW(withModel(scene, held), SetupError);
  const SceneDef other = model(files, "<haptic:scene step=\"0.0005\" gravity=\"0 0 0\"/>" + drawnBox("box"), "one/", scene);
  EXPECT_EQ(other.world.settings.gravity, scene.world.settings.gravity);
  ASSERT_FALSE(other.warnings.empty());
  EXPECT_NE(other.warnings[0].find("<haptic:scene> is left out"), std::string::npos);
}

TEST(Bodies, AReplayDrawsWhatItKnows) {
  TemporaryFiles files;
  const SceneDef scene = threeBoxes(files);
  const SceneDef box = model(files, drawnBox("box"), "one/", scene);
  ChangedScene changed = withModel(scene, box);
  changed = withoutModel(changed.scene, "a");
  const SceneDef seen = withBodies(scene, unpackBodies(packBodies(changed.scene.world, changed.kept)));
  std::map<std::string, int> drawn;
  for (const VisualDef& visual : seen.visuals) ++drawn[seen.world.articulations[visual.articulation].links[visual.link].name];
  EXPECT_EQ(drawn.size(), 3u);
  EXPECT_EQ(drawn.count("a"), 0u);
  EXPECT_EQ(drawn["one/box"], 1) << "by what collides";
}

}  // namespace bodies_test
}  // namespace haptic
