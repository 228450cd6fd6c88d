// Counted work of a step and its budget: no step goes beyond the bound that the certificate states, what gives way gives way in order, and
// a budget that is not reached changes no bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "../../scenes/heap.h"
#include "../../scenes/tumbling.h"
#include "haptic_core/analysis/deadline.h"
#include "haptic_core/base/error.h"
#include "haptic_core/world/tuning.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace budget_test {

using namespace scenes;

constexpr double kStep = 1e-4, kFar = 1e-3;

void setBudget(double units, World& world) {
  WorldTuning tuning = world.tuning();
  tuning.budget = units;
  world.tune(tuning);
}

/// The hand runs to and fro through all stacks at up to 2 m/s.
void race(World& world) {
  const double t = world.time();
  const Vector3 way(0.4 - 0.4 * std::cos(5 * t), 0.4 - 0.4 * std::cos(3.1 * t), -0.06 + 0.05 * std::sin(11 * t));
  world.setPointerTarget(0, Pose(Vector3(handStart(stacksOfTwo(), stiffCube()) + way)), Twist{});
  world.step();
}

TEST(Budget, WorkIsCountedAlikeAndAStandingWorldDoesNone) {
  World first(tumbling(0)), again(tumbling(0));
  for (int i = 0; i < 500; ++i) {
    rub(first), rub(again);
    ASSERT_EQ(first.report().work, again.report().work) << i;
    ASSERT_GT(first.report().work, 0);
  }
  WorldDef def = stacks(StackParameters{4, 2}, stiffCube(), WorldSettings{});
  World stands(def);
  for (int i = 0; i < 2000; ++i) stands.step();
  ASSERT_EQ(stands.report().standing, 8);
  EXPECT_EQ(stands.report().work, 0);
}

TEST(Budget, OneThatIsNotReachedChangesNoBit) {
  World none(tumbling(kFar)), large(tumbling(kFar));
  setBudget(0, none), setBudget(1e12, large);
  for (int i = 0; i < 2000; ++i) {
    race(none), race(large);
    ASSERT_EQ(none.hash(), large.hash()) << i;
    ASSERT_EQ(none.report().work, large.report().work) << i;
    ASSERT_FALSE(large.report().flags & kGaveWay);
  }
}

/// Most work of a step of a world that `drive` steps; every one against the bound.
double mostWork(const WorldDef& def, double budget, int steps, void (*drive)(World&)) {
  World world(def);
  if (budget > 0) setBudget(budget, world);
  const double bound = budget + leastWork(world);
  double most = 0;
  int beyond = 0, gave_way = 0;
  for (int i = 0; i < steps; ++i) {
    drive(world);
    EXPECT_TRUE(world.report().finite) << def.name << " at " << budget;
    beyond += budget > 0 && world.report().work > bound;
    gave_way += (world.report().flags & kGaveWay) != 0;
    most = std::max(most, world.report().work);
  }
  EXPECT_EQ(beyond, 0) << def.name << " with a budget of " << budget << " takes " << most << " of " << bound;
  if (budget > 0 && most > budget) EXPECT_GT(gave_way, 0) << def.name << " at " << budget;
  if (budget == 0) EXPECT_EQ(gave_way, 0);
  return most;
}

TEST(Budget, NoStepGoesBeyondItAndTheLeastWork) {
  HeapParameters ten;
  ten.count = 10;
  const auto itself = [](World& world) { world.step(); };
  for (const double stiffness : {1e6, 1e8, 1e12}) {
    for (const double far_step : {0.0, kFar}) {
      for (const double budget : {1.0, 1e4, 1e5, 1e6}) mostWork(tumbling(far_step, stiffness), budget, 1500, race);
    }
  }
  for (const double h : {1e-3, 5e-3}) {
    WorldSettings settings;
    settings.step = h;
    for (const double budget : {1.0, 1e5}) mostWork(heap(ten, settings), budget, 800, itself);
  }
}

TEST(Budget, WithoutOneStepsGoBeyondIt) {
  WorldDef def = tumbling(0, 1e12);
  def.settings.step = 1e-3;
  World world(def);
  EXPECT_GT(mostWork(def, 0, 1500, race), 3e5) << "the bound of the test above would hold of itself";
}

TEST(Budget, WhatIsFarWaitsLongerAndTheHandFeelsTheSame) {
  StackParameters lone = stacksOfTwo();
  lone.count = 1;
  WorldSettings settings;
  settings.step = kStep;
  const double near = mostWork(stacks(lone, stiffCube(), settings), 0, 3000, rub);  // the hand and its stack alone
  World bounded(tumbling(kFar)), again(tumbling(kFar));
  setBudget(8 * near, bounded), setBudget(0, again);  // the fewest passes of a tumbling pair beyond a half leave enough for the near
  double lag = 0;
  int gave_way = 0;
  for (int i = 0; i < 3000; ++i) {
    rub(bounded), rub(again);
    // The stack waited too, before the hand was near.
    ASSERT_LT((bounded.pointerWrench(0).force - again.pointerWrench(0).force).norm(), 1e-9) << i;
    lag = std::max(lag, bounded.report().lag);
    gave_way += (bounded.report().flags & kGaveWay) != 0;
    ASSERT_LE(again.report().lag, kFar * (1 + 1e-9));
  }
  EXPECT_GT(gave_way, 20);
  EXPECT_GT(lag, 1.05 * kFar) << "no island has waited for the budget";
  EXPECT_LE(lag, 2 * kFar * (1 + 1e-9));
}

TEST(Budget, ItIsReplayedFromASavedStateAndItsNumbers) {
  World first(tumbling(kFar)), again(tumbling(kFar));
  setBudget(3e4, first);
  again.tune(WorldTuning::fromNumbers(first.tuning().numbers()));
  EXPECT_EQ(again.tuning().budget, 3e4);
  for (int i = 0; i < 2000; ++i) {
    race(first), race(again);
    ASSERT_EQ(first.hash(), again.hash()) << i;
    if (i % 97 == 0) again.restore(again.save());
  }
}

TEST(Budget, AMissingOrNegativeOneIsRefused) {
  World world(tumbling(0));
  for (const double wrong : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(setBudget(wrong, world), SetupError) << wrong;
  }
  EXPECT_EQ(world.tuning().budget, 0);
}

TEST(Deadline, ABudgetForItIsFoundAndKept) {
  const DeadlineReport slow = certifyDeadline(tumbling(0), 1, 0.2, rubNext), fast = certifyDeadline(tumbling(0), 1e-9, 0.2, rubNext);
  EXPECT_TRUE(slow.kept());
  EXPECT_FALSE(fast.kept()) << "no step takes a nanosecond";
  EXPECT_NEAR(slow.seconds(), 1, 1e-9);
  EXPECT_NE(slow.text().find("is kept"), std::string::npos) << slow.text();
  EXPECT_NE(fast.text().find("not certain"), std::string::npos) << fast.text();
  World world(tumbling(0));
  EXPECT_GT(slow.steps, 90) << "it ends by its CPU time, not before";
  EXPECT_LE(slow.seen, mostWork(tumbling(0), 0, 2010, rub)) << "it is a run of the scene, without its first steps";
}

}  // namespace budget_test
}  // namespace haptic
