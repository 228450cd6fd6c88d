// Motions of joints from a file, and robots that hold their pose.
#include <gtest/gtest.h>

#include <cmath>

#include "haptic_core/world/world.h"
#include "temporary_files.h"

namespace haptic {
namespace joint_motion_test {

std::string twoJointArm() {
  const std::string limits = "<limit lower=\"-2\" upper=\"2\" effort=\"80\" velocity=\"5\"/>";
  return robot(boxLink("base", 1, 0.1) + boxLink("upper", 1, 0.1) + boxLink("lower", 0.5, 0.08) +
               joint("shoulder", "revolute", "base", "upper", "<axis xyz=\"0 1 0\"/>" + limits, "0 0 0.3") +
               joint("elbow", "revolute", "upper", "lower", "<axis xyz=\"0 1 0\"/>" + limits, "0.3 0 0"));
}

struct Arm {
  explicit Arm(const std::string& motion, const std::string& extra = "") {
    files.write("arm.urdf", twoJointArm());
    files.write("motion.csv", motion);
    list = files.write("arm.yaml",
                       "models:\n  - {file: arm.urdf, prefix: r_, motion: motion.csv" + extra + "}\n");
  }
  std::string refusal() const {
    try {
      loadScene(list);
    } catch (const SetupError& error) {
      return error.what();
    }
    return "";
  }
  TemporaryFiles files;
  std::string list;
};

TEST(JointMotion, DrivesFollowTheFile) {
  const Arm arm("# seconds, rad\ntime, elbow\n0.5, 0\n2.5, 1\n");
  World world(loadScene(arm.list).world);
  const int elbow = world.jointIndex("r_elbow"), shoulder = world.jointIndex("r_shoulder");
  ASSERT_GE(elbow, 0);
  while (world.time() < 1.5) world.step();
  // Half way, at half a radian per second; the compensation is that of the start, so that a few degrees of
  // sag remain.
  EXPECT_NEAR(world.joint(elbow).position, 0.5, 0.06);
  EXPECT_NEAR(world.joint(elbow).velocity, 0.5, 0.05);
  while (world.time() < 4) world.step();
  EXPECT_NEAR(world.joint(elbow).position, 1, 0.08);
  EXPECT_NEAR(world.joint(elbow).velocity, 0, 1e-3);
  EXPECT_NEAR(world.joint(shoulder).position, 0, 0.03);
  // After its last row others may command.
  ASSERT_TRUE(world.setJointCommand(elbow, {JointDef::Drive::kPosition, 0.2, 0, 0}));
  while (world.time() < 6) world.step();
  EXPECT_NEAR(world.joint(elbow).position, 0.2, 0.08);
}

TEST(JointMotion, RobotsHoldTheirPoseAgainstGravity) {
  const SceneDef scene = loadText(twoJointArm());
  World world(scene.world);
  while (world.time() < 2) world.step();
  for (int i = 0; i < world.jointCount(); ++i) EXPECT_NEAR(world.joint(i).position, 0, 1e-6);
}

/// Joints that start on a limit and are asked to stay there have only rounding to decide by.
TEST(JointMotion, AGripperHoldsItsLimitWithItsFollower) {
  const std::string slide = "<limit lower=\"0\" upper=\"0.04\" effort=\"20\" velocity=\"1\"/>";
  const SceneDef scene = loadText(
      robot(boxLink("palm", 1, 0.1) + boxLink("left", 0.1, 0.02) + boxLink("right", 0.1, 0.02) +
            joint("jl", "prismatic", "palm", "left", "<axis xyz=\"0 1 0\"/>" + slide, "0 0.03 0.08") +
            joint("jr", "prismatic", "palm", "right",
                  "<axis xyz=\"0 -1 0\"/>" + slide + "<mimic joint=\"jl\"/>", "0 -0.03 0.08")));
  for (const Attempts attempts : {Attempts::kImplicitEuler, Attempts::kAll}) {
    WorldDef def = scene.world;
    def.settings.attempts = attempts;
    def.settings.gravity = Vector3(0.1, 0.3, -9.8);
    World world(def);
    for (int i = 0; i < 500; ++i) {
      world.step();
      ASSERT_EQ(world.report().flags, 0u) << i;
    }
    EXPECT_NEAR(world.joint(0).position, world.joint(1).position, 1e-9);
  }
}

TEST(JointMotion, PublishedRobotsHoldStill) {
  namespace fs = std::filesystem;
  const char* chosen = std::getenv("HAPTIC_ROBOTS");
  const fs::path folder =
      chosen ? fs::path(chosen) : fs::path(HAPTIC_SCENES) / "../../../shared/example-robot-data";
  std::error_code code;
  int tried = 0;
  for (fs::recursive_directory_iterator entry(folder, code), end; !code && entry != end;
       entry.increment(code)) {
    if (entry->path().extension() != ".urdf") continue;
    const SceneDef scene = loadScene(entry->path().string());
    World world(scene.world);
    std::vector<double> start;
    for (int i = 0; i < world.jointCount(); ++i) start.push_back(world.joint(i).position);
    for (int i = 0; i < 1000; ++i) {
      world.step();
      ASSERT_EQ(world.report().flags, 0u) << entry->path() << " step " << i;
    }
    for (int i = 0; i < world.jointCount(); ++i) {
      if (world.obeysCommands(i)) EXPECT_NEAR(world.joint(i).position, start[i], 1e-3) << world.jointName(i);
    }
    ++tried;
  }
  if (tried == 0) GTEST_SKIP() << "no robots below " << folder << "; set HAPTIC_ROBOTS";
}

/// A quadruped of twelve driven joints, dropped on a floor: stands or falls, but neither flies nor breaks.
TEST(JointMotion, AQuadrupedLandsOnTheFloor) {
  const std::string limits =
      "<limit lower=\"-2\" upper=\"2\" effort=\"60\" velocity=\"10\"/><dynamics damping=\"0.05\"/>";
  std::string text = boxLink("trunk", 8, 0.2);
  for (int leg = 0; leg < 4; ++leg) {
    const std::string n = std::to_string(leg), x = leg < 2 ? "0.15" : "-0.15", y = leg % 2 ? "0.12" : "-0.12";
    text += boxLink("hip" + n, 0.4, 0.05) + boxLink("thigh" + n, 0.6, 0.05) + boxLink("foot" + n, 0.2, 0.04);
    text += joint("a" + n, "revolute", "trunk", "hip" + n, "<axis xyz=\"1 0 0\"/>" + limits,
                  x + " " + y + " -0.05");
    text += joint("b" + n, "revolute", "hip" + n, "thigh" + n, "<axis xyz=\"0 1 0\"/>" + limits, "0 0 -0.12");
    text +=
        joint("c" + n, "revolute", "thigh" + n, "foot" + n, "<axis xyz=\"0 1 0\"/>" + limits, "0 0 -0.15");
  }
  const TemporaryFiles files;
  files.write("dog.urdf", robot(text));
  files.write("floor.urdf",
              robot("<link name=\"world\"/><link name=\"floor\"><collision><geometry><box size=\"4 4 0.2\"/>"
                    "</geometry></collision></link>" +
                    joint("f", "fixed", "world", "floor", "", "0 0 -0.1")));
  const SceneDef scene = loadScene(
      files.write("scene.yaml",
                  "models:\n  - {file: floor.urdf}\n  - {file: dog.urdf, base: floating, drive: hold, pose: "
                  "{xyz: [0, 0, 0.45], rpy: [0.1, 0.05, 0]}}\n"));
  for (const Attempts attempts :
       {Attempts::kImplicitEuler, Attempts::kSdirk2,
        Attempts::kAll}) {
    WorldDef def = scene.world;
    def.settings.attempts = attempts;
    World world(def);
    const int trunk = world.linkIndex("trunk");
    double highest = 0;
    int touching = 0;
    while (world.time() < 1.5) {
      world.step();
      ASSERT_TRUE(world.report().finite);
      highest = std::max(highest, world.linkPose(trunk).p.z());
      touching = std::max(touching, world.contactCount());
    }
    EXPECT_LT(highest, 0.46);
    EXPECT_GE(touching, 2);
    EXPECT_LT(world.linkTwist(trunk).linear.norm(), 1);
    EXPECT_GT(world.linkPose(trunk).p.z(), 0.05);
  }
}

TEST(JointMotion, MistakesAreNamedWithTheirLine) {
  EXPECT_NE(Arm("time,wrist\n0,1\n").refusal().find("motion.csv:1: the model has no joint 'wrist'"),
            std::string::npos);
  EXPECT_NE(Arm("t,elbow\n0,1\n").refusal().find("motion.csv:1"), std::string::npos);
  EXPECT_NE(Arm("time,elbow\n0,1\n1,nan\n").refusal().find("motion.csv:3: column 2"), std::string::npos);
  EXPECT_NE(Arm("time,elbow\n0,1\n1\n").refusal().find("motion.csv:3"), std::string::npos);
  EXPECT_NE(Arm("time,elbow\n0,1\n0,1\n").refusal().find("does not rise"), std::string::npos);
  EXPECT_NE(Arm("time,elbow\n").refusal().find("no row"), std::string::npos);
}

}  // namespace joint_motion_test
}  // namespace haptic
