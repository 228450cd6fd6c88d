#include "haptic_core/world/world.h"

#include <gtest/gtest.h>

#include "../../scenes/blocks.h"
#include "haptic_core/base/error.h"

namespace haptic {
namespace world_test {

using namespace scenes;

TEST(World, CubeRestsAtTheDepthThatCarriesIt) {
  CubeParameters c;
  WorldSettings s;
  s.pressure_law = PressureLaw::kLinear;
  World world(cubeOnFloor(c, s, 1e-4));
  for (int i = 0; i < 2000; ++i) world.step();
  ASSERT_EQ(world.contactCount(), 1);
  EXPECT_NEAR(world.contact(0).normal_force, c.mass * kGravity, 1e-9);
  EXPECT_NEAR(world.contact(0).depth, c.restDepth(), 1e-9 * c.restDepth() + 1e-15);
  EXPECT_TRUE(world.contact(0).sticking);
}

TEST(World, SaveAndRestoreContinueWithTheSameBits) {
  CubeParameters c;
  WorldDef def = stack(4, c, WorldSettings{}, 1e-3);
  def.articulations[4].V_WA.linear = Vector3(0.1, 0.05, 0);
  World one(def), two(def);
  for (int i = 0; i < 300; ++i) one.step();
  two.restore(one.save());
  EXPECT_EQ(one.hash(), two.hash());
  for (int i = 0; i < 300; ++i) {
    one.step();
    two.step();
    ASSERT_EQ(one.hash(), two.hash()) << "step " << i;
  }
}

TEST(World, PointerFeelsTheFloorAndTheFloorItsWeight) {
  CubeParameters c;
  WorldDef def = cubeOnFloor(c, WorldSettings{});
  PointerDef pointer;
  pointer.articulation = 1;
  pointer.link = 0;
  def.pointers.push_back(pointer);
  World world(def);
  const double depth = 1e-4;
  for (int i = 0; i < 5; ++i) {
    world.setPointerTarget(0, Pose(Vector3(0, 0, c.size / 2 - depth)), Twist{});
    world.step();
  }
  EXPECT_NEAR(world.pointerWrench(0).force.z(), c.stiffness * c.area() * depth, 1e-9);
}

/// A cube in a hand, pressed into a fixed floor: nothing is there to be solved, and the hand feels k A d all the same.
TEST(World, AHeldBodyFeelsAFixedOneWithEveryIntegrator) {
  for (const Attempts attempts : {Attempts::kImplicitEuler, Attempts::kSdirk2, Attempts::kAll}) {
    scenes::CubeParameters c;
    WorldSettings settings;
    settings.attempts = attempts;
    WorldDef def = scenes::cubeOnFloor(c, settings);
    PointerDef hand;
    hand.articulation = 1;
    hand.link = 0;
    def.pointers.push_back(hand);
    World world(def);
    const double depth = 1e-4;
    for (int i = 0; i < 5; ++i) {
      world.setPointerTarget(0, Pose(Vector3(0, 0, c.size / 2 - depth)), Twist{});
      world.step();
    }
    const double force = c.stiffness * c.area() * depth;
    EXPECT_NEAR(world.pointerWrench(0).force.z(), force, 1e-9 * force) << static_cast<int>(attempts);
    EXPECT_EQ(world.contactCount(), 1);
  }
}

}  // namespace world_test
}  // namespace haptic
