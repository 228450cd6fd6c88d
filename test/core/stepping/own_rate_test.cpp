// Islands that are stepped at a rate of their own: closed forms of what waits, the hand's bits, a state that may be looked at any time.
#include "haptic_core/stepping/own_rate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "../../scenes/tumbling.h"
#include "haptic_core/base/error.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace own_rate_test {

using namespace scenes;

constexpr double kStep = 1e-4, kFar = 1e-3;

/// A cube that flies in a world where everything else stands; gravity may be none. Link 1 + 2 i is the lower one of stack i.
WorldDef flying(const Vector3& velocity, const Vector3& gravity) {
  WorldDef def = tumbling(kFar);
  def.settings.gravity = gravity;
  for (int i = 0; i < stacksOfTwo().count; ++i) {
    ArticulationDef& upper = def.articulations[static_cast<std::size_t>(2 * i + 2)];
    upper.V_WA = Twist{};
    upper.X_WA = Pose(Vector3(stackAt(stacksOfTwo(), i) + Vector3(0, 0, 2 + i)));
    if (i == 5) upper.V_WA.linear = velocity;
  }
  return def;
}
constexpr int kFlies = 2 * 5 + 2;

/// [s] of which the pose of a link's tree is.
double timeOf(const World& world, int link) {
  const int tree = world.model().links[static_cast<std::size_t>(link)].articulation;
  const State& state = world.state();
  return kStep * static_cast<double>(state.turn[static_cast<std::size_t>(tree)] ? state.as_of[static_cast<std::size_t>(tree)] : state.step);
}

TEST(OwnRate, WhatFliesIsOnItsParabolaAtEveryTurn) {
  const Vector3 v(0.3, -0.2, 1), g(0, 0, -9.8);
  World world(flying(v, g));
  const Vector3 start = world.linkPose(kFlies).p;
  int late = 0;
  for (int i = 0; i < 1500; ++i) {
    rub(world);
    const double t = timeOf(world, kFlies);
    late += t < world.time() - 0.5 * kStep;
    ASSERT_LT((world.linkPose(kFlies).p - (start + v * t + 0.5 * g * t * t)).norm(), 1e-12) << i;
    ASSERT_LE(world.time() - t, kFar * (1 + 1e-9));
  }
  EXPECT_GT(late, 1200) << "nothing has waited";
}

TEST(OwnRate, AWrenchActsFromItsInstantAndNotFromTheLastTurn) {
  const Vector3 v(0.3, -0.2, 0.1), F(0.02, 0, 0.01);
  const double seconds = 0.0137;
  WorldDef def = flying(v, Vector3::Zero());
  World world(def);
  const double m = world.model().links[kFlies].mass;
  const Vector3 start = world.linkPose(kFlies).p;
  for (int i = 0; i < 1234; ++i) rub(world);
  ASSERT_LT(timeOf(world, kFlies), world.time() - 0.5 * kStep) << "it does not wait";
  const double began = world.time();
  LinkWrench wrench;
  wrench.F.force = F;
  world.applyWrench(kFlies, wrench, seconds);
  EXPECT_NEAR(timeOf(world, kFlies), began, 1e-12) << "who acts on it finds it in the present";
  EXPECT_LT((world.linkPose(kFlies).p - (start + v * began)).norm(), 1e-12);
  for (int i = 0; i < 500; ++i) rub(world);
  ASSERT_LT(timeOf(world, kFlies), world.time() - 0.5 * kStep) << "it does not wait again";
  const double since = timeOf(world, kFlies) - began;
  const Vector3 gained = F / m * seconds;
  EXPECT_LT((world.linkTwist(kFlies).linear - (v + gained)).norm(), 1e-12);
  const Vector3 right = start + v * (began + since) + gained * (since - 0.5 * seconds);
  EXPECT_LT((world.linkPose(kFlies).p - right).norm(), 1e-9) << "half a step of the gained speed at most would be 3e-7 m";
}

