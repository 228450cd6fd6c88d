// The live error estimate against closed forms, its own order, and the true error from a run 64 times finer.
#include "haptic_core/analysis/error_estimate.h"

#include <gtest/gtest.h>

#include "../../scenes/blocks.h"
#include "../../scenes/motions.h"
#include "haptic_core/base/error.h"

namespace haptic {
namespace error_estimate_test {

using namespace scenes;

constexpr double kTip = 0.01;  ///< edge of the hand's box [m]

WorldSettings settings(Attempts attempts, double h) {
  WorldSettings s;
  s.attempts = attempts;
  s.step = h;
  return s;
}

/// A cube that bounces in its soft foundation and a hand that presses on it and draws it aside without slipping.
WorldDef pressed(const WorldSettings& s) {
  CubeParameters c;
  c.mu_static = c.mu_dynamic = 2;
  c.ratio = c.tangential_ratio = 0.1;
  WorldDef def = cubeOnFloor(c, s, -2 * c.restDepth());
  def.settings.pressure_law = PressureLaw::kLinear;
  def.articulations.push_back(freeBox("hand", Vector3::Constant(kTip), 0.01, Pose(Vector3(0, 0, 0.5))));
  PointerDef pointer;
  pointer.articulation = 2;
  pointer.link = 0;
  def.pointers.push_back(pointer);
  return def;
}

constexpr double kSpeed = 0.05;  ///< of the hand, down and half as fast aside [m/s]

void press(World& world, double t) {
  const Vector3 V(0.5 * kSpeed, 0, -kSpeed), start(0, 0, 0.1 + kTip / 2 - 5e-4);
  world.setPointerTarget(0, Pose(start + t * V), {Vector3::Zero(), V});
}

/// The pressed cube after a time [s].
std::vector<double> pressedState(const WorldDef& def, double time = 0.02) {
  World world(def);
  const int steps = static_cast<int>(std::lround(time / def.settings.step));
  for (int i = 1; i <= steps; ++i) {
    press(world, i * def.settings.step);
    world.step();
  }
  EXPECT_GE(world.contactCount(), 2);
  return world.save();
}

ErrorEstimate estimated(const WorldDef& def, const std::vector<double>& state, int steps) {
  ErrorEstimator estimator(def, steps);
  return estimator.estimate(state, World(def).tuning());
}

// On a joint with laws a body moves by symplectic Euler, which falls too far by g h T/2, whatever T: v is exact at the end of each step
// and used for all of it.
TEST(ErrorEstimate, OfAFallIsTheClosedForm) {
  CubeParameters c;
  const double h = 1e-3;
  for (const int n : {1, 16}) {
    WorldDef def = cubeOnFloor(c, settings(Attempts::kImplicitEuler, h), 0.5);
    JointDef& slide = def.articulations[1].links[0].joint;
    slide.type = JointType::kPrismatic;
    slide.axis = Vector3::UnitZ();
    slide.lower = -1;  // a limit is a law
    const ErrorEstimate e = estimated(def, World(def).save(), n);
    EXPECT_EQ(e.order, 1);
    EXPECT_EQ(e.link, 1);
    EXPECT_NEAR(e.position, 0.5 * kGravity * h * n * h, 1e-12) << "rounding of a height of 0.5 m, doubled";
    EXPECT_NEAR(e.energy, c.mass * kGravity * e.position, 1e-12);
    EXPECT_EQ(e.rotation, 0);
    EXPECT_TRUE(e.force.empty());
    def.settings.attempts = Attempts::kAll;  // explicit, to fourth order
    EXPECT_NEAR(estimated(def, World(def).save(), n).position, 0, 1e-12);
  }
}

// From one state, over the same time: steps of h/2 have 2^-p of the error. The tolerance is the next term of the
// expansion, hω/2 with ω = sqrt(kA/m) = 316 1/s, and as much for the sway.
TEST(ErrorEstimate, FallsWithTheOrderOfTheScheme) {
  const struct {
    Attempts attempts;
    bool hand;
    int order;
  } cases[] = {{Attempts::kImplicitEuler, true, 1},   {Attempts::kImplicitEuler, false, 1},
               {Attempts::kSdirk2, false, 2}};
  for (const auto& c : cases) {
    const auto scene = [&c](double h) {
      WorldDef def = pressed(settings(c.attempts, h));
      if (!c.hand) def.pointers.clear();  // it falls from high above
      return def;
    };
    const double h = 1e-4;
    const std::vector<double> state = c.hand ? pressedState(scene(h)) : World(scene(h)).save();
    const ErrorEstimate coarse = estimated(scene(h), state, 16), fine = estimated(scene(h / 2), state, 32);
    EXPECT_EQ(coarse.order, c.order);
    EXPECT_GT(fine.energy, 1e-15);
    EXPECT_NEAR(std::log2(coarse.energy / fine.energy), c.order, 0.15) << "energy, scheme " << int(c.attempts);
    if (!c.hand) continue;
    EXPECT_NEAR(std::log2(coarse.position / fine.position), c.order, 0.15) << "position, scheme " << int(c.attempts);
    EXPECT_NEAR(std::log2(coarse.force[0] / fine.force[0]), 1, 0.15) << "wrench, scheme " << int(c.attempts);
  }
}

constexpr int kFiner = 64;  ///< steps of the truth in one of the world

// The true error: the same window from the same state in steps 64 times finer, whose own error is 1/64 or less of it.
TEST(ErrorEstimate, AgreesWithTheTrueError) {
  struct Window {
    Attempts attempts;
    double start;  // [s]
  };
  for (const auto& [attempts, start] : {Window{Attempts::kImplicitEuler, 0.02}, Window{Attempts::kSdirk2, 0.02},
                                        Window{Attempts::kAll, 0.02}, Window{Attempts::kAll, 0.04}}) {
    const WorldDef def = pressed(settings(attempts, 1e-3));
    WorldDef much_finer = def;
    much_finer.settings.step /= kFiner;
    const std::vector<double> state = pressedState(def, start);
    World world(def), truth(much_finer);
    world.restore(state);
    truth.restore(state);
    Vector3 F_W = Vector3::Zero();  // mean over the last step
    for (int i = 1; i <= ErrorEstimator::kWindowSteps; ++i) {
      press(world, start + i * 1e-3);
      world.step();
      F_W.setZero();
      for (int k = 1; k <= kFiner; ++k) {
        press(truth, start + (i - 1 + double(k) / kFiner) * 1e-3);
        truth.step();
        F_W += truth.pointerWrench(0).force / kFiner;
      }
    }
    double position = 0;
    for (int l = 0; l < world.linkCount(); ++l) {
      position = std::max(position, (world.linkPose(l).p - truth.linkPose(l).p).norm());
    }
    const double force = (world.pointerWrench(0).force - F_W).norm();
    const double energy = std::abs(world.report().energy.total() - truth.report().energy.total());
    const ErrorEstimate e = estimated(def, state, ErrorEstimator::kWindowSteps);
    const auto agrees = [scheme = int(attempts)](double estimate, double true_error, const char* what) {
      EXPECT_GT(estimate, 0.5 * true_error) << what << ", scheme " << scheme;
      EXPECT_LT(estimate, 2 * true_error) << what << ", scheme " << scheme;
    };
    agrees(e.position, position, "position");
    agrees(e.force[0], force, "force");
    agrees(e.energy, energy, "energy");
  }
}

// A shadow with h/2 must not derive a stiffer coupling from its own step: the difference would be one between models.
TEST(ErrorEstimate, KeepsTheCouplingOfTheRunningStep) {
  const double h = 1e-3, mass = 0.01;
  WorldDef def = pressed(settings(Attempts::kImplicitEuler, h)), truth_def = def;
  def.pointers[0].coupling.mode = PointerCoupling::Mode::kVirtual;  // everything derived
  truth_def.pointers[0].coupling = resolved(def.pointers[0].coupling, {mass, mass / 6 * kTip * kTip}, h, false);
  truth_def.settings.step /= kFiner;
  World world(def), truth(truth_def);
  double error = 0;
  for (World* w : {&world, &truth}) w->setPointerTarget(0, Pose(Vector3(1e-3, 0, 0.5)), Twist{});
  const ErrorEstimate e = estimated(def, world.save(), 16);
  for (int i = 0; i < 16; ++i) {
    world.step();
    for (int k = 0; k < kFiner; ++k) truth.step();
    error = (world.linkPose(2).p - truth.linkPose(2).p).norm();
  }
  EXPECT_GT(e.position, 0.5 * error);
  EXPECT_LT(e.position, 2 * error);
}

TEST(ErrorEstimate, RefusesAnotherWorldsState) {
  CubeParameters c;
  const WorldDef one = cubeOnFloor(c, WorldSettings{}), two = stack(2, c, WorldSettings{});
  ErrorEstimator estimator(one);
  EXPECT_THROW(estimator.estimate(World(two).save(), World(one).tuning()), SetupError);
  EXPECT_THROW(ErrorEstimator(one, 0), SetupError);
}

}  // namespace error_estimate_test
}  // namespace haptic
