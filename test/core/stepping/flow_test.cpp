/// What nothing touches goes on by itself, and what touches is solved (Attempts::kAll).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "../../scenes/blocks.h"
#include "../../scenes/bounce.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace {

using scenes::kGravity;

WorldSettings flowing() {
  WorldSettings s;
  s.attempts = Attempts::kAll;
  return s;
}

// Closed form of a fall onto a floor that is looked at in the last steps. No step solves anything before the touch.
TEST(Flow, ABodyOverAFloorFallsOnAParabola) {
  constexpr double kFall = 0.03;  // [s]
  const scenes::CubeParameters c;
  World world(scenes::cubeOnFloor(c, flowing(), c.restDepth() + 0.5 * kGravity * kFall * kFall));
  const double start = world.linkPose(1).p.z(), h = world.settings().step;
  int steps = 0;
  for (int i = 1; i * h < kFall - 1e-9; ++i) {
    world.step();
    steps += world.report().evaluations;
    EXPECT_NEAR(world.linkPose(1).p.z(), start - 0.5 * kGravity * (i * h) * (i * h), 1e-14);
    EXPECT_NEAR(world.linkTwist(1).linear.z(), -kGravity * i * h, 1e-13);
  }
  EXPECT_EQ(steps, 0);
  for (int i = 0; i < 5; ++i) world.step();
  EXPECT_GT(world.report().evaluations, 0);
}

/// Two boxes on hinges, held at `height` over a floor that the lower one comes near and does not reach.
WorldDef pendulumOverFloor(double height) {
  constexpr double kLength = 0.15;
  WorldDef def = scenes::cubeOnFloor({}, flowing());
  ArticulationDef arm = scenes::cube("arm", {}, Pose());
  LinkDef link = arm.links[0];
  arm.links.clear();
  for (int i = 0; i < 2; ++i) {
    link.name = "link" + std::to_string(i);
    link.parent = i - 1;
    link.joint.type = JointType::kRevolute;
    link.joint.axis = Vector3::UnitY();
    link.joint.X_PJ = Pose(i == 0 ? Vector3(0, 0, height) : Vector3(kLength, 0, 0));
    link.joint.position = 0.3;
    arm.links.push_back(link);
  }
  def.articulations[1] = arm;
  return def;
}

// The floor is looked at, and changes no bit; nothing is lost, to the fourth order of the step.
TEST(Flow, ATreeNearAFloorMovesAsWithoutIt) {
  WorldDef def = pendulumOverFloor(0.2215), alone = def;
  alone.articulations.erase(alone.articulations.begin());
  World world(def), free(alone);
  int near = 0;
  double first = 0, most = 0;
  for (int i = 0; i < 1000; ++i) {
    world.step();
    free.step();
    near += world.report().pairs;
    ASSERT_EQ(world.report().evaluations, 0);
    for (int l = 0; l < 2; ++l) {
      ASSERT_EQ(world.linkPose(1 + l).p, free.linkPose(l).p) << "step " << i;
      ASSERT_EQ(world.linkTwist(1 + l).vector(), free.linkTwist(l).vector()) << "step " << i;
    }
    if (i == 0) first = free.report().energy.balance();
    most = std::max(most, std::abs(free.report().energy.balance() - first));
  }
  EXPECT_GT(near, 0);
  EXPECT_LT(most, 1e-7 * 0.2 * kGravity * 0.3);  // (ω h)⁴ of ω < 20 rad/s is 2e-7
}

// The effort that is read is that of the step that flowed, near other bodies and away from them: -d v within the change of v in a step.
TEST(Flow, AJointSaysTheEffortOfItsFlow) {
  constexpr double kDamping = 0.01;
  WorldDef near = pendulumOverFloor(0.2215);
  for (LinkDef& link : near.articulations[1].links) link.joint.damping = kDamping;
  WorldDef alone = near;
  alone.articulations.erase(alone.articulations.begin());
  for (const WorldDef& def : {near, alone}) {
    World world(def);
    double most = 0;
    for (int i = 0; i < 300; ++i) {
      const double before[2] = {world.joint(0).velocity, world.joint(1).velocity};
      world.step();
      for (int j = 0; j < 2; ++j) {
        const JointReading now = world.joint(j);
        EXPECT_NEAR(now.effort, -kDamping * now.velocity, kDamping * std::abs(now.velocity - before[j]) + 1e-9) << i;
        most = std::max(most, std::abs(now.effort));
      }
    }
    EXPECT_GT(most, 0.01);
  }
}

// An implicit step loses of a bounce that it resolves no more than the order of its accuracy, .03: up to two radians of the contact's swing
// in a step. Without cutting impacts out it is .43.
TEST(Flow, ABounceKeepsItsSpeed) {
  for (const double k_eff : {1e4, 5e4, 2e5}) {
    const scenes::Bounce bounce{PressureLaw::kLinear, 0, 0.1, k_eff};
    EXPECT_LE(scenes::worstExit(bounce, Attempts::kAll), 0.05) << k_eff;
  }
}

}  // namespace
}  // namespace haptic