/// The stack that waits for the hand leaves out the first step of the one that does not, in which that settles by less than 1e-21 m.
/// Rubbing makes more of it: 1e-12 N after 3000 steps.
TEST(OwnRate, TheHandFeelsTheSameWhereNothingFarReachesIt) {
  constexpr double kRounding = 1e-11;
  World all(tumbling(0)), own(tumbling(kFar));
  long waited = 0, pressed = 0;
  for (int i = 0; i < 3000; ++i) {
    rub(all), rub(own);
    waited += own.report().waiting;
    pressed += own.pointerWrench(0).force.norm() > 0.01;
    const Wrench felt = all.pointerWrench(0), other = own.pointerWrench(0);
    ASSERT_LE((felt.force - other.force).norm(), kRounding * (1 + felt.force.norm())) << i;
    ASSERT_LE((felt.torque - other.torque).norm(), kRounding * (1 + felt.force.norm())) << i;
  }
  EXPECT_EQ(all.report().waiting, 0);
  EXPECT_GT(waited, 3000 * 10);
  EXPECT_GT(pressed, 1000);
}

TEST(OwnRate, AWorldThatIsLookedAtOrRestoredGoesOnWithTheSameBits) {
  World first(tumbling(kFar)), again(tumbling(kFar));
  for (int i = 0; i < 3000; ++i) {
    rub(first), rub(again);
    ASSERT_EQ(first.hash(), again.hash()) << i;
    if (i % 97 == 0) again.restore(again.save());
    if (i % 61 == 0) ASSERT_GT(first.state().q.size(), 0u);
  }
}

/// Contacts of what waits are told again until its turn: none of a time after the one that is restored.
TEST(OwnRate, ARestoredWorldReportsNothingOfAnotherTime) {
  const WorldDef def = tumbling(kFar);
  World world(def);
  int compared = 0;
  for (int round = 0; round < 5; ++round) {
    for (int i = 0; i < 203; ++i) rub(world);
    const std::vector<double> saved = world.save();
    for (int i = 0; i < 97; ++i) rub(world);
    world.restore(saved);
    World fresh(def);
    fresh.restore(saved);
    for (int i = 0; i < 12; ++i) {
      rub(world), rub(fresh);
      ASSERT_EQ(world.contactCount(), fresh.contactCount()) << round << ", " << i;
      for (int c = 0; c < world.contactCount(); ++c, ++compared) {
        ASSERT_EQ(world.contact(c).F_BP_W.force, fresh.contact(c).F_BP_W.force) << round << ", " << i;
      }
      ASSERT_EQ(world.hash(), fresh.hash());
    }
  }
  EXPECT_GT(compared, 100);
}

/// Islands that wait come to the present before somebody changes something: their contacts are those of their last turn meanwhile.
TEST(OwnRate, ContactsOfWhatWaitedAreTheSameUntilTheNextStep) {
  World world(tumbling(kFar));
  int compared = 0;
  for (int round = 0; round < 40; ++round) {
    for (int i = 0; i < 23; ++i) rub(world);
    std::vector<std::pair<int, Vector3>> before, after;
    const auto told = [&](std::vector<std::pair<int, Vector3>>& list) {
      for (int c = 0; c < world.contactCount(); ++c) {
        const ContactReport& contact = world.contact(c);
        list.emplace_back(contact.shape_a << 16 | contact.shape_b, contact.F_BP_W.force);
      }
      std::sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    };
    told(before);
    world.tune(world.tuning());
    told(after);
    ASSERT_EQ(before, after) << round;
    for (int c = 0; c < world.contactCount(); ++c) ASSERT_GE(world.contact(c).link_a, 0);
    compared += world.contactCount();
  }
  EXPECT_GT(compared, 100);
}

TEST(OwnRate, AHandThatComesToWhatStandsFindsTheSameWhetherItSleepsOrNot) {
  WorldSettings settings;
  settings.step = kStep, settings.far_step = 1e-2, settings.history_steps = 10;
  const WorldDef def = stacks(stacksOfTwo(), stiffCube(), settings);
  World sleeps(def), looked_at(def);
  for (int i = 0; i < 2500; ++i) {  // the last half millimetre, by which a body would fall within a far_step, in ten of these
    const Vector3 way(0, 0, i < 975 ? -2e-5 * i : -0.0195 - 5e-7 * (i - 975));
    for (World* world : {&sleeps, &looked_at}) {
      world->setPointerTarget(0, Pose(Vector3(handStart(stacksOfTwo(), stiffCube()) + way)), Twist{});
      world->step();
    }
    ASSERT_EQ(sleeps.hash(), looked_at.hash()) << i;
    if (i > 900) looked_at.save();
  }
}

