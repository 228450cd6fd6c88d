// Closed chains in a world: what closes them does not matter, and they keep their energy.
#include "../../scenes/rings.h"

#include <gtest/gtest.h>

#include <cmath>

namespace haptic::test {
namespace rings_test {

using namespace scenes;

double energy(const World& world) { return world.report().energy.total(); }

TEST(Rings, AFreeRingKeepsItsEnergy) {
  const Matrix3 oblique = Quaternion(0.7, 0.3, -0.5, 0.4).normalized().toRotationMatrix();
  for (const LoopDef::Type closure : {LoopDef::Type::kPoint, LoopDef::Type::kHinge}) {
    World world(freeRing(12, closure, 30, oblique));
    world.step();
    const double start = energy(world);
    for (int i = 0; i < 2000; ++i) world.step();
    // Merson's formula loses h⁵ a step; each step closes gaps of up to 1e-10 m.
    EXPECT_NEAR(energy(world) / start, 1, 1e-5);
  }
}

/// A hinge's rows across a planar chain repeat those of its other hinges.
TEST(Rings, AChainOnSprocketsRunsAlikeHoweverItIsClosed) {
  double turned[2];
  for (const LoopDef::Type closure : {LoopDef::Type::kPoint, LoopDef::Type::kHinge}) {
    World world(rollerChain(closure));
    JointCommand command;
    command.drive = JointDef::Drive::kEffort;
    command.effort = 0.5;
    ASSERT_TRUE(world.setJointCommand(0, command));
    for (int i = 0; i < 500; ++i) {
      world.step();
      ASSERT_EQ(world.report().flags & (kNotConverged | kRunaway), 0u) << i;
    }
    turned[closure == LoopDef::Type::kHinge] = world.q()[0];
  }
  EXPECT_GT(turned[0], 1.5);  // [rad]: the drive against both dampers, 5 rad/s
  EXPECT_NEAR(turned[1], turned[0], 1e-6);
}

}  // namespace rings_test
}  // namespace haptic::test
