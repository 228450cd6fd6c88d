// Inertias of files as joints excite them: what no motion meets stays as it is, what one needs is replaced and said.
#include <gtest/gtest.h>

#include <cmath>

#include "haptic_core/world/world.h"
#include "temporary_files.h"

namespace haptic {
namespace inertia_test {

std::string link(const std::string& name, const std::string& mass, const std::string& moments, const std::string& rest = "",
                 const std::string& com = "0 0 0") {
  return "<link name=\"" + name + "\"><inertial><origin xyz=\"" + com + "\"/><mass value=\"" + mass + "\"/><inertia " + moments +
         "/></inertial>" + rest + "</link>\n";
}

std::string moments(const std::string& x, const std::string& y, const std::string& z) {
  return "ixx=\"" + x + "\" iyy=\"" + y + "\" izz=\"" + z + "\" ixy=\"0\" ixz=\"0\" iyz=\"0\"";
}

std::string axis(const std::string& xyz, const std::string& limits = "lower=\"-4\" upper=\"4\"") {
  return "<axis xyz=\"" + xyz + "\"/><limit " + limits + " effort=\"0\" velocity=\"1\"/>";
}

SceneDef load(const std::string& inside) {
  SceneOptions options;
  options.add_pointer = false;
  return loadText(robot(inside), options);
}

/// Velocity of the last joint after one step from rest, by the step: its acceleration.
double firstAcceleration(SceneDef scene, const std::string& name) {
  World world(scene.world);
  world.step();
  const Twist V = world.linkTwist(world.linkIndex(name));
  return (V.angular.norm() > 0 ? V.angular.norm() : V.linear.norm()) / scene.world.settings.step;
}

const std::string kBox = "<collision><geometry><box size=\"0.1 0.1 0.1\"/></geometry></collision>";

TEST(Inertia, AFingerWithOneMomentSlidesAsItsMassSays) {
  const SceneDef scene = load(boxLink("base") + link("finger", "0.08", moments("0.002", "0", "0"), kBox) +
                              joint("slide", "prismatic", "base", "finger", axis("0 0 1", "lower=\"-9\" upper=\"9\"")));
  EXPECT_TRUE(scene.replaced.empty()) << sceneText(scene);
  EXPECT_NEAR(firstAcceleration(scene, "finger"), scene.world.settings.gravity.norm(), 1e-12);
}

/// A pendulum of two crossed axes: the link between them weighs nothing, and the body falls about the first one alone.
TEST(Inertia, AMasslessLinkBetweenTwoJointsStaysMassless) {
  const std::string body = link("body", "2", moments("0.01", "0.02", "0.03"), "", "0.3 0 0");
  for (const std::string cross : {std::string("<link name=\"cross\"/>"), link("cross", "0", moments("0", "0", "0")),
                                  link("cross", "1e-12", moments("1e-15", "1e-15", "1e-15"))}) {
    const SceneDef scene = load(boxLink("base") + cross + body + joint("first", "revolute", "base", "cross", axis("0 1 0")) +
                                joint("second", "revolute", "cross", "body", axis("1 0 0"), "0 0 0"));
    EXPECT_TRUE(scene.replaced.empty()) << sceneText(scene);
    EXPECT_EQ(scene.world.articulations[0].links[1].inertia.mass, 0);
    const double g = scene.world.settings.gravity.norm(), expected = 2 * g * 0.3 / (0.02 + 2 * 0.3 * 0.3);
    EXPECT_NEAR(firstAcceleration(scene, "body"), expected, 1e-9 * expected);
  }
}

/// Three axes through one point: where the second one can bring the others in line, nothing resists their common turn.
TEST(Inertia, WhatOnlySomePoseLeavesWithoutInertiaIsSeen) {
  const auto wrist = [](const std::string& limits) {
    return load(boxLink("base") + "<link name=\"a\"/><link name=\"b\"/>" + link("c", "1", moments("0.01", "0.01", "0.01")) +
                joint("one", "revolute", "base", "a", axis("0 0 1")) + joint("two", "revolute", "a", "b", axis("0 1 0", limits), "0 0 0") +
                joint("three", "revolute", "b", "c", axis("1 0 0"), "0 0 0"));
  };
  EXPECT_TRUE(wrist("lower=\"-1.2\" upper=\"1.2\"").replaced.empty());
  EXPECT_TRUE(mentions(wrist("lower=\"-1.6\" upper=\"1.6\"").replaced, "joint 'one' can move what has no inertia"));
}

TEST(Inertia, WhatAMotionNeedsComesFromTheShapesOrIsABall) {
  // The solid's moments, m a²/6 about each axis.
  SceneDef scene =
      load(boxLink("base") + link("arm", "3", moments("0", "0", "0"), kBox) + joint("j", "revolute", "base", "arm", axis("0 1 0")));
  EXPECT_TRUE(mentions(scene.replaced, "that of its shapes with 3 kg")) << sceneText(scene);
  EXPECT_NEAR((scene.world.articulations[0].links[1].inertia.I_C - Matrix3(3 * 0.01 / 6 * Matrix3::Identity())).norm(), 0, 1e-16);
  scene = load(boxLink("base") + link("arm", "3", moments("1", "-1", "1")) + joint("j", "revolute", "base", "arm", axis("0 1 0")));
  EXPECT_TRUE(mentions(scene.replaced, "<inertia> iyy=\"-1\": the link's mass is spread over its shapes, or over a ball of 20 mm"))
      << sceneText(scene);
  EXPECT_NEAR(scene.world.articulations[0].links[1].inertia.I_C(1, 1), 0.4 * 3 * 0.02 * 0.02, 1e-18);
  scene = load(boxLink("base") + "<link name=\"tip\"/>" + joint("j", "revolute", "base", "tip", axis("0 1 0")));
  EXPECT_TRUE(mentions(scene.replaced, "link 'tip'")) << sceneText(scene);
  scene = load(link("a", "0", moments("1", "1", "1")) + "<link name=\"world\"/>" + boxLink("b") + joint("j", "floating", "world", "a", "") +
               joint("k", "fixed", "world", "b", ""));
  EXPECT_TRUE(mentions(scene.replaced, "link 'a'")) << sceneText(scene);
  scene = load(boxLink("base") + link("rotor", "0", moments("1", "1", "1")) + joint("j", "revolute", "base", "rotor", axis("0 1 0")));
  EXPECT_TRUE(scene.replaced.empty()) << sceneText(scene);  // a rotor without weight
}

/// Slender, light and long trees have inertia everywhere, far from any threshold.
TEST(Inertia, SoundTreesAreLeftAlone) {
  std::string chain = boxLink("l0");
  for (int i = 1; i < 60; ++i) {
    const std::string name = "l" + std::to_string(i);
    chain += link(name, i % 2 ? "1e-3" : "1", moments("1e-9", "1e-4", "1e-4")) +
             joint("j" + std::to_string(i), "revolute", "l" + std::to_string(i - 1), name, axis(i % 3 ? "1 0 0" : "0 1 0"), "0.1 0 0");
  }
  const SceneDef scene = load(chain);
  EXPECT_TRUE(scene.replaced.empty()) << sceneText(scene);
}

}  // namespace inertia_test
}  // namespace haptic
