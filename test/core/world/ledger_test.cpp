/// The energy ledger of explicit steps: what contacts take is what bodies lose.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../../comparators/velocity_verlet.h"
#include "../../scenes/moving.h"

namespace haptic {
namespace ledger_test {

using namespace scenes;

struct Balance {
  double worst_step = 0;  ///< largest change in a step [J]
  double worst = 0;       ///< largest since the start [J]
  double taken = 0;       ///< by damping and friction [J]
};

/// A cube flies askew and spinning into the floor, without gravity: then nothing but contacts changes its kinetic energy.
Balance crash() {
  WorldSettings settings;
  settings.comparator = comparators::velocityVerlet;
  settings.gravity = Vector3::Zero();
  WorldDef def = cubeOnFloor(CubeParameters{}, settings);
  Pose& X_WA = def.articulations[1].X_WA;
  X_WA.R = Eigen::AngleAxisd(0.5, Vector3(1, 0.4, 0.2).normalized()).toRotationMatrix();
  X_WA.p.z() = 0.09;
  def.articulations[1].V_WA = {Vector3(1, -2, 0.5), Vector3(0.3, 0.1, -0.5)};
  World world(def);
  Balance out;
  world.step();
  const double start = world.report().energy.balance();
  double last = start;
  for (int i = 0; i < 400; ++i) {
    world.step();
    const EnergyLedger& e = world.report().energy;
    out.worst_step = std::max(out.worst_step, std::abs(e.balance() - last));
    out.worst = std::max(out.worst, std::abs(e.balance() - start));
    out.taken = e.damping + e.friction;
    last = e.balance();
  }
  return out;
}

/// Impulse times mean velocity is the change of kinetic energy, to rounding: some 1e3 of them on 0.02 J. Also where a contact ends.
TEST(VelocityVerlet, BooksWhatTheBodyLoses) {
  const Balance of = crash();
  EXPECT_GT(of.taken, 5e-3);
  EXPECT_LT(of.worst_step, 1e-14);
  EXPECT_LT(of.worst, 400 * 1e-14);
}

/// A plate slides on a tangential layer so soft that its spring would carry μN at 15 cm. With the damper b_t beside it the spring
/// lags behind: s = (μN/k_t A) (1 - exp(-t k_t/b_t)), and holds ½ k_t A s². All of μN in the spring from the first step on would be
/// energy from nothing, which throws the plate back.
TEST(SlidingFriction, ItsSpringsHoldWhatTheWayHasPutThere) {
  constexpr double kMass = 0.3, kArea = 0.01, kMu = 0.5, kSpring = 1e3, kUntil = 0.1;
  const double damper = 2 * std::sqrt(kSpring * kMass / kArea), most = kMu * kMass * kGravity / (kSpring * kArea);
  const double slip = most * -std::expm1(-kUntil * kSpring / damper), held = 0.5 * kSpring * kArea * slip * slip;
  for (const Attempts attempts : {Attempts::kImplicitEuler,
                                      Attempts::kSdirk2, Attempts::kAll}) {
    SCOPED_TRACE(static_cast<int>(attempts));
    WorldDef def;
    def.settings.attempts = attempts;
    ContactMaterial& m = def.settings.default_material;
    m.stiffness = 1e6;
    m.tangential_stiffness = kSpring;
    m.mu_static = m.mu_dynamic = kMu;
    def.articulations.push_back(floorBox());
    const double rest = kMass * kGravity / (m.stiffness * kArea);
    def.articulations.push_back(freeBox("plate", Vector3(0.1, 0.1, 0.02), kMass, Pose(Vector3(0, 0, 0.01 - rest)),
                                        {Vector3::Zero(), Vector3::UnitX()}));
    World world(def);
    const double start = 0.5 * kMass + kMass * kGravity * (0.01 - rest) + 0.5 * m.stiffness * kArea * rest * rest;
    for (int i = 0; i < 2000; ++i) {
      world.step();
      const EnergyLedger& e = world.report().energy;
      ASSERT_LE(e.total(), start * (1 + 1e-4)) << i;  // (hω)²/4 of the heave, whose energy is 3e-3 of it
      ASSERT_GE(e.damping, 0) << i;
      ASSERT_GE(e.friction, 0) << i;
      // Half a step of the spring's time b_t/k_t, on either side, twice for the square; and the plate's tilt: its friction acts
      // 1 cm below the centre and moves the pressure by 5 mm of 100, which leaves N alone.
      const double late = 1e-3 * kSpring / damper / std::expm1(kUntil * kSpring / damper);
      if (i + 1 == 100) EXPECT_NEAR(e.tangential, held, (2 * late + 0.01) * held);
    }
  }
}

/// Friction that resists sliding only: a cube that spins where it stands goes on, and nothing is stored or taken.
TEST(WithoutTorsion, ASpinIsNeitherHeldNorRemembered) {
  for (const Attempts attempts : {Attempts::kImplicitEuler,
                                      Attempts::kSdirk2, Attempts::kAll}) {
    SCOPED_TRACE(static_cast<int>(attempts));
    WorldSettings settings;
    settings.attempts = attempts;
    settings.torsional_friction = false;
    WorldDef def = cubeOnFloor(CubeParameters{}, settings);
    def.articulations[1].V_WA.angular.z() = 5;
    World world(def);
    for (int i = 0; i < 1000; ++i) {
      world.step();
      const EnergyLedger& e = world.report().energy;
      // A spin of 5 rad/s holds 2e-3 J. Rounding lets the centre of the patch move by 1e-15 m a step.
      ASSERT_LE(e.tangential + std::abs(e.friction), 1e-12) << i;
      ASSERT_TRUE(world.contact(0).sticking) << i;
    }
    EXPECT_NEAR(world.linkTwist(1).angular.z(), 5, 1e-9);
  }
}

/// A table falls on its four legs, one floor lower, and rocks: friction at none of them knows what the others do, and takes energy all
/// the same. E - E0 + D against the largest of what was exchanged so far.
TEST(Ledger, ATableThatLandsGainsNothing) {
  WorldSettings settings;
  settings.comparator = comparators::velocityVerlet;
  World world(table(settings, 5e-5, 0));
  world.step();
  const EnergyLedger first = world.report().energy;
  double gain = 0, exchanged = 0;
  for (int i = 1; i < 1000; ++i) {
    world.step();
    const EnergyLedger& e = world.report().energy;
    const double taken = std::max(0.0, e.damping + e.friction - first.damping - first.friction);
    exchanged = std::max({exchanged, std::abs(e.kinetic - first.kinetic), std::abs(e.potential - first.potential),
                          std::abs(e.elastic - first.elastic), std::abs(e.tangential - first.tangential), taken});
    gain = std::max(gain, (e.total() - first.total() + taken) / exchanged);
  }
  constexpr double kMass = 8, kLegs = 4 * 4e5;  // [kg], [N/m]
  EXPECT_LT(gain, settings.step * settings.step * kLegs / kMass / 10);  // (h ω)²/10: what a step of second order is off by
}

}  // namespace ledger_test
}  // namespace haptic
