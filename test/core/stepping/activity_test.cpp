// Islands that are left out: what a step computes is bit for bit what it computes where everything is visited (leave_out off), whatever
// wakes them, and looking at a world changes and wakes nothing.
#include "haptic_core/stepping/activity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "../../scenes/blocks.h"
#include "../../scenes/stacks.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/step_history.h"
#include "haptic_core/world/work.h"

namespace haptic {
namespace activity_test {

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

using Contact = std::array<double, 10>;

/// In one order, for what rests is reported last.
std::vector<Contact> contactsOf(const World& world) {
  std::vector<Contact> all;
  for (int i = 0; i < world.contactCount(); ++i) {
    const ContactReport& c = world.contact(i);
    const Vector3 &f = c.F_BP_W.force, &t = c.F_BP_W.torque;
    all.push_back({double(c.shape_a), double(c.shape_b), double(c.sticking), c.volume, f.x(), f.y(), f.z(), t.x(), t.y(), t.z()});
  }
  std::sort(all.begin(), all.end());
  return all;
}

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

/// Something touches, implicitly, and no contact was computed.
bool allStand(const World& world) {
  return world.contactCount() > 0 && world.report().implicit_islands > 0 && world.report().evaluations == 0;
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
      ASSERT_FALSE(allStand(general));
      stood += allStand(lazy);
      most = std::max(most, lazy.report().standing);
      least = std::min(least, lazy.report().standing);
    }
    ASSERT_EQ(lazy.save(), general.save());
    ASSERT_EQ(lazy.hash(), general.hash());
  }
  World lazy, general;
  int stood = 0;               ///< steps in which nothing was computed
  int most = 0, least = 1000;  ///< bodies that stood
};

class Stacks : public testing::TestWithParam<Attempts> {
 protected:
  Stacks() { settings_.attempts = GetParam(); }
  WorldSettings settings_;
};

