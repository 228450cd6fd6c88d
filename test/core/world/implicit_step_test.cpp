// Oracles: closed forms of rest and of a rigid fall, conservation, and the order in h. Scenes: test/scenes.
#include <gtest/gtest.h>

#include <cmath>

#include "../../scenes/motions.h"
#include "haptic_core/world/world.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace implicit_step_test {

using scenes::CubeParameters;

WorldSettings settings(Attempts attempts, double h) {
  WorldSettings s;
  s.attempts = attempts;
  s.step = h;
  return s;
}

class ImplicitStepTest : public testing::TestWithParam<std::tuple<Attempts, double>> {
 protected:
  WorldSettings settings_ = settings(std::get<0>(GetParam()), std::get<1>(GetParam()));
};

INSTANTIATE_TEST_SUITE_P(Steps, ImplicitStepTest,
                         testing::Combine(testing::Values(Attempts::kImplicitEuler, Attempts::kSdirk2),
                                          testing::Values(1e-3, 1e-2)));

TEST_P(ImplicitStepTest, ACubeRestsAtItsDepthWhateverItsStiffness) {
  for (double k : {1e6, 1e9, 1e14}) {
    CubeParameters c;
    c.stiffness = k;
    World world(scenes::cubeOnFloor(c, settings_));
    for (int i = 0; i < 300; ++i) {
      world.step();
      ASSERT_EQ(world.report().flags, 0u);
    }
    ASSERT_EQ(world.contactCount(), 1);
    // Coordinates of 0.1 m are rounded to 1e-17 m, and Newton ends at a few roundings: 2e-16 m of depth.
    EXPECT_NEAR(world.contact(0).normal_force, c.mass * scenes::kGravity, 2e-16 * k * c.area() + 1e-12) << k;
    // Rounding of coordinates of 0.1 m over the step is what is left of the velocity.
    EXPECT_LE(world.linkTwist(1).linear.norm(), 1e-14 / settings_.step) << k;
  }
}

TEST_P(ImplicitStepTest, ADroppedCubeComesToRestWithoutGainingEnergy) {
  CubeParameters c;
  c.stiffness = 1e9;
  World world(scenes::cubeOnFloor(c, settings_, 0.1));
  const double potential = c.mass * scenes::kGravity * 0.1;
  double lost = 0;
  for (double t = 0; t < 1.5; t += settings_.step) {
    world.step();
    ASSERT_EQ(world.report().flags & kNotConverged, 0u);
    const EnergyLedger& e = world.report().energy;
    lost = c.mass * scenes::kGravity * (0.15 - c.restDepth()) - e.total();
    ASSERT_GE(lost, -1e-9 * potential);
  }
  EXPECT_NEAR(lost, potential, 1e-3 * potential);  // all of it, up to the elastic energy of rest
  EXPECT_NEAR(world.linkPose(1).p.z(), 0.05 - c.restDepth(), 1e-12);
}

/// Gravity leans, so that a cube slides down a floor of 1e10 N/m: its normal force is uncertain by 1e-6 N of rounding, and
/// what friction makes of that must not keep Newton from ending.
TEST_P(ImplicitStepTest, ACubeSlidesDownTheStiffestSlope) {
  CubeParameters c;
  c.stiffness = 1e12;
  c.mu_static = c.mu_dynamic = 0.3;
  const double angle = std::atan(0.8);
  settings_.gravity = scenes::kGravity * Vector3(std::sin(angle), 0, -std::cos(angle));
  World world(scenes::cubeOnFloor(c, settings_));
  while (world.time() < 0.4) {
    world.step();
    ASSERT_EQ(world.report().flags & kNotConverged, 0u) << world.time();
  }
  const double speed = scenes::kGravity * (std::sin(angle) - 0.3 * std::cos(angle)) * world.time();
  EXPECT_NEAR(world.linkTwist(1).linear.x(), speed, 1e-4 * speed);
}

