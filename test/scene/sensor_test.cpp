/// <haptic:sensor>: read strictly, merged fixed joints measured as they stand in the file.
#include <gtest/gtest.h>

#include <cmath>

#include "haptic_core/world/world.h"
#include "temporary_files.h"

namespace haptic {
namespace sensor_test {

const SceneOptions kNoPointer = {0, "", {}, false};

/// base ─revolute─ arm ─fixed─ tool ─fixed─ tip, and a finger that slides on the tool.
std::string armWith(const std::string& sensors) {
  return robot(boxLink("base") + boxLink("arm", 2) + boxLink("tool", 0.5) + boxLink("tip", 0.25) + boxLink("finger", 0.125) +
               joint("shoulder", "revolute", "base", "arm") + joint("wrist", "fixed", "arm", "tool", "", "0.3 0 0") +
               joint("end", "fixed", "tool", "tip", "", "0 0.2 0") + joint("slide", "prismatic", "tool", "finger") + sensors);
}

std::string wrench(const std::string& name, const std::string& joint, const std::string& more = "") {
  return "<haptic:sensor name=\"" + name + "\" type=\"wrench\" joint=\"" + joint + "\" " + more + "/>\n";
}

TEST(Sensors, MergedFixedJointsCarryWhatHangsOnThem) {
  const std::string joints[] = {"shoulder", "wrist", "end", "slide"};
  const double masses[] = {2.875, 0.875, 0.25, 0.125};
  std::string tags;
  for (const std::string& name : joints) tags += wrench(name, name);
  const SceneDef scene = loadText(armWith(tags), kNoPointer);
  ASSERT_EQ(scene.world.sensors.size(), 4u);
  EXPECT_FALSE(scene.world.sensors[0].on_part);
  EXPECT_TRUE(scene.world.sensors[1].on_part);
  EXPECT_EQ(scene.world.sensors[1].frame, "tool");
  World world(scene.world);
  world.step();
  for (int i = 0; i < 4; ++i) {
    // A robot with sensors holds as one without: still, to the drives' give of a step's fall.
    const Vector3 F = world.sensorReading(i).F_S.force;
    EXPECT_NEAR(F.norm(), 9.8 * masses[i], 1e-3 * 9.8 * masses[i]) << joints[i];
  }
  // The wrist's moment at rest: tool at the joint, tip 0.2 m along y, finger 1 m above; about x by the tip alone.
  EXPECT_NEAR(world.sensorReading(1).F_S.torque.x(), 0.2 * 0.25 * 9.8, 1e-3);
  EXPECT_NEAR(world.sensorReading(1).F_S.torque.y(), 0, 1e-3);
}

/// Without <inertial> a part weighs what its shapes do.
TEST(Sensors, PartsFromShapes) {
  const auto bare = [](const std::string& name, double size) {
    const std::string s = std::to_string(size);
    return "<link name=\"" + name + "\"><collision><geometry><box size=\"" + s + " " + s + " " + s + "\"/></geometry></collision></link>\n";
  };
  SceneOptions options = kNoPointer;
  options.default_density = 1000;
  const SceneDef scene = loadText(robot(boxLink("base") + bare("arm", 0.2) + bare("tool", 0.1) + joint("j", "revolute", "base", "arm") +
                                        joint("w", "fixed", "arm", "tool", "") + wrench("w", "w")), options);
  EXPECT_NEAR(scene.world.sensors[0].part.inertia.mass, 1, 1e-12);
  EXPECT_EQ(scene.world.sensors[0].part.collisions, std::vector<int>{1});
}

TEST(Sensors, AllAttributesArrive) {
  const SceneDef scene = loadText(
      armWith(wrench("ft", "wrist", "rate=\"500\" noise_force=\"0.1\" noise_torque=\"0.02\" seed=\"7\"") +
              "<haptic:sensor name=\"c\" type=\"contact\" link=\"tip\" with=\"base\"/>"
              "<haptic:sensor name=\"i\" type=\"imu\" link=\"tool\" xyz=\"1 2 3\" noise_angular_rate=\"0.3\" noise_specific_force=\"0.4\" "
              "noise_orientation=\"0.5\"/>"),
      kNoPointer);
  const SensorDef &ft = scene.world.sensors[0], &c = scene.world.sensors[1], &i = scene.world.sensors[2];
  EXPECT_EQ(ft.rate, 500);
  EXPECT_EQ(ft.noise_force, 0.1);
  EXPECT_EQ(ft.noise_torque, 0.02);
  EXPECT_EQ(ft.seed, 7u);
  EXPECT_EQ(c.part.collisions, std::vector<int>{2});  // arm, tool, tip in one link
  EXPECT_EQ(c.with_link, 0);
  EXPECT_FALSE(c.with_part);
  EXPECT_EQ(i.frame, "i");
  EXPECT_NEAR((i.X_LS.p - Vector3(1.3, 2, 3)).norm(), 0, 1e-15);
  EXPECT_EQ(i.noise_rate, 0.3);
  EXPECT_EQ(i.noise_specific_force, 0.4);
  EXPECT_EQ(i.noise_orientation, 0.5);
}

/// Sensors look, they do not change: not the drives that hold a published robot, and no bit of its motion.
TEST(Sensors, LeaveTheRobotAsItIs) {
  const SceneDef with = loadText(armWith(wrench("ft", "wrist")), kNoPointer), without = loadText(armWith(""), kNoPointer);
  World a(with.world), b(without.world);
  for (int i = 0; i < 100; ++i) a.step(), b.step();
  EXPECT_EQ(a.hash(), b.hash());
}

TEST(Sensors, AreReadStrictly) {
  const struct {
    std::string tag;
    std::vector<std::string> words;
  } cases[] = {
      {"<haptic:sensor type=\"wrench\" joint=\"wrist\"/>", {":12", "name"}},
      {"<haptic:sensor name=\"a b\" type=\"wrench\" joint=\"wrist\"/>", {":12", "a b", "letter"}},
      {"<haptic:sensor name=\"a\" type=\"force\"/>", {":12", "force", "wrench, contact, imu"}},
      {"<haptic:sensor name=\"a\" type=\"wrench\"/>", {":12", "joint"}},
      {"<haptic:sensor name=\"a\" type=\"wrench\" joint=\"x\"/>", {":12", "'x'", "does not exist"}},
      {"<haptic:sensor name=\"a\" type=\"imu\" link=\"x\"/>", {":12", "'x'", "does not exist"}},
      {"<haptic:sensor name=\"a\" type=\"contact\" link=\"tip\" with=\"x\"/>", {":12", "'x'", "does not exist"}},
      {"<haptic:sensor name=\"a\" type=\"imu\" link=\"tip\" noise_force=\"1\"/>", {":12", "noise_force"}},
      {wrench("a", "wrist", "noise_force=\"-1\""), {":12", "'a'", "noise_force", "negative"}},
      {wrench("a", "wrist", "rate=\"0\""), {":12", "rate"}},
      {wrench("a", "wrist", "rate=\"fast\""), {":12", "rate"}},
      {wrench("a", "wrist", "seed=\"0.5\""), {":12", "seed"}},
      {wrench("a", "wrist") + wrench("a", "end"), {":13", "'a'", "twice"}},
      {"<haptic:sensor name=\"a\" type=\"imu\" link=\"tip\"><x/><haptic:y/></haptic:sensor>", {":12", "haptic:y"}},
  };
  for (const auto& bad : cases) {
    const std::string message = refusal(armWith(bad.tag), kNoPointer);
    EXPECT_NE(message, "") << bad.tag;
    for (const std::string& word : bad.words) EXPECT_NE(message.find(word), std::string::npos) << message << " lacks " << word;
  }
  const std::string floating = robot("<link name=\"world\"/>" + boxLink("b") + joint("f", "floating", "world", "b", "") + wrench("a", "f"));
  EXPECT_NE(refusal(floating, kNoPointer).find("carries nothing"), std::string::npos);
}

/// What robots for Gazebo have becomes ours, each as its own tag would; the rest is named and refuses nothing.
TEST(Sensors, ThoseOfGazeboAreRead) {
  const std::string gazebo = R"(
<gazebo reference="tool"><sensor type="imu" name="body-imu"><update_rate>200</update_rate><pose>0 0 0.1 0 0 0.5</pose>
 <imu><angular_velocity><x><noise type="gaussian"><mean>0</mean><stddev>2e-4</stddev></noise></x></angular_velocity></imu></sensor></gazebo>
<gazebo reference="tip"><sensor name="touch" type="contact"><contact><collision>tip_collision</collision></contact></sensor></gazebo>
<gazebo reference="wrist"><sensor name="ft" type="force_torque"><update_rate>0</update_rate>
 <force_torque><frame>child</frame><measure_direction>parent_to_child</measure_direction></force_torque></sensor></gazebo>
<gazebo reference="end"><sensor name="ft" type="force_torque"/></gazebo>
<gazebo reference="arm"><sensor name="eye" type="camera"/><sensor name="odd" type="imu"><pose>1 2</pose></sensor></gazebo>
<gazebo reference="nowhere"><sensor name="lost" type="imu"/></gazebo>
<gazebo><plugin name="control" filename="x.so"/></gazebo>
)";
  const std::string tags = "<haptic:sensor name=\"a\" type=\"imu\" link=\"tool\" rate=\"200\" xyz=\"0 0 0.1\" rpy=\"0 0 0.5\" "
                           "noise_angular_rate=\"2e-4\"/><haptic:sensor name=\"b\" type=\"contact\" link=\"tip\"/>" +
                           wrench("c", "wrist") + wrench("d", "end");
  const SceneDef theirs = loadText(armWith(gazebo), kNoPointer), ours = loadText(armWith(tags), kNoPointer);
  ASSERT_EQ(theirs.world.sensors.size(), 4u);
  const char* names[] = {"body_imu", "touch", "ft", "end_ft"};
  for (int i = 0; i < 4; ++i) {
    const SensorDef &a = theirs.world.sensors[i], &b = ours.world.sensors[i];
    EXPECT_EQ(a.name, names[i]);
    EXPECT_EQ(a.kind, b.kind);
    EXPECT_EQ(a.articulation, b.articulation);
    EXPECT_EQ(a.link, b.link);
    EXPECT_EQ(a.X_LS.p, b.X_LS.p);
    EXPECT_EQ(a.X_LS.R, b.X_LS.R);
    EXPECT_EQ(a.on_part, b.on_part);
    EXPECT_EQ(a.rate, b.rate);
    EXPECT_EQ(a.noise_rate, b.noise_rate);
  }
  std::string notes, warnings;
  for (const std::string& note : theirs.notes) notes += note + "\n";
  for (const std::string& warning : theirs.warnings) warnings += warning + "\n";
  EXPECT_NE(notes.find("ignored: Gazebo's sensors 'eye' of line"), std::string::npos) << notes;
  for (const char* part : {"(type camera)", "'odd'", "(its pose is no six numbers)", "'lost'", "(no link 'nowhere')"}) {
    EXPECT_NE(notes.find(part), std::string::npos) << part;
  }
  EXPECT_NE(warnings.find("the wrench of 'end_ft' is that on the child"), std::string::npos) << warnings;
  EXPECT_EQ(warnings.find("'ft'"), std::string::npos) << "this one says parent_to_child";
  World(theirs.world).step();
}

}  // namespace sensor_test
}  // namespace haptic
