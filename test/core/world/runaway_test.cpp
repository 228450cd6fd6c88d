/// Steps that are too long for what they meet are right, or say that they are not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../../comparators/velocity_verlet.h"
#include "../../scenes/moving.h"

namespace haptic {
namespace runaway_test {

using namespace scenes;

constexpr Attempts kAll[] = {Attempts::kImplicitEuler,
                               Attempts::kSdirk2, Attempts::kAll};

TEST(Runaway, AnImpactShorterThanTheStepIsRightOrFlagged) {
  for (const Attempts attempts : kAll) {
    for (const double h : {1e-3, 1e-6}) {
      WorldSettings settings;
      settings.attempts = attempts;
      settings.step = h;
      World world(rodAndCube(settings));
      unsigned flags = 0;
      for (double t = 0; t < 0.01 && world.report().finite; t += h) {
        world.step();
        flags |= world.report().flags;
      }
      const double rate = std::abs(world.linkTwist(world.linkIndex("rod")).angular.y());
      const bool right = std::abs(rate / kRodRate - 1) < 0.02;
      EXPECT_TRUE(right || (flags & (kImpactUnresolved | kRunaway))) << static_cast<int>(attempts) << " " << h << " " << rate;
      if (h < 1e-4) EXPECT_TRUE(right) << static_cast<int>(attempts) << " " << rate;
      if (h < 1e-4) EXPECT_EQ(flags & (kImpactUnresolved | kRunaway), 0u) << static_cast<int>(attempts);
    }
  }
}

/// Two cubes that meet flat and elastic exchange their speeds, or the step says that it did not keep the energy: wherever in a step
/// they touch, at its very end too, from where the blow comes in the next.
TEST(Runaway, AnImpactIsRightOrFlaggedWhereverInAStepItFalls) {
  for (const Attempts attempts : {Attempts::kImplicitEuler, Attempts::kSdirk2, Attempts::kAll}) {
    for (const double k : {1e8, 1e9, 1e10}) {
      for (int part = 0; part < 8; ++part) {
        CubeParameters c;
        WorldDef def;
        def.settings.attempts = attempts;
        def.settings.gravity = Vector3::Zero();
        def.settings.default_material.stiffness = k;
        def.settings.default_material.dissipation = 0;
        def.settings.default_material.mu_static = 0;
        const double gap = 0.1 + part * 0.125e-3;  // part 0: they touch after a hundred steps, to rounding
        def.articulations.push_back(cube("a", c, Pose(Vector3(-c.size - gap, 0, 0)), {Vector3::Zero(), Vector3::UnitX()}));
        def.articulations.push_back(cube("b", c, Pose()));
        World world(def);
        unsigned flags = 0;
        for (int i = 0; i < 200; ++i) {
          world.step();
          flags |= world.report().flags;
        }
        ASSERT_EQ(world.contactCount(), 0);
        EXPECT_TRUE(std::abs(world.linkTwist(1).linear.x() - 1) < 0.02 || (flags & kImpactUnresolved))
            << static_cast<int>(attempts) << " " << k << " " << part << " " << world.linkTwist(1).linear.x();
      }
    }
  }
}

/// A rod without any inertia about its own axis, which its hinge does not let it turn about, counts with what the hinge lets it
/// do.
TEST(Runaway, ARodWithoutInertiaAboutItsAxisBouncesAsItsHingeLetsIt) {
  for (const double stiffness : {1.6e4, 1.6e5, 4e5}) {
    World world(rodAndCube(WorldSettings{}, stiffness));
    for (int i = 0; i < 30; ++i) world.step();
    ASSERT_EQ(world.contactCount(), 0);
    constexpr double kShare = 0.05;  // an impact that is cut out loses as much (kPartOfSwing)
    EXPECT_NEAR(world.linkTwist(world.linkIndex("rod")).angular.norm(), kRodRate, kShare * kRodRate) << stiffness;
    EXPECT_NEAR(world.linkTwist(world.linkIndex("cube")).linear.x(), kCubeSpeed, 2 * kShare) << stiffness;
  }
}

/// The same rod, on a second link whose first has all the inertia: nothing bounds how it moves alone, so it is stepped implicitly.
TEST(Runaway, ALinkWithoutInertiaOnAMovingLinkIsSteppedImplicitly) {
  WorldDef def = rodAndCube(WorldSettings{}, 1.6e5);
  LinkDef& rod = def.articulations[0].links[0];
  LinkDef carrier = rod, child = rod;
  carrier.name = "carrier";
  carrier.joint.name = "carrier_joint";
  carrier.collisions.clear();
  child.parent = 0;
  child.joint.type = JointType::kFixed;
  child.inertia = {};
  def.articulations[0].links = {carrier, child};
  World world(def);
  double kinetic = 0, start = 0;
  int implicit = 0;
  for (int i = 0; i < 30; ++i) {
    world.step();
    if (i == 0) start = world.report().energy.kinetic;
    kinetic = std::max(kinetic, world.report().energy.kinetic);
    implicit += world.report().implicit_islands;
  }
  EXPECT_GT(implicit, 0);
  EXPECT_LE(kinetic, start * (1 + 1e-9));
}

/// Ten cubes at forty times the certified stiffness: explicit steps throw them apart.
TEST(Runaway, AWorldWhoseStepsMakeEnergyStopsAndSaysSo) {
  for (const bool ledger : {true, false}) {
    CubeParameters c;
    c.stiffness = 1e9;
    WorldSettings settings;
    settings.comparator = comparators::velocityVerlet;
    settings.energy_ledger = ledger;
    const WorldDef def = stack(10, c, settings, 1e-5);
    World world(def);
    double fastest = 0;
    for (int i = 0; i < 2000 && world.report().finite; ++i) {
      world.step();
      for (int l = 1; l <= 10; ++l) fastest = std::max(fastest, world.linkTwist(l).linear.norm());
    }
    EXPECT_FALSE(world.report().finite) << ledger << " " << fastest;
    EXPECT_TRUE(world.report().flags & kRunaway);
    EXPECT_GT(world.report().culprit, 0);
    std::vector<int> kept;
    for (int a = 0; a < static_cast<int>(def.articulations.size()); ++a) kept.push_back(a);
    NextWorld next(world, def, kept);
    ASSERT_TRUE(world.exchange(next));  // a body that comes starts nothing again
    const double time = world.time();
    world.step();
    EXPECT_FALSE(world.report().finite);
    EXPECT_EQ(world.time(), time);
  }
}

/// The same scenes where steps are short enough, and a hand that pushes: nobody is stopped.
TEST(Runaway, WhatHandsAndFallsGiveIsNoRunaway) {
  for (const Attempts attempts : kAll) {
    for (const bool ledger : {true, false}) {
      CubeParameters c;
      WorldSettings settings;
      settings.attempts = attempts;
      settings.energy_ledger = ledger;
      WorldDef def = cubeOnFloor(c, settings, 1.0);
      def.articulations.push_back(freeBox("hand", Vector3::Constant(0.05), 0.1, Pose(Vector3(-0.5, 0, 0.06))));
      PointerDef pointer;
      pointer.articulation = 2;
      pointer.link = 0;
      def.pointers.push_back(pointer);
      World world(def);
      for (int i = 0; i < 2000; ++i) {
        const double t = 1e-3 * (i + 1);  // from 1 s on it goes through the cube's place
        const double x = t < 1 ? -0.5 : -0.5 + 2 * (t - 1);
        world.setPointerTarget(0, Pose(Vector3(std::min(x, 0.5), 0, 0.06)), {Vector3::Zero(), Vector3(t < 1 || x > 0.5 ? 0 : 2, 0, 0)});
        world.step();
        ASSERT_TRUE(world.report().finite) << static_cast<int>(attempts) << " " << ledger << " " << t;
      }
    }
  }
}

/// A damper so strong that it would throw back what it should stop.
TEST(VelocityVerlet, AStrongHuntCrossleyDamperIsLimited) {
  for (const double c : {1e3, 1e4, 1e6}) {
    CubeParameters cube;
    WorldSettings settings;
    settings.comparator = comparators::velocityVerlet;
    WorldDef def = cubeOnFloor(cube, settings, 0.05);
    def.settings.default_material.dissipation = c;
    World world(def);
    double fastest = 0;
    for (int i = 0; i < 1000; ++i) {
      world.step();
      fastest = std::max(fastest, world.linkTwist(1).linear.norm());
    }
    // It fell from 5 cm: 0.99 m/s, and one more step of falling.
    EXPECT_LT(fastest, std::sqrt(2 * kGravity * 0.05) + 1e-2) << c;
    EXPECT_TRUE(world.report().finite);
  }
}

/// A soft, undamped bounce: what the steps took from it is in the ledger, whatever the integrator.
TEST(Runaway, TheLedgerNamesWhatTheStepsTookFromABounce) {
  for (const Attempts attempts : kAll) {
    CubeParameters cube;
    WorldSettings settings;
    settings.attempts = attempts;
    settings.gravity = Vector3::Zero();
    WorldDef def = cubeOnFloor(cube, settings, 0.01);
    def.settings.default_material.dissipation = 0;
    def.articulations[1].V_WA.linear = Vector3(0, 0, -1);
    World world(def);
    const double start = 0.5 * cube.mass;
    for (int i = 0; i < 100; ++i) world.step();
    const EnergyLedger& e = world.report().energy;
    ASSERT_EQ(world.contactCount(), 0);
    EXPECT_GT(e.kinetic, 0.1 * start);
    EXPECT_NEAR(e.numerical, start - e.kinetic, 1e-9 * start) << static_cast<int>(attempts);
  }
}

/// What a state may draw on is of the gravity that it was saved under: restored under another one, bodies fall and nothing has run away.
TEST(Runaway, ARestoredStateFallsUnderAnotherGravity) {
  const CubeParameters c;
  for (const double gravity : {98., -98., 0.1}) {
    WorldDef def;
    def.articulations.push_back(cube("a", c, Pose(Vector3(0, 0, 1))));
    World world(def);
    const std::vector<double> saved = world.save();
    WorldTuning tuning = world.tuning();
    tuning.gravity = Vector3(0, 0, -gravity);
    world.tune(tuning);
    world.restore(saved);
    for (int i = 0; i < 100; ++i) world.step();
    ASSERT_TRUE(world.report().finite) << gravity;
    EXPECT_NEAR(world.linkTwist(0).linear.z(), -0.1 * gravity, 1e-9 * std::abs(gravity));
    // Under the gravity that it was saved under a state comes back bit by bit, as a replay from the middle needs it.
    const std::uint64_t hash = world.hash();
    world.restore(world.save());
    EXPECT_EQ(world.hash(), hash);
  }
}

}  // namespace runaway_test
}  // namespace haptic