TEST_P(ImplicitStepTest, AStackStandsAtItsAnalyticDepth) {
  CubeParameters c;
  c.stiffness = 1.5e9;  // k_eff = 1.5e7 N/m: explicit steps of 1 ms fail at 2e5
  World world(scenes::stack(15, c, settings_));
  for (int i = 0; i < 200; ++i) world.step();
  double top = 0;
  for (int i = 0; i < 15; ++i) {
    top += c.size - (15 - i) * c.restDepth();
    EXPECT_NEAR(world.linkPose(1 + i).p.z(), top - c.size / 2, 1e-6 * c.restDepth());
    EXPECT_LE(world.linkTwist(1 + i).linear.norm(), 1e-6);
  }
}

TEST_P(ImplicitStepTest, TwoCubesThatMeetKeepTheirMomentum) {
  CubeParameters c;
  c.stiffness = 1e9;
  WorldDef def = scenes::cubeOnFloor(c, settings_);
  def.settings.gravity.setZero();
  def.articulations.clear();
  def.articulations.push_back(scenes::cube("a", c, Pose(Vector3(0, 0, 0)), {Vector3(0.1, 0.2, 0), Vector3(1, 0, 0)}));
  def.articulations.push_back(
      scenes::cube("b", c, Pose(Vector3(0.13, 0.04, 0.01)), {Vector3::Zero(), Vector3(-0.5, 0, 0)}));
  World world(def);
  const auto momentum = [&] {
    const double I = c.mass * c.size * c.size / 6;  // of a cube about any axis
    Vector3 linear = Vector3::Zero(), angular = Vector3::Zero();
    for (int i = 0; i < 2; ++i) {
      const Twist V = world.linkTwist(i);
      linear += c.mass * V.linear;
      angular += I * V.angular + world.linkPose(i).p.cross(c.mass * V.linear);
    }
    return Wrench{angular, linear};
  };
  const Wrench before = momentum();
  int contacts = 0;
  for (double t = 0; t < 0.3; t += settings_.step) {
    world.step();
    contacts += world.contactCount();
  }
  const Wrench after = momentum();
  EXPECT_GT(contacts, 0);
  EXPECT_LE((after.force - before.force).norm(), 1e-11);
  // The lever arms move within a step: L is kept up to (Δp × m v) of the impulse, first order in h.
  EXPECT_LE((after.torque - before.torque).norm(), settings_.step * 2 * c.mass);
}

TEST_P(ImplicitStepTest, FrictionHoldsWithoutCreepBelowTheLimit) {
  CubeParameters c;
  c.stiffness = 1e8;
  WorldDef def = scenes::cubeOnFloor(c, settings_);
  const double slope = 0.9 * c.mu_static;
  def.settings.gravity = Vector3(scenes::kGravity * slope, 0, -scenes::kGravity);
  World world(def);
  for (double t = 0; t < 1; t += settings_.step) world.step();
  const Vector3 settled = world.linkPose(1).p;
  for (double t = 0; t < 1; t += settings_.step) world.step();
  EXPECT_TRUE(world.contact(0).sticking);
  EXPECT_LE((world.linkPose(1).p - settled).norm(), 1e-9);  // less than 1 nm/s
}

// A light pointer on a stiff virtual coupling: explicit steps would need h² k/m < 4, here it is 1e3…1e9.
TEST_P(ImplicitStepTest, AStiffVirtualCouplingHoldsALightPointer) {
  for (double k : {1e6, 1e9}) {
    CubeParameters c;
    c.mass = 1e-3;
    WorldDef def = scenes::cubeOnFloor(c, settings_, 0.2);
    PointerDef hand;
    hand.articulation = 1;
    hand.link = 0;
    hand.coupling.mode = PointerCoupling::Mode::kVirtual;
    hand.coupling.stiffness = k;
    hand.coupling.damping = hand.coupling.rotational_damping = 0;
    hand.coupling.rotational_stiffness = 1e-3 * k;
    def.pointers.push_back(hand);
    World world(def);
    const Pose target(Vector3(0.01, 0, 0.3));
    for (int i = 0; i < 500; ++i) {
      world.setPointerTarget(0, target, Twist{});
      world.step();
      ASSERT_EQ(world.report().flags & kNotConverged, 0u);
    }
    EXPECT_NEAR(world.linkPose(1).p.z(), 0.3 - c.mass * scenes::kGravity / k, 1e-15 + 1e-6 * c.mass / k);
    EXPECT_NEAR(world.pointerWrench(0).force.z(), -c.mass * scenes::kGravity, 5e-16 * k + 1e-9);  // rounding of 0.3 m
  }
}

