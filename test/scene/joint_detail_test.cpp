/// Limits of joints that follow, springs, couplings per axis, and what of a URDF is of no use.
#include <gtest/gtest.h>

#include <cmath>

#include "haptic_core/world/world.h"
#include "temporary_files.h"

namespace haptic {
namespace joint_detail_test {

const SceneOptions kNoPointer = {0, "", {}, false};

std::string limits(double lower, double upper) {
  return "<axis xyz=\"0 0 1\"/><limit lower=\"" + std::to_string(lower) + "\" upper=\"" + std::to_string(upper) +
         "\" effort=\"1\" velocity=\"1\"/>";
}

/// A joint of −1…1 and one that follows it.
SceneDef follower(double lower, double upper, const std::string& mimic, const std::string& first = "") {
  return loadText(robot(boxLink("base") + boxLink("a") + boxLink("b") + joint("ja", "revolute", "base", "a", limits(-1, 1) + first) +
                        joint("jb", "revolute", "base", "b", limits(lower, upper) + "<mimic joint=\"ja\" " + mimic + "/>")),
                  kNoPointer);
}

const JointDef& jointOf(const SceneDef& scene, std::size_t link) { return scene.world.articulations.at(0).links.at(link).joint; }

TEST(Followers, LimitTheJointThatTheyFollow) {
  // −0.2 … 0.5 = −2 q + 0.1, so that q = −0.2 … 0.15.
  const SceneDef scene = follower(-0.2, 0.5, "multiplier=\"-2\" offset=\"0.1\"");
  EXPECT_NEAR(jointOf(scene, 1).lower, -0.2, 1e-15);
  EXPECT_NEAR(jointOf(scene, 1).upper, 0.15, 1e-15);
  EXPECT_TRUE(mentions(scene.notes, "'jb' follows 'ja' and limits it to -0.2…0.15"));
  // It stops there.
  SceneDef driven = scene;
  JointDef& joint = driven.world.articulations[0].links[1].joint;
  joint.drive = JointDef::Drive::kEffort;
  joint.drive_effort = 1;
  World world(driven.world);
  for (int i = 0; i < 3000; ++i) world.step();
  EXPECT_NEAR(world.joint(world.jointIndex("jb")).position, -0.2, 1e-9);
}

TEST(Followers, StartWithinTheirLimits) {
  const SceneDef scene = follower(0.3, 0.5, "", "<haptic:joint position=\"-0.5\"/>");
  EXPECT_EQ(jointOf(scene, 1).position, 0.3);
  EXPECT_EQ(jointOf(scene, 2).position, 0.3);
  EXPECT_TRUE(mentions(scene.notes, "it starts at 0.3"));
}

TEST(Followers, LimitsThatLeaveNothingOrSayTheSameAreNoLimits) {
  const SceneDef none = follower(0, 0, "");  // as exporters write what is not set
  EXPECT_EQ(jointOf(none, 1).lower, -1);
  EXPECT_EQ(jointOf(none, 1).upper, 1);
  const SceneDef apart = follower(2, 3, "");
  EXPECT_EQ(jointOf(apart, 1).upper, 1);
  EXPECT_TRUE(mentions(apart.warnings, "no position is within the limits of both"));
  const SceneDef digits = follower(-0.9999, 1, "");
  EXPECT_EQ(jointOf(digits, 1).lower, -1);
  EXPECT_FALSE(mentions(digits.notes, "limits it"));
}

TEST(Ignored, StandsInOneLine) {
  const SceneDef scene = loadText(
      robot(boxLink("base") + boxLink("a") + boxLink("b") +
            joint("ja", "revolute", "base", "a", limits(-1, 1) + "<safety_controller k_velocity=\"1\"/><calibration rising=\"0\"/>") +
            joint("jb", "revolute", "base", "b", limits(-1, 1) + "<safety_controller k_velocity=\"1\"/><mimic joint=\"ja\"/>") +
            "<transmission name=\"t\"/>"),
      kNoPointer);
  int lines = 0;
  for (const std::string& note : scene.notes) {
    if (note.find("ignored: ") == std::string::npos) continue;
    ++lines;
    for (const char* word : {"2 <safety_controller>", "1 <calibration>", "1 <transmission>", "1 effort limits of joints that follow"}) {
      EXPECT_NE(note.find(word), std::string::npos) << note;
    }
  }
  EXPECT_EQ(lines, 1);
  EXPECT_FALSE(mentions(follower(-1, 1, "").notes, "safety_controller"));
}

TEST(Springs, AreReadAndHeldAgainst) {
  const std::string inside = limits(-1, 1) + "<haptic:joint spring_stiffness=\"2\" spring_position=\"0.3\"/>";
  const SceneDef scene = loadText(robot(boxLink("base") + boxLink("a") + joint("ja", "revolute", "base", "a", inside)), kNoPointer);
  EXPECT_EQ(jointOf(scene, 1).spring_stiffness, 2);
  EXPECT_EQ(jointOf(scene, 1).spring_position, 0.3);
  const auto refused = [](const std::string& attributes, const std::string& type = "revolute") {
    const std::string inside = limits(-1, 1) + "<haptic:joint " + attributes + "/>";
    return refusal(robot(boxLink("base") + boxLink("a") + joint("ja", type, "base", "a", inside)), kNoPointer);
  };
  EXPECT_NE(refused("spring_stiffness=\"-1\"").find(":5: joint 'ja': its spring has a negative stiffness"), std::string::npos);
  EXPECT_NE(refused("spring_stiffness=\"soft\"").find("spring_stiffness"), std::string::npos);
  EXPECT_NE(refused("spring_stiffness=\"1\"", "planar").find("one degree"), std::string::npos);
}

const char kM20[] = "thread_diameter=\"0.018376\" thread_friction=\"0.15\"";

TEST(Screws, SlideByTheirLeadAndTellWhenTheyLock) {
  const std::string inside = limits(-1, 1) + "<haptic:joint lead=\"-0.0025\" position=\"0.5\" " + kM20 + "/>";
  const SceneDef scene = loadText(robot(boxLink("base") + boxLink("a") + joint("ja", "revolute", "base", "a", inside)), kNoPointer);
  const JointDef &slide = jointOf(scene, 1), &turn = jointOf(scene, 2);
  EXPECT_EQ(slide.name, "ja_slide");
  EXPECT_EQ(slide.type, JointType::kPrismatic);
  EXPECT_EQ(slide.axis, turn.axis);
  EXPECT_EQ(slide.mimic_joint, 2);
  EXPECT_NEAR(slide.mimic_multiplier, -0.0025 / (2 * M_PI), 1e-18);
  EXPECT_NEAR(slide.position, 0.5 * slide.mimic_multiplier, 1e-18);
  EXPECT_EQ(slide.thread_friction, 0.15);
  EXPECT_EQ(slide.thread_radius, 0.009188);
  EXPECT_NEAR(slide.thread_flank, M_PI / 6, 1e-15);
  EXPECT_EQ(turn.thread_friction, 0);
  EXPECT_EQ(turn.position, 0.5);
  EXPECT_EQ(scene.world.articulations[0].links[1].inertia.mass, 0);
  EXPECT_TRUE(mentions(scene.notes, "screw 'ja': lead -2.5 mm, locks from a thread friction of 0.0375 on and has 0.15, efficiency 19.9 %"));
  World world(scene.world);  // nut and base overlap: they are as neighbours
  EXPECT_EQ(world.contactCount(), 0);
  for (int i = 0; i < 100; ++i) world.step();
  EXPECT_EQ(world.contactCount(), 0);
  EXPECT_NEAR(world.joint(world.jointIndex("ja_slide")).position, -0.5 * 0.0025 / (2 * M_PI), 1e-12);
}

TEST(Screws, AreCarriagesOnSpindlesToo) {
  const std::string links = boxLink("base") + boxLink("a") + boxLink("b") + joint("ja", "revolute", "base", "a", limits(-9, 9));
  const auto carriage = [&](const std::string& inside) {
    return robot(links + joint("jb", "prismatic", "base", "b", limits(-1, 1) + inside + "<haptic:joint " + kM20 + "/>"));
  };
  const SceneDef scene = loadText(carriage("<mimic joint=\"ja\" multiplier=\"0.0004\"/>"), kNoPointer);
  EXPECT_EQ(jointOf(scene, 2).mimic_joint, 1);
  EXPECT_EQ(jointOf(scene, 2).thread_friction, 0.15);
  EXPECT_TRUE(mentions(scene.notes, "screw 'ja': lead 2.51 mm"));
  EXPECT_NE(refusal(carriage(""), kNoPointer).find("it has a thread and is no screw"), std::string::npos);
}

TEST(Screws, ThatCannotBeAreRefused) {
  const auto refused = [](const std::string& attributes, const std::string& type = "revolute") {
    const std::string inside = limits(-1, 1) + "<haptic:joint " + attributes + "/>";
    return refusal(robot(boxLink("base") + boxLink("a") + joint("ja", type, "base", "a", inside)), kNoPointer);
  };
  EXPECT_NE(refused("lead=\"0.001\"", "prismatic").find(":5: joint 'ja': lead is for joints that turn"), std::string::npos);
  EXPECT_NE(refused(kM20).find("it has a thread and is no screw"), std::string::npos);
  EXPECT_NE(refused("lead=\"0.001\" thread_friction=\"0.1\"").find("thread_diameter > 0"), std::string::npos);
  EXPECT_NE(refused("lead=\"0.001\" thread_diameter=\"0.01\" thread_friction=\"-1\"").find("must be >= 0"), std::string::npos);
  EXPECT_NE(refused("lead=\"0.1\" thread_diameter=\"0.01\" thread_friction=\"0.4\"").find("0.4 holds its thread at every torque"),
            std::string::npos);
}

std::string pointerRobot(const std::string& attributes) {
  return robot("<link name=\"world\"/>" + boxLink("tool") + joint("f", "floating", "world", "tool", "") +
               "<haptic:pointer link=\"tool\" coupling=\"virtual\" " + attributes + "/>");
}

TEST(Couplings, HaveOneValueOrThree) {
  const SceneDef scene = loadText(pointerRobot("stiffness=\"100 200 0\" damping=\"3\" rotational_damping=\"0.1 0.2 0.4\" axes=\"grip\""));
  const PointerCoupling& c = scene.world.pointers.at(0).coupling;
  EXPECT_EQ(c.stiffness, 200);
  EXPECT_EQ(c.along_stiffness.share, Vector3(0.5, 1, 0));
  EXPECT_EQ(c.damping, 3);
  EXPECT_EQ(c.along_damping.share, Vector3::Ones());
  EXPECT_EQ(c.rotational_stiffness, PointerCoupling::kDerived);
  EXPECT_EQ(c.about_damping.share, Vector3(0.25, 0.5, 1));
  EXPECT_EQ(c.axes, PointerCoupling::Axes::kGrip);
  const std::pair<const char*, const char*> bad[] = {{"stiffness=\"1 2\"", "neither one number nor three"},
                                                     {"stiffness=\"1 2 -3\"", "neither one number nor three"},
                                                     {"damping=\"much\"", "neither one number nor three"},
                                                     {"axes=\"world\"", "known: link, grip"}};
  for (const auto& [attributes, words] : bad) {
    const std::string message = refusal(pointerRobot(attributes));
    EXPECT_NE(message.find(words), std::string::npos) << message;
    EXPECT_NE(message.find(".urdf:"), std::string::npos) << message;
  }
}

TEST(Couplings, AreListsInAList) {
  const TemporaryFiles files;
  files.write("tool.urdf", robot("<link name=\"world\"/>" + boxLink("tool") + joint("f", "floating", "world", "tool", "")));
  const auto list = [&](const std::string& entries) {
    const std::string head = "name: l\nmodels:\n  - {file: tool.urdf}\ndevices:\n  - {pointer: tool, coupling: virtual, ";
    return files.write("list.yaml", head + entries + "}\n");
  };
  const PointerCoupling c = loadScene(list("stiffness: [100, 50, 25], damping: 2, axes: grip")).world.pointers.at(0).coupling;
  EXPECT_EQ(c.stiffness, 100);
  EXPECT_EQ(c.along_stiffness.share, Vector3(1, 0.5, 0.25));
  EXPECT_EQ(c.damping, 2);
  EXPECT_EQ(c.axes, PointerCoupling::Axes::kGrip);
  EXPECT_THROW(loadScene(list("stiffness: [1, 2]")), SetupError);
}

}  // namespace joint_detail_test
}  // namespace haptic