TEST(OwnRate, WhatComesNearIsInThePresentBeforeItTouches) {
  WorldDef def = tumbling(kFar);
  // The second stack's upper cube slides on the floor towards the first stack.
  ArticulationDef& visitor = def.articulations[4];
  visitor.X_WA = Pose(Vector3(stackAt(stacksOfTwo(), 0) + Vector3(-0.4, 0.02, 0.0501)));
  visitor.V_WA.angular.setZero();
  visitor.V_WA.linear = Vector3(2, 0, 0);
  World world(def);
  bool waited = false, touched = false;
  for (int i = 0; i < 4000; ++i) {
    rub(world);
    const State& state = world.state();
    waited |= state.turn[4] != 0;
    for (int c = 0; c < world.contactCount(); ++c) {
      const ContactReport& contact = world.contact(c);
      if (contact.link_a == 0) continue;
      const auto a = static_cast<std::size_t>(contact.link_a), b = static_cast<std::size_t>(contact.link_b);
      touched |= contact.link_a <= 2 && contact.link_b == 4;
      ASSERT_EQ(state.turn[a], state.turn[b]) << contact.link_a << ' ' << contact.link_b << " at " << i;
      ASSERT_EQ(state.as_of[a], state.as_of[b]);
    }
  }
  EXPECT_TRUE(waited);
  EXPECT_TRUE(touched);
}

TEST(OwnRate, WhatSlidesFarAwayStopsWhereFrictionStopsIt) {
  WorldDef def = tumbling(kFar);
  def.settings.default_material.mu_static = def.settings.default_material.mu_dynamic = 0.5;
  ArticulationDef& slider = def.articulations[4];
  const CubeParameters c = stiffCube();
  slider.X_WA = Pose(Vector3(-1, -1, 0.5 * c.size - c.restDepth()));
  slider.V_WA.angular.setZero();
  slider.V_WA.linear = Vector3(1, 0, 0);
  World world(def);
  long waited = 0;
  for (int i = 0; i < 4000; ++i) {
    rub(world);
    waited += world.state().turn[4] != 0;
  }
  EXPECT_GT(waited, 1500);
  // v²/(2 μ g), and the speed of the start for half of a step of far_step.
  EXPECT_NEAR(world.linkPose(4).p.x(), -1 + 1 / (2 * 0.5 * 9.8), 1 * kFar / 2);
  EXPECT_LT(world.linkTwist(4).linear.norm(), 1e-6);
}

TEST(OwnRate, AThinBodyElsewhereLetsOthersWaitAndAThinWallDoesNot) {
  WorldDef pin = tumbling(kFar), wall = tumbling(kFar);
  CubeParameters small = stiffCube();
  small.size = 2e-3;  // a quarter of it in two turns is 0.25 m/s, and the cubes fall at up to 2 m/s
  pin.articulations.push_back(cube("pin", small, Pose(Vector3(-1, 0, small.size / 2))));
  wall.articulations.push_back(staticBox("wall", Vector3(small.size, 0.1, 0.1), Pose(Vector3(-1, 0, 0.1))));
  World plain(tumbling(kFar)), beside_pin(pin), beside_wall(wall);
  long waited = 0, waited_pin = 0, waited_wall = 0;
  for (int i = 0; i < 2000; ++i) {
    for (World* world : {&plain, &beside_pin, &beside_wall}) rub(*world);
    waited += plain.report().waiting, waited_pin += beside_pin.report().waiting, waited_wall += beside_wall.report().waiting;
  }
  EXPECT_GE(waited_pin, waited);
  EXPECT_LT(waited_wall, 0.9 * static_cast<double>(waited));
}

TEST(OwnRate, ATurnThatIsTooFarAwayIsRefused) {
  WorldDef def = tumbling(0.02);
  try {
    World world(def);
    FAIL() << "200 steps between two turns";
  } catch (const SetupError& error) {
    EXPECT_NE(std::string(error.what()).find("far_step is 0.02 s"), std::string::npos) << error.what();
  }
  def.settings.far_step = 0.01;
  EXPECT_EQ(World(def).model().turn_steps, 100);
  def.settings.step = 1e-3;
  def.settings.far_step = 1e-3;
  EXPECT_EQ(World(def).model().turn_steps, 1) << "everything is stepped by h";
}

}  // namespace own_rate_test
}  // namespace haptic
