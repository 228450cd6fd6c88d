// Oracles: the same motion at smaller steps, momentum, and a world that begins at another step's number.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "../../comparators/velocity_verlet.h"
#include "../../scenes/heap.h"
#include "../../scenes/step_motions.h"
#include "haptic_core/world/state.h"

namespace haptic {
namespace multistep_test {

using scenes::StepMotion;

WorldSettings settings(double h = 1e-3) {
  WorldSettings s;
  s.step = h;
  return s;
}

WorldSettings settings(Attempts attempts) {
  WorldSettings s = settings();
  s.attempts = attempts;
  return s;
}

struct Slide {
  double x = 0;            ///< way of the cube [m]
  double evaluations = 0;  ///< of a step, mean
};

/// A cube slides for 0.2 s at k 1e8 N/m³: at 1 ms the contact swings 16 times faster than explicit steps bear.
Slide slide(double h) {
  World world(scenes::slidingCube(settings(h), 1e8, 0));
  const int steps = static_cast<int>(std::lround(0.2 / h));
  Slide out;
  for (int i = 0; i < steps; ++i) {
    world.step();
    out.evaluations += static_cast<double>(world.report().evaluations) / steps;
  }
  out.x = world.linkPose(1).p.x();
  return out;
}

/// Second order at the price of one solve: implicit Euler errs by half a millimetre here, and SDIRK2 alone takes 1.5 evaluations.
TEST(Multistep, ASlidingCubeTakesOneSolveOfSecondOrder) {
  const Slide coarse = slide(1e-3), fine = slide(1e-3 / 32);
  EXPECT_LT(coarse.evaluations, 1.1);
  EXPECT_GT(coarse.evaluations, 0.5);  // implicit all the way
  // μ g h t / 2 is the error of the first order, 490 µm; of second order it is that times a few h over the contact's own time.
  EXPECT_LT(std::abs(coarse.x - fine.x), 0.05 * 0.5 * 0.5 * scenes::kGravity * 1e-3 * 0.2);
}

/// Of two worlds of the same bodies, the largest |Δx| [m].
double apart(const World& a, const World& b) {
  double most = 0;
  for (int l = 0; l < a.linkCount(); ++l) most = std::max(most, (a.linkPose(l).p - b.linkPose(l).p).norm());
  return most;
}

/// After 20 ms of a cube that slides at 1 m/s and spins at 10 rad/s. Its patch is clipped in the first two milliseconds.
std::unique_ptr<World> spun(const WorldSettings& settings) {
  auto world = std::make_unique<World>(scenes::slidingCube(settings, 1e8, 10));
  while (world->time() < 0.02 - 0.5 * settings.step) world->step();
  return world;
}

/// However it is stepped, the motion is one: implicit steps come nearer to it by their order. With friction of another law where the patch
/// is clipped they stay 10 µm from it at any step.
TEST(Multistep, ImplicitStepsConvergeToTheMotionOfExplicitOnes) {
  const auto at = [](Attempts attempts, double h, MakeComparator comparator = nullptr) {
    WorldSettings s = settings(attempts);
    s.comparator = comparator;
    s.step = h;
    return spun(s);
  };
  const auto exact = at(Attempts::kAll, 1e-3 / 512, comparators::velocityVerlet);
  for (const Attempts attempts : {Attempts::kImplicitEuler, Attempts::kSdirk2, Attempts::kAll}) {
    // Steps of a quarter of a millisecond err by where the last clip falls in them; from a sixteenth on the order shows.
    const double coarse = apart(*at(attempts, 1e-3 / 16), *exact), fine = apart(*at(attempts, 1e-3 / 256), *exact);
    EXPECT_LT(fine, 0.1 * coarse) << static_cast<int>(attempts);  // of first order a sixteenth
    EXPECT_LT(fine, 1e-6) << static_cast<int>(attempts);
  }
}

/// A cube slides to rest; the stop lies within a step. Its error follows the accuracy that is asked for, but for the first step: there the
/// contact begins, which does not ask for it.
TEST(Multistep, LessErrorIsMadeWhereLessIsAskedFor) {
  constexpr double kStep = 1e-3, kSeconds = 0.3;
  const auto errorOf = [](double accuracy) {
    WorldSettings s = settings(Attempts::kAll);
    s.step = kStep;
    s.accuracy = accuracy;
    WorldDef def = scenes::slidingCube(s, 1e8, 0);
    World world(def);
    world.step();
    def.articulations[1].X_WA = world.linkPose(1);
    def.articulations[1].V_WA = world.linkTwist(1);
    def.settings.comparator = comparators::velocityVerlet;
    def.settings.step = kStep / 50;
    World exact(def);
    while (world.time() < kSeconds - 0.5 * kStep) world.step();
    while (exact.time() < kSeconds - 1.01 * kStep) exact.step();
    return apart(world, exact);
  };
  const double loose = errorOf(0.3), tight = errorOf(0.003);
  EXPECT_LT(tight, 0.01 * loose);
  EXPECT_GT(loose, 1e-6);
}

/// A ball on a hand meets a box at k 1e10 N/m³. In a tick the hand can give the box no more than twice the momentum that it has at
/// the hand's speed, and hold its friction. (It got 14.8 kN: a step that had not converged.)
TEST(Multistep, AHandPushesAStiffBoxWithoutASpike) {
  for (const StepMotion& motion : scenes::stepMotions()) {
    if (motion.name != "push_1e10") continue;
    constexpr double kMass = 0.1, kMu = 0.5, kHandSpeed = 0.5 * 2 * M_PI / scenes::kHandPeriod * 0.02;
    World world(motion.make(settings()));
    double most = 0;
    for (int i = 0; i < 600; ++i) {
      motion.aim(world);
      world.step();
      most = std::max(most, world.pointerWrench(0).force.norm());
      EXPECT_EQ(world.report().flags & kNotConverged, 0u) << "step " << i;
    }
    EXPECT_LT(most, 2 * kMass * kHandSpeed / 1e-3 + kMu * kMass * scenes::kGravity);
    EXPECT_GT(most, 0.2 * kMu * kMass * scenes::kGravity);  // it did push
  }
}

/// Nothing but time tells one step from another: questions that are asked at every 16th or 256th step would.
TEST(Multistep, TheNumberOfTheFirstStepChangesNoBit) {
  for (const WorldDef& def : {scenes::heap({}, settings()), scenes::rockingBlock(settings(), 1e8)}) {
    std::uint64_t hash[2];
    for (const int begin : {0, 7}) {
      World world(def);
      State state = world.state();
      state.step = static_cast<std::uint64_t>(begin);
      world.restore(state.pack());
      for (int i = 0; i < 400; ++i) world.step();
      state = world.state();
      state.step = 0;
      state.time = 0;
      hash[begin == 0 ? 0 : 1] = state.hash();
    }
    EXPECT_EQ(hash[0], hash[1]) << def.name;
  }
}

/// Evaluations of a step, mean over 200 in which 100 cubes fall upon each other: the contacts of nearly every step are others than the
/// last one's.
double evaluationsOfHeap(Attempts attempts) {
  scenes::HeapParameters p;
  p.count = 100;
  p.stiffness = 1e7;
  World world(scenes::heap(p, settings(attempts)));
  double sum = 0;
  for (int i = 0; i < 300; ++i) {
    world.step();
    if (i >= 100) sum += world.report().evaluations / 200.0;
  }
  return sum;
}

/// Second order cannot step over contacts that begin and end, and a heap does not pay for trying in vain: half an attempt more per
/// step than by implicit Euler alone.
TEST(Multistep, AHeapDoesNotPayForAttemptsInVain) {
  const double euler = evaluationsOfHeap(Attempts::kImplicitEuler);
  EXPECT_GT(euler, 1.5);  // all is in motion
  EXPECT_LT(evaluationsOfHeap(Attempts::kAll), euler + 0.5);
}

}  // namespace multistep_test
}  // namespace haptic