/// Rms distance from the exact rigid motion of the stick-slip block over 4 s.
double stickSlipError(double h) {
  CubeParameters c;
  c.mass = scenes::StickSlip::kMass;
  c.stiffness = scenes::StickSlip::kStiffness;
  World world(scenes::StickSlip::scene(settings(Attempts::kSdirk2, h)));
  const int steps = static_cast<int>(std::lround(4 / h));
  double squares = 0;
  for (int i = 0; i < steps; ++i) {
    scenes::StickSlip::step(world, c.size / 2 - c.restDepth());
    squares += std::pow(world.linkPose(1).p.x() - scenes::StickSlip::position(world.time()), 2);
  }
  return std::sqrt(squares / steps);
}

// The slides last 0.32 s and move by 31 mm: with changes of friction at the ends of 10 ms steps, each would be off by up
// to 0.6 mm. The elastic layer's play is 3e-5 s and 2e-6 m a cycle.
TEST(ImplicitStep, LocatesWhereFrictionChangesInsideTheStep) {
  EXPECT_LE(stickSlipError(1e-2), 1e-4);
  EXPECT_LE(stickSlipError(1e-3), 2e-5);
}

/// Error of the height, after 20 ms, of a cube that heaves on its foundation without damping or losing touch:
/// x = x_rest - a cos ωt, ω² = k A/m.
double heaveError(Attempts attempts, double h) {
  CubeParameters c;  // k_eff = 1e4 N/m: ω = 316 rad/s, rest depth 98 µm
  const double amplitude = 20e-6;
  WorldDef def = scenes::cubeOnFloor(c, settings(attempts, h), -amplitude);
  def.settings.default_material.dissipation = 0;
  World world(def);
  for (int i = 0, n = static_cast<int>(std::lround(0.02 / h)); i < n; ++i) world.step();
  const double omega = std::sqrt(c.stiffness * c.area() / c.mass);
  return std::abs(world.linkPose(1).p.z() - (c.size / 2 - c.restDepth() - amplitude * std::cos(omega * 0.02)));
}

TEST(ImplicitStep, HasTheOrderOfItsScheme) {
  for (const auto& [attempts, order] : {std::pair{Attempts::kImplicitEuler, 1}, {Attempts::kSdirk2, 2}}) {
    const double coarse = heaveError(attempts, 1e-4), fine = heaveError(attempts, 5e-5);
    EXPECT_NEAR(std::log2(coarse / fine), order, 0.15);  // the next term of the error is h ω/2 = 1 % of it
    EXPECT_GT(coarse, 1e-9);
  }
}

/// What is reported of contacts is their impulse over the step: with it, and gravity, a bouncing and sliding cube keeps its
/// books, also where a step has two stages.
TEST_P(ImplicitStepTest, ReportedWrenchesAreImpulsesOverTheStep) {
  CubeParameters c;
  c.stiffness = 1e6;  // contacts of 20 ms: many smooth steps of 1 ms
  settings_.tolerance = 0;
  WorldDef def = scenes::cubeOnFloor(c, settings_, 0.02);
  def.articulations[1].V_WA.linear.x() = 0.5;
  World world(def);
  int converged = 0;
  for (double t = 0; t < 0.3; t += settings_.step) {
    const Twist before = world.linkTwist(1);
    world.step();
    Vector3 sum = c.mass * settings_.gravity;
    for (int i = 0; i < world.contactCount(); ++i) {
      const ContactReport& contact = world.contact(i);
      sum += contact.link_b == 1 ? contact.F_BP_W.force : Vector3(-contact.F_BP_W.force);
    }
    const Vector3 change = c.mass / settings_.step * (world.linkTwist(1).linear - before.linear);
    if (world.report().flags & kNotConverged) continue;  // says itself what it leaves out of balance
    ++converged;
    // The solve goes on to 1e-9 of the speed: that share of the impulse, over a step.
    ASSERT_NEAR((sum - change).norm(), 0, 1e-8 * (c.mass / settings_.step) * 1.0) << t;
  }
  // A tolerance of 0 asks for more than ten evaluations can give where a patch changes much.
  EXPECT_GE(converged, 0.6 * 0.3 / settings_.step);
}

}  // namespace implicit_step_test
}  // namespace haptic
