// Islands that are laid aside: what a step computes is bit for bit what it computes where nothing is left out, whatever wakes them.
#include "haptic_core/stepping/asleep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "../../scenes/stacks.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/step_history.h"

namespace haptic {
namespace asleep_test {

using namespace scenes;

CubeParameters stiffCube() {
  CubeParameters c;
  c.stiffness = 1e8;
  return c;
}

StackParameters fewStacks(bool hand) {
  StackParameters p;
  p.count = 16, p.height = 3, p.hand = hand;
  return p;
}

using Contact = std::array<double, 9>;

/// In one order, for what sleeps is reported last.
std::vector<Contact> contactsOf(const World& world) {
  std::vector<Contact> all;
  for (int i = 0; i < world.contactCount(); ++i) {
    const ContactReport& c = world.contact(i);
    const Vector3 &f = c.F_BP_W.force, &t = c.F_BP_W.torque;
    all.push_back({double(c.shape_a), double(c.shape_b), c.volume, f.x(), f.y(), f.z(), t.x(), t.y(), t.z()});
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// Without the whole state, which takes back what sleeps.
void expectSame(const World& a, const World& b) {
  ASSERT_EQ(a.hash(), b.hash());
  for (int l = 0; l < a.linkCount(); ++l) {
    ASSERT_EQ(a.linkPose(l).p, b.linkPose(l).p) << a.linkName(l);
    ASSERT_EQ(a.linkTwist(l).linear, b.linkTwist(l).linear) << a.linkName(l);
  }
  const StepReport &x = a.report(), &y = b.report();
  ASSERT_EQ(x.flags, y.flags);
  ASSERT_EQ(x.pairs, y.pairs);
  ASSERT_EQ(x.contacts, y.contacts);
  ASSERT_EQ(x.implicit_islands, y.implicit_islands);
  ASSERT_EQ(x.standing, y.standing);
  ASSERT_EQ(x.wrench_error, y.wrench_error);
  ASSERT_EQ(x.position_error, y.position_error);
  const EnergyLedger &e = x.energy, &f = y.energy;
  ASSERT_EQ(e.kinetic, f.kinetic);
  ASSERT_EQ(e.potential, f.potential);
  ASSERT_EQ(e.elastic, f.elastic);
  ASSERT_EQ(e.tangential, f.tangential);
  ASSERT_EQ(e.numerical, f.numerical);
  for (int i = 0; i < a.pointerCount(); ++i) ASSERT_EQ(a.pointerWrench(i).force, b.pointerWrench(i).force);
  ASSERT_EQ(contactsOf(a), contactsOf(b));
}

/// The same world twice, one of which leaves nothing out. Both get what `disturb` does before a step.
struct Twins {
  explicit Twins(WorldDef def) : lazy((def.settings.leave_out = true, def)), general((def.settings.leave_out = false, def)) {}
  void run(int steps, const std::function<void(World&)>& disturb = nullptr) {
    for (int i = 0; i < steps; ++i) {
      for (World* world : {&lazy, &general}) {
        if (disturb) disturb(*world);
        world->step();
      }
      ASSERT_NO_FATAL_FAILURE(expectSame(lazy, general)) << "step " << i;
      most = std::max(most, lazy.report().standing);
      least = std::min(least, lazy.report().standing);
    }
    ASSERT_EQ(lazy.save(), general.save());
    ASSERT_EQ(lazy.hash(), general.hash());
  }
  World lazy, general;
  int most = 0, least = 1000;  ///< bodies that stood
};

class AsleepSteps : public testing::TestWithParam<Attempts> {
 protected:
  AsleepSteps() { settings_.attempts = GetParam(); }
  WorldSettings settings_;
};

TEST_P(AsleepSteps, WhatIsHitWakesAndSleepsAgain) {
  const StackParameters p = fewStacks(false);
  WorldDef def = stacks(p, stiffCube(), settings_);
  for (int i = 0; i < 3; ++i) {  // one after the other
    const Vector3 at = stackAt(p, 5 * i) + Vector3(0.03, 0.02, 0.6 + 0.8 * i);
    def.articulations.push_back(cube("falls" + std::to_string(i), stiffCube(), Pose(at)));
  }
  Twins twins(def);
  ASSERT_NO_FATAL_FAILURE(twins.run(1500));
  EXPECT_GE(twins.most, 45);
  EXPECT_LT(twins.least, 45);
}

TEST_P(AsleepSteps, AHandGoesAmongThem) {
  const StackParameters p = fewStacks(true);
  Twins twins(stacks(p, stiffCube(), settings_));
  const Vector3 start = handStart(p, stiffCube());
  ASSERT_NO_FATAL_FAILURE(twins.run(1200, [&](World& world) {
    const double t = world.time(), down = std::max(0.0, std::min({10 * (t - 0.3), 10 * (0.8 - t), 1.0}));
    world.setPointerTarget(0, Pose(Vector3(start + Vector3(0.3 * t, 0.01 * t, -0.025 * down))), Twist{});
  }));
  EXPECT_GE(twins.most, 45);
}

INSTANTIATE_TEST_SUITE_P(All, AsleepSteps, testing::Values(Attempts::kImplicitEuler, Attempts::kSdirk2, Attempts::kAll));

/// Everything that a user may do to a world in which most sleeps.
TEST(Asleep, WhateverWakesThem) {
  const StackParameters p = fewStacks(true);
  Twins twins(stacks(p, stiffCube(), WorldSettings{}));
  const Vector3 start = handStart(p, stiffCube());
  const auto both = [&](const std::function<void(World&)>& act) {
    for (World* world : {&twins.lazy, &twins.general}) act(*world);
    ASSERT_NO_FATAL_FAILURE(twins.run(150, [&](World& world) { world.setPointerTarget(0, Pose(start), Twist{}); }));
  };
  ASSERT_NO_FATAL_FAILURE(both([](World&) {}));
  EXPECT_EQ(twins.lazy.report().standing, 48);
  ASSERT_NO_FATAL_FAILURE(both([](World& world) {
    LinkWrench push;
    push.F.force.x() = 3;
    world.applyWrench(10, push, 0.05);
  }));
  EXPECT_LT(twins.least, 48);
  ASSERT_NO_FATAL_FAILURE(both([](World& world) {
    WorldTuning tuning = world.tuning();
    tuning.gravity = Vector3(0, 0, -9);
    world.tune(tuning);
  }));
  ASSERT_NO_FATAL_FAILURE(both([&](World& world) { world.setBodyPose(4, Pose(Vector3(stackAt(p, 1) + Vector3(0.01, 0, 0.5))), Twist{}); }));
  const std::vector<double> saved = twins.lazy.save();
  ASSERT_NO_FATAL_FAILURE(both([](World& world) { world.grab(0, 6); }));
  ASSERT_NO_FATAL_FAILURE(both([&](World& world) { world.restore(saved); }));
}

/// A cube so fast and small that it goes in spans when it reaches a stack, after 0.2 s.
TEST(Asleep, AnIslandInSpansIsThatOfAll) {
  const StackParameters p = fewStacks(false);
  WorldDef def = stacks(p, stiffCube(), WorldSettings{});
  Twist V;
  V.linear = Vector3(30, 30, 0);
  CubeParameters small = stiffCube();
  small.size = 0.01, small.mass = 0.005;
  def.articulations.push_back(cube("shot", small, Pose(Vector3(-6, -6, 0.45)), V));
  Twins twins(def);
  int cut = 0;
  ASSERT_NO_FATAL_FAILURE(twins.run(400, [&](World& world) { cut += world.report().parts > 1; }));
  EXPECT_GE(twins.most, 47);
  EXPECT_GE(cut, 2) << "no island went in spans";
}

TEST(Asleep, BodiesThatComeAndGoFindThemAsTheyWere) {
  const StackParameters p = fewStacks(false);
  WorldDef def = stacks(p, stiffCube(), WorldSettings{});
  Twins twins(def);
  ASSERT_NO_FATAL_FAILURE(twins.run(200));
  WorldDef more = def;
  more.articulations.push_back(cube("comes", stiffCube(), Pose(Vector3(stackAt(p, 3) + Vector3(0.02, 0, 0.36)))));
  std::vector<int> kept;
  for (std::size_t i = 0; i < def.articulations.size(); ++i) kept.push_back(static_cast<int>(i));
  more.settings.leave_out = true;
  NextWorld lazy(twins.lazy, more, kept);
  more.settings.leave_out = false;
  NextWorld general(twins.general, more, kept);
  ASSERT_TRUE(twins.lazy.exchange(lazy));
  ASSERT_TRUE(twins.general.exchange(general));
  ASSERT_NO_FATAL_FAILURE(twins.run(400));
  EXPECT_GE(twins.most, 48);
}

/// Rows of the history, of which most were not written in their step.
TEST(Asleep, TheHistoryIsWhole) {
  const StackParameters p = fewStacks(true);
  WorldSettings settings;
  settings.history_steps = 50;
  Twins twins(stacks(p, stiffCube(), settings));
  const Vector3 start = handStart(p, stiffCube());
  ASSERT_NO_FATAL_FAILURE(twins.run(333, [&](World& world) {
    world.setPointerTarget(0, Pose(Vector3(start + Vector3(0, 0, -2e-4 * std::min(world.time() / 1e-3, 120.0)))), Twist{});
  }));
  const StepHistory &a = twins.lazy.history(), &b = twins.general.history();
  ASSERT_EQ(a.size(), b.size());
  for (int i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a.record(i).step, b.record(i).step);
    for (std::size_t k = 0; k < twins.lazy.state().q.size(); ++k) ASSERT_EQ(a.record(i).q[k], b.record(i).q[k]) << i;
    for (std::size_t k = 0; k < twins.lazy.state().v.size(); ++k) ASSERT_EQ(a.record(i).v[k], b.record(i).v[k]) << i;
  }
}

}  // namespace asleep_test
}  // namespace haptic
