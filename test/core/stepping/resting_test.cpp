// Islands that rock slower than a stated bound are brought to rest: how far from equilibrium, what it costs in energy, and that
// nothing jumps when they wake.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "../../scenes/blocks.h"
#include "haptic_core/stepping/rest.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"

namespace haptic {
namespace resting_test {

using namespace scenes;

constexpr double kRocks = 1e-9;  // [m/s]
constexpr int kBodies = 4;

CubeParameters stiffCube() {
  CubeParameters c;
  c.stiffness = 1e8;
  return c;
}

/// The same world with velocities of its free bodies, as if they had always had them: `turn` [rad/s] and `way` [m/s] in all axes.
void setVelocities(World& world, double turn, double way) {
  State state = world.state();
  for (const ModelTree& tree : world.model().trees) {
    if (!tree.model->isFreeBody()) continue;
    for (int i = 0; i < 6; ++i) state.v[static_cast<std::size_t>(tree.v + i)] = i < 3 ? turn : way;
  }
  world.restore(state.pack());
}

/// Four cubes that stand, and have been slow for long enough.
std::unique_ptr<World> restingStack(WorldSettings settings = {}) {
  auto world = std::make_unique<World>(stack(kBodies, stiffCube(), settings));
  for (int i = 0; i < 400; ++i) world->step();
  EXPECT_EQ(world->report().standing, kBodies);
  return world;
}

/// Σ ½ m v² + ½ ω·I ω of cubes that all move alike [J].
double kineticOf(const CubeParameters& c, double turn, double way) {
  return kBodies * 0.5 * (c.mass * 3 * way * way + c.mass * c.size * c.size / 6 * 3 * turn * turn);
}

TEST(Resting, WhatRocksSlowerThanTheBoundIsBroughtToRestAndItsEnergyIsBooked) {
  const CubeParameters c = stiffCube();
  auto world = restingStack();
  const double before = world->report().energy.stilled, damped = world->report().energy.damping;
  std::vector<Pose> poses;
  for (int l = 1; l <= kBodies; ++l) poses.push_back(world->linkPose(l));
  setVelocities(*world, 2 * kRocks, kRocks);
  const double balance = world->state().energy.balance;  // with what moves now it is more by just that
  world->step();
  EXPECT_EQ(world->report().energy.stilled, world->state().energy.stilled);
  // Sums of four numbers each, beside what was booked before.
  const double moved = kineticOf(c, 2 * kRocks, kRocks);
  EXPECT_NEAR(world->report().energy.stilled - before, moved, 1e-15 * moved + 1e-16 * before);
  EXPECT_NEAR(world->report().energy.damping - damped, moved, 1e-15 * moved + 1e-16 * damped);
  EXPECT_NEAR(world->report().energy.balance(), balance, 1e-14) << "of joules that the balance sums";
  world->step();
  for (int l = 1; l <= kBodies; ++l) {
    EXPECT_EQ(world->linkPose(l).p, poses[static_cast<std::size_t>(l - 1)].p) << "it is not moved";
    EXPECT_EQ(world->linkTwist(l).linear, Vector3(0, 0, 0));
    EXPECT_TRUE(world->stands(l));
  }
}

TEST(Resting, WhatIsFasterThanTheBoundMovesOn) {
  auto world = restingStack();
  const double stilled = world->report().energy.stilled;
  const double bound = 1e-3 * world->settings().accuracy * world->settings().step * kGravity;
  setVelocities(*world, 0, 2 * bound);
  world->step();
  EXPECT_EQ(world->report().standing, 0);
  EXPECT_EQ(world->report().energy.stilled, stilled);
}

/// A cube that hangs off its equilibrium by less than the bound stands there; by more, it goes back.
TEST(Resting, NoForceBeyondTheShareOfTheWeightIsHeld) {
  CubeParameters c;  // of 316 rad/s: explicit steps
  for (const double share : {0.3, 30.0}) {
    World world(cubeOnFloor(c, WorldSettings{}));
    for (int i = 0; i < 1000; ++i) world.step();
    ASSERT_TRUE(world.stands(1));
    const double held = 1e-3 * world.settings().accuracy * c.mass * kGravity, off = share * held / (c.stiffness * c.area());
    State state = world.state();
    state.q[static_cast<std::size_t>(world.model().trees[1].q + 2)] += off;
    const double z = state.q[static_cast<std::size_t>(world.model().trees[1].q + 2)];
    world.restore(state.pack());
    world.step();
    EXPECT_EQ(world.report().standing, share < 1 ? 1 : 0) << share;
    EXPECT_EQ(world.linkPose(1).p.z() == z, share < 1) << share;
  }
}

/// Where static friction is more than sliding friction, instants of friction are looked for within the step of whatever moves.
TEST(Resting, WhatHasTwoLimitsOfFrictionStandsToo) {
  for (const double k : {1e6, 1e8}) {
    CubeParameters c;
    c.stiffness = k;
    c.mu_static = 0.6, c.mu_dynamic = 0.4;
    const double slope = 0.2;
    WorldSettings settings;
    settings.gravity = kGravity * Vector3(std::sin(slope), 0, -std::cos(slope));
    World world(cubeOnFloor(c, settings));
    for (int i = 0; i < 3000; ++i) world.step();
    EXPECT_EQ(world.report().standing, 1) << k;
    EXPECT_TRUE(world.stands(1));
    const double held = 1e-3 * settings.accuracy * c.mass * kGravity;
    EXPECT_NEAR(world.contact(0).F_BP_W.force.x(), -c.mass * kGravity * std::sin(slope), held);
  }
}

/// A cube falls past a corner of the stack: their boxes overlap, and the step that wakes the stack reports the wrenches of the last.
TEST(Resting, NoWrenchJumpsWhenSomethingComesNear) {
  WorldDef def = stack(kBodies, stiffCube(), WorldSettings{});
  const Matrix3 turned = rotationFromRpy(Vector3(0, 0, 0.25 * M_PI));
  def.articulations.push_back(cube("falls", stiffCube(), Pose(turned, Vector3(0.115, 0.115, 1.5))));
  World world(def);
  std::vector<Wrench> last;
  int woke = 0;
  while (world.linkPose(kBodies + 1).p.z() > 0.1) {
    const bool stood = world.stands(1);
    const std::vector<Wrench> before = last;
    world.step();
    last.clear();
    for (int i = 0; i < world.contactCount(); ++i) last.push_back(world.contact(i).F_BP_W);
    ASSERT_EQ(last.size(), static_cast<std::size_t>(kBodies));
    if (!stood || world.stands(1)) continue;
    ++woke;
    for (std::size_t i = 0; i < last.size(); ++i) {
      EXPECT_NEAR((last[i].force - before[i].force).norm(), 0, 1e-9);
      EXPECT_NEAR((last[i].torque - before[i].torque).norm(), 0, 1e-9);
    }
  }
  EXPECT_EQ(woke, 1);
}

/// Where the hand of a coupling pulls, nothing but rounding is left out.
TEST(Resting, NoBoundHoldsWhereAHandPulls) {
  WorldDef def = stack(kBodies, stiffCube(), WorldSettings{});
  PointerDef hand;
  hand.articulation = kBodies;
  hand.link = 0;
  hand.coupling.mode = PointerCoupling::Mode::kVirtual;
  def.pointers.push_back(hand);
  World world(def);
  const Pose top = world.linkPose(kBodies);
  for (int i = 0; i < 400; ++i) {
    world.setPointerTarget(0, top, Twist{});
    world.step();
  }
  const double stilled = world.report().energy.stilled;
  setVelocities(world, 0, kRocks);
  world.setPointerTarget(0, top, Twist{});
  world.step();
  EXPECT_EQ(world.report().energy.stilled, stilled);
}

/// A body that a hand takes and lets go has to be slow for the whole time once more.
TEST(Resting, WhatAHandHeldIsNotCalm) {
  WorldDef def = stack(kBodies, stiffCube(), WorldSettings{});
  PointerDef hand;
  hand.articulation = kBodies;
  hand.link = 0;
  def.pointers.push_back(hand);
  World world(def);
  for (int i = 0; i < 400; ++i) {
    world.setPointerTarget(0, Pose(Vector3(0, 0, 2)), Twist{});
    world.step();
  }
  const int below = world.model().links[kBodies - 1].articulation, top = world.model().links[kBodies].articulation;
  ASSERT_EQ(world.state().calm[below], stepping::kCalmSteps);
  EXPECT_EQ(world.state().calm[top], 0);
  world.grab(0, kBodies - 1);
  world.step();
  EXPECT_EQ(world.state().calm[below], 0);
}

/// Whether an island stands is no state: a world that is restored in the midst of it goes on bit for bit, and so does one that
/// leaves nothing out.
TEST(Resting, SaveRestoreAndReplayKnowNothingOfIt) {
  WorldDef def = stack(kBodies, stiffCube(), WorldSettings{});
  def.articulations.push_back(cube("falls", stiffCube(), Pose(Vector3(0.03, 0.02, 1.5))));
  World world(def);
  def.settings.leave_out = false;
  World general(def);
  const auto run = [](World& w, int steps) {
    for (int i = 0; i < steps; ++i) w.step();
  };
  for (World* w : {&world, &general}) run(*w, 200);
  setVelocities(world, kRocks, kRocks);
  setVelocities(general, kRocks, kRocks);
  for (World* w : {&world, &general}) run(*w, 100);
  ASSERT_GT(world.report().standing, 0);
  ASSERT_GT(world.report().energy.stilled, 0);
  ASSERT_EQ(world.hash(), general.hash());
  def.settings.leave_out = true;
  World again(def);
  again.restore(world.save());
  for (World* w : {&world, &general, &again}) run(*w, 1000);  // it has landed
  EXPECT_EQ(world.hash(), general.hash());
  EXPECT_EQ(world.hash(), again.hash());
}

}  // namespace resting_test
}  // namespace haptic
