// Turns that a second thread solves: the same bits as without it, whatever becomes of the islands meanwhile and however late it is.
#include "haptic_core/stepping/turns_ahead.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "../../scenes/tumbling.h"
#include "haptic_core/base/fields.h"
#include "haptic_core/world/applied_wrench.h"
#include "haptic_core/world/work.h"

namespace haptic {
namespace turns_ahead_test {

using namespace scenes;

constexpr double kFar = 1e-3;

/// What a step reports, in numbers.
std::vector<double> numbersOf(const World& world) {
  const StepReport& r = world.report();
  std::vector<double> n = {double(r.pairs), double(r.contacts), double(r.iterations), double(r.evaluations), double(r.factorisations),
                           double(r.parts), double(r.implicit_islands), double(r.standing), double(r.waiting), double(r.fallbacks),
                           double(r.flags), r.residual, r.wrench_error, r.lag, r.work, r.impact, r.position_error, r.budget_used,
                           r.energy.kinetic, r.energy.elastic, r.energy.damping, r.energy.friction, r.energy.numerical, r.energy.stilled};
  for (int i = 0; i < world.contactCount(); ++i) {
    const ContactReport& c = world.contact(i);
    n.insert(n.end(), {double(c.link_a), double(c.link_b), c.normal_force, c.depth, c.area, c.event, c.F_BP_W.torque.x()});
  }
  return n;
}

enum class Thread { kComesToAll, kRunsFree };

/// Steps one world without and one with a second thread; `act` does something to either before step i. The turns that it spared.
std::uint64_t compare(const WorldDef& def, int steps, Thread thread, const std::function<void(World&, int)>& act) {
  World without(def), with(def);
  with.useSecondThread(true);
  for (int i = 0; i < steps; ++i) {
    for (World* world : {&without, &with}) act(*world, i), rub(*world);
    EXPECT_EQ(without.hash(), with.hash()) << "step " << i;
    EXPECT_EQ(numbersOf(without), numbersOf(with)) << "step " << i;
    if (::testing::Test::HasFailure()) break;
    if (thread == Thread::kComesToAll) with.work().ahead->finish();
  }
  return with.work().ahead->taken();
}

void nothing(World&, int) {}

TEST(TurnsAhead, AreTakenAndChangeNoBit) {
  const std::uint64_t taken = compare(tumbling(kFar), 3000, Thread::kComesToAll, nothing);
  EXPECT_GT(taken, 1000u) << "steps have solved the turns themselves";
}

TEST(TurnsAhead, ComeWhenTheyComeAndChangeNoBit) { compare(tumbling(kFar), 3000, Thread::kRunsFree, nothing); }

TEST(TurnsAhead, OfIslandsThatSomethingActsOnAreLeft) {
  const int upper = 2 + 2 * 7;
  const auto act = [](World& world, int i) {
    WorldTuning tuning = world.tuning();
    if (i == 503) world.applyWrench(upper, LinkWrench{Wrench{Vector3::Zero(), Vector3(3, 0, 0)}, Vector3::Zero(), false}, 2e-3);
    if (i == 907) world.setBodyPose(upper, Pose(Vector3(world.linkPose(upper).p + Vector3(0, 0, 0.05))), Twist{});
    if (i == 1201) tuning.stiffness_scale = 0.5, tuning.friction_scale = 0.3, world.tune(tuning);
    if (i == 1503) tuning.gravity = Vector3(0.5, 0, -9), world.tune(tuning);
    if (i == 1807) world.tryGrab(0, upper);
    if (i == 2003) world.restore(world.save());
  };
  EXPECT_GT(compare(tumbling(kFar), 2500, Thread::kComesToAll, act), 500u);
}

TEST(TurnsAhead, CountAgainstABudgetAsIfTheStepHadSolvedThem) {
  World world(tumbling(kFar));
  double most = 0;
  for (int i = 0; i < 1500; ++i) rub(world), most = std::max(most, world.report().work);
  const auto bound = [most](World& bounded, int i) {
    WorldTuning tuning = bounded.tuning();
    tuning.budget = most / 3;
    if (i == 0) bounded.tune(tuning);
  };
  EXPECT_GT(compare(tumbling(kFar), 1500, Thread::kComesToAll, bound), 100u);
}

TEST(TurnsAhead, OfAnotherStateAreNotTaken) {
  World first(tumbling(kFar)), other(tumbling(kFar));
  other.useSecondThread(true);
  for (int i = 0; i < 1003; ++i) rub(first), rub(other);
  other.work().ahead->finish();
  State moved = other.state();  // what waits, as it was, but somewhere else
  for (std::size_t t = 0; t < moved.turn.size(); ++t) {
    if (moved.turn[t] != 0) moved.v[static_cast<std::size_t>(other.model().trees[t].v) + 3] += 1e-9;
  }
  const std::vector<double> packed = moved.pack();
  first.restore(packed), other.restore(packed);
  for (int i = 0; i < 100; ++i) {
    rub(first), rub(other);
    ASSERT_EQ(first.hash(), other.hash()) << i;
  }
}

TEST(TurnsAhead, NeedIslandsThatHaveTurns) {
  World world(tumbling(0));
  world.useSecondThread(true);
  EXPECT_FALSE(world.usesSecondThread());
  World far(tumbling(kFar));
  far.useSecondThread(true);
  EXPECT_TRUE(far.usesSecondThread());
  far.useSecondThread(false);
  EXPECT_FALSE(far.usesSecondThread());
}

}  // namespace turns_ahead_test
}  // namespace haptic
