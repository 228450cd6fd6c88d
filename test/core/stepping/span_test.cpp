// Nothing fast passes through anything thin, and no other island is cut for it.
#include <gtest/gtest.h>

#include "../../scenes/blocks.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace span_test {

using namespace scenes;

constexpr double kThickness = 1e-3;  // [m]

/// A wall across x = 0.
ArticulationDef thinWall() { return staticBox("wall", Vector3(kThickness, 1, 1), Pose()); }

WorldDef emptyWorld() {
  WorldDef def;
  def.settings.gravity.setZero();
  def.settings.default_material.stiffness = 1e10;
  return def;
}

/// A cube that slides on the floor goes the same way, bit for bit, whether a bullet meets a wall beside it or not.
TEST(Span, TheStepOfOthersIsNotCut) {
  CubeParameters c;
  const auto make = [&](double bullet_speed) {
    WorldDef def = cubeOnFloor(c, WorldSettings{});
    def.settings.default_material.stiffness = 1e10;
    def.articulations[1].V_WA.linear = Vector3(0, 1, 0);
    def.articulations.push_back(staticBox("wall", Vector3(kThickness, 1, 1), Pose(Vector3(10, 0, 2))));
    const Twist V{Vector3::Zero(), Vector3(bullet_speed, 0, 0)};
    def.articulations.push_back(freeBox("bullet", Vector3::Constant(0.01), 0.01, Pose(Vector3(8.9, 0, 2)), V));
    return def;
  };
  World shot(make(100)), quiet(make(0));
  int cut = 0;
  for (int i = 0; i < 30; ++i) {
    shot.step();
    quiet.step();
    cut += shot.report().parts > 1;
    ASSERT_EQ(shot.linkPose(1).p, quiet.linkPose(1).p) << i;
    ASSERT_EQ(shot.linkTwist(1).vector(), quiet.linkTwist(1).vector()) << i;
  }
  EXPECT_GT(cut, 0);
  EXPECT_LT(shot.linkPose(3).p.x(), 10) << "the bullet is through the wall";
}

/// It flies on both sides of the wall within one step: an attempt that looks at its two ends alone takes it through.
TEST(Span, ABulletThatTouchesNothingAtEitherEndIsStopped) {
  for (const double start : {-0.02, -0.05, -0.09}) {
    WorldDef def = emptyWorld();
    def.articulations.push_back(thinWall());
    const Twist V{Vector3::Zero(), Vector3(100, 0, 0)};
    def.articulations.push_back(freeBox("bullet", Vector3::Constant(0.01), 0.01, Pose(Vector3(start, 0, 0)), V));
    World world(def);
    world.step();
    EXPECT_EQ(world.report().flags & (kTooFast | kNotConverged), 0u);
    for (int i = 0; i < 5; ++i) world.step();
    EXPECT_LT(world.linkPose(1).p.x(), 0) << start;
  }
}

/// A hand's tool that shall be on the other side of a wall within a step stays on this side, and presses; so does one that shall pass
/// through the tool of another hand.
TEST(Span, ATooFastToolStopsShort) {
  for (const bool other : {false, true}) {
    WorldDef def = emptyWorld();
    def.articulations.push_back(other ? freeBox("wall", Vector3(kThickness, 1, 1), 1, Pose()) : thinWall());
    def.articulations.push_back(freeBox("tool", Vector3::Constant(0.01), 0.1, Pose(Vector3(-0.03, 0, 0))));
    for (const int held : {1, 0}) {
      if (held == 0 && !other) continue;
      PointerDef pointer;
      pointer.device = held == 1 ? "right" : "left";
      pointer.articulation = held;
      pointer.link = 0;
      def.pointers.push_back(pointer);
    }
    World world(def);
    PointerBound bound;
    bound.force = 10;
    bound.stiffness = 4000;
    world.setPointerBound(0, bound);
    double first = 0;  // force of the step in which it touches [N]
    for (int i = 0; i < 200; ++i) {
      world.setPointerTarget(0, Pose(Vector3(0.03, 0, 0)), Twist{});
      if (other) world.setPointerTarget(1, Pose(), Twist{});
      world.step();
      ASSERT_LT(world.linkPose(1).p.x(), 0) << i;
      if (first == 0) first = world.pointerWrench(0).force.norm();
    }
    // It enters by a fiftieth of the thickness, of which the hand feels the stiffness that it bears: a quarter of it gave 1 N.
    EXPECT_GT(first, 0);
    EXPECT_LT(first, bound.stiffness * 0.05 * kThickness);
    // A weakened contact is at most half as deep as the wall is thick (held_proxy.h).
    EXPECT_NEAR(world.pointerWrench(0).force.x(), -bound.stiffness * 0.5 * kThickness, 1e-3);
  }
}

}  // namespace span_test
}  // namespace haptic