TEST_P(Stacks, WhatIsHitWakesAndRestsAgain) {
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

TEST_P(Stacks, AHandGoesAmongThem) {
  const StackParameters p = fewStacks(true);
  Twins twins(stacks(p, stiffCube(), settings_));
  const Vector3 start = handStart(p, stiffCube());
  ASSERT_NO_FATAL_FAILURE(twins.run(1200, [&](World& world) {
    const double t = world.time(), down = std::max(0.0, std::min({10 * (t - 0.3), 10 * (0.8 - t), 1.0}));
    world.setPointerTarget(0, Pose(Vector3(start + Vector3(0.3 * t, 0.01 * t, -0.025 * down))), Twist{});
  }));
  EXPECT_GE(twins.most, 45);
}

INSTANTIATE_TEST_SUITE_P(All, Stacks, testing::Values(Attempts::kImplicitEuler, Attempts::kSdirk2, Attempts::kAll));

/// Everything that a user may do to a world in which most rests.
TEST(Activity, WhateverWakesThem) {
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
TEST(Activity, AnIslandInSpansIsThatOfAll) {
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

TEST(Activity, BodiesThatComeAndGoFindThemAsTheyWere) {
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
TEST(Activity, TheHistoryIsWhole) {
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

/// One of two worlds is looked at between its steps.
TEST(Activity, LookingChangesNothingAndWakesNothing) {
  StackParameters p = fewStacks(true);
  const WorldDef def = stacks(p, stiffCube(), WorldSettings{});
  World seen(def), unseen(def);
  const Vector3 start = handStart(p, stiffCube());
  int rested = 0;
  for (int i = 0; i < 600; ++i) {
    for (World* world : {&seen, &unseen}) {
      world->setPointerTarget(0, Pose(Vector3(start + Vector3(0, 0, -2e-4 * std::min(i, 120)))), Twist{});
      world->step();
    }
    const State& state = seen.state();
    int pairs = 0;
    std::uint64_t last = 0;
    state.pairs.each([&](int slot) {
      EXPECT_LT(last, state.pairs[slot].key);
      last = state.pairs[slot].key;
      ++pairs;
    });
    ASSERT_EQ(pairs, seen.report().pairs) << "the state is whole";
    ASSERT_EQ(seen.save(), unseen.save());
    ASSERT_EQ(seen.history().size(), unseen.history().size());
    ASSERT_EQ(seen.work().activity.trees(), unseen.work().activity.trees());
    rested += seen.work().activity.trees() > 40;
  }
  EXPECT_GT(rested, 300);
}

/// Sensors feel what rests, although no step computes it.
TEST(Activity, AWorldWithSensorsRestsToo) {
  const StackParameters p = fewStacks(false);
  WorldDef def = stacks(p, stiffCube(), WorldSettings{});
  SensorDef sensor;
  sensor.name = "sole";
  sensor.kind = SensorDef::Kind::kContact;
  sensor.articulation = 1, sensor.link = 0;
  def.sensors.push_back(sensor);
  Twins twins(def);
  for (int i = 0; i < 40; ++i) {
    ASSERT_NO_FATAL_FAILURE(twins.run(10));
    ASSERT_EQ(twins.lazy.sensorReading(0).F_S.force, twins.general.sensorReading(0).F_S.force);
  }
  EXPECT_EQ(twins.lazy.work().activity.trees(), 48);
  EXPECT_NEAR(twins.lazy.sensorReading(0).F_S.force.z(), stiffCube().mass * kGravity, 1e-6) << "floor below, two cubes above";
}

class Standing : public Stacks {};

TEST_P(Standing, AStackThatWasDroppedComesToStand) {
  WorldDef def = stack(4, stiffCube(), settings_, 2e-3);
  for (std::size_t i = 1; i < def.articulations.size(); ++i) def.articulations[i].X_WA.p.z() += 1e-3 * static_cast<double>(i);
  Twins twins(def);
  ASSERT_NO_FATAL_FAILURE(twins.run(3000));
  EXPECT_TRUE(allStand(twins.lazy));
  EXPECT_GT(twins.stood, 1000);
}

TEST_P(Standing, WhatIsHitMovesAndStandsAgain) {
  const CubeParameters c = stiffCube();
  WorldDef def = stack(2, c, settings_);
  def.articulations.push_back(cube("falls", c, Pose(Vector3(0.03, 0.02, 2))));  // lands after 0.6 s
  Twins twins(def);
  ASSERT_NO_FATAL_FAILURE(twins.run(500));
  const double before = twins.lazy.linkPose(2).p.x();
  EXPECT_GT(twins.stood, 0) << "beside what falls by itself";
  ASSERT_NO_FATAL_FAILURE(twins.run(300));
  EXPECT_NE(twins.lazy.linkPose(2).p.x(), before);
  ASSERT_NO_FATAL_FAILURE(twins.run(4000));
  EXPECT_TRUE(allStand(twins.lazy));
}

TEST_P(Standing, ABoxOnASlopeStandsByItsFriction) {
  const double slope = 0.2;
  WorldSettings settings = settings_;
  settings.gravity = kGravity * Vector3(std::sin(slope), 0, -std::cos(slope));
  Twins twins(cubeOnFloor(stiffCube(), settings));
  ASSERT_NO_FATAL_FAILURE(twins.run(1500));
  EXPECT_TRUE(allStand(twins.lazy));
  const double across = twins.lazy.contact(0).F_BP_W.force.x();
  EXPECT_NEAR(across, -0.1 * kGravity * std::sin(slope), 1e-9);  // mass 0.1 kg; on the cube
}

TEST_P(Standing, AHandWakesWhatItTouches) {
  const CubeParameters c = stiffCube();
  WorldDef def = stack(2, c, settings_);
  def.articulations.push_back(cube("tool", c, Pose(Vector3(0, 0, 0.35))));
  PointerDef hand;
  hand.articulation = 3;
  hand.link = 0;
  def.pointers.push_back(hand);
  Twins twins(def);
  const auto path = [](World& world) {  // down to press by 10 µm, and up again
    const double t = world.time(), down = t < 0.5 ? 0 : t < 1 ? t - 0.5 : std::max(0.0, 1.5 - t);
    const double z = 0.35 - 2 * down * (0.10001 + 0.5 * 2.94e-6);
    world.setPointerTarget(0, Pose(Vector3(0, 0, z)), Twist{});
  };
  ASSERT_NO_FATAL_FAILURE(twins.run(400, path));
  EXPECT_GT(twins.stood, 100);
  double most = 0;
  ASSERT_NO_FATAL_FAILURE(twins.run(1200, [&](World& world) {
    path(world);
    most = std::max(most, world.pointerWrench(0).force.z());
  }));
  EXPECT_GT(most, 1) << "the hand never pressed";
  ASSERT_NO_FATAL_FAILURE(twins.run(2000, path));
  EXPECT_TRUE(allStand(twins.lazy));
}

TEST_P(Standing, AHandThatComesLaterWakesWhatItPulls) {
  WorldDef def = stack(2, stiffCube(), settings_);
  PointerDef hand;
  hand.articulation = 2;
  hand.link = 0;
  hand.coupling.mode = PointerCoupling::Mode::kVirtual;
  def.pointers.push_back(hand);
  Twins twins(def);
  ASSERT_NO_FATAL_FAILURE(twins.run(300));
  ASSERT_TRUE(allStand(twins.lazy)) << "a hand without a target does not act";
  const Pose start = twins.lazy.linkPose(2);
  ASSERT_NO_FATAL_FAILURE(twins.run(300, [&](World& world) {
    world.setPointerTarget(0, Pose(start.R, start.p + Vector3(0, 0, 0.02)), Twist{});
  }));
  EXPECT_GT(twins.lazy.linkPose(2).p.z(), start.p.z() + 1e-3);
}

TEST_P(Standing, NothingStandsOnWhatWasChanged) {
  Twins twins(stack(3, stiffCube(), settings_));
  ASSERT_NO_FATAL_FAILURE(twins.run(500));
  ASSERT_TRUE(allStand(twins.lazy));
  const std::vector<double> saved = twins.lazy.save();
  WorldTuning softer = twins.lazy.tuning();
  softer.stiffness_scale = 0.5;
  const double high = twins.lazy.linkPose(3).p.z();
  for (World* world : {&twins.lazy, &twins.general}) world->tune(softer);
  ASSERT_NO_FATAL_FAILURE(twins.run(1500));
  EXPECT_LT(twins.lazy.linkPose(3).p.z(), high - 1e-7);
  for (World* world : {&twins.lazy, &twins.general}) world->restore(saved);
  ASSERT_NO_FATAL_FAILURE(twins.run(1500));
}

/// Soft bodies stand where k V holds their weight, and move again once something has hit them.
TEST(StandingByChoice, SoftBodiesStandToo) {
  CubeParameters c;
  c.stiffness = 1e6;
  WorldDef def = cubeOnFloor(c, WorldSettings{}, 1e-4);
  def.articulations.push_back(cube("falls", c, Pose(Vector3(0.03, 0.02, 3.25))));  // lands after 0.8 s
  Twins twins(def);
  ASSERT_NO_FATAL_FAILURE(twins.run(720));
  EXPECT_TRUE(twins.lazy.stands(1));
  // It stands once it is slower than 5e-13 m/s, on its way to rest at about ω.
  const double omega = std::sqrt(c.stiffness * c.area() / c.mass);
  EXPECT_NEAR(twins.lazy.linkPose(1).p.z(), 0.05 - c.restDepth(), 4 * 5e-13 / omega);
  int moves_again = 0;
  ASSERT_NO_FATAL_FAILURE(twins.run(4000, [&](World& world) { moves_again += !world.stands(1); }));
  EXPECT_GT(moves_again, 0);
  EXPECT_TRUE(allStand(twins.lazy));
}

INSTANTIATE_TEST_SUITE_P(ImplicitSteps, Standing,
                         testing::Values(Attempts::kImplicitEuler, Attempts::kSdirk2, Attempts::kAll));

}  // namespace activity_test
}  // namespace haptic
