// A plan leaves out what cannot change anything: the same bits as the general pipeline, on scenes that differ in what there
// is to leave out.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "../../comparators/velocity_verlet.h"
#include "../../scenes/motions.h"

namespace haptic {
namespace leave_out_test {

using namespace scenes;

WorldSettings settingsFor(Attempts attempts) {
  WorldSettings s;
  s.attempts = attempts;
  return s;
}

/// Cubes thrown into one another over a floor of `tiles`² boxes.
WorldDef heap(const WorldSettings& settings, int cubes, int tiles) {
  WorldDef def = cubeOnFloor(CubeParameters{}, settings);
  def.articulations.clear();
  for (int i = 0; i < tiles * tiles; ++i) {
    def.articulations.push_back(staticBox("tile" + std::to_string(i), Vector3(0.5, 0.5, 0.2),
                                          Pose(Vector3(0.5 * (i % tiles), 0.5 * (i / tiles), -0.1))));
  }
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < cubes; ++i) {
    Twist V;
    V.linear = Vector3(uniform(random) - 0.5, uniform(random) - 0.5, -uniform(random));
    V.angular = 4 * Vector3(uniform(random) - 0.5, uniform(random) - 0.5, uniform(random) - 0.5);
    const Vector3 p(0.4 * uniform(random), 0.4 * uniform(random), 0.06 + 0.09 * i);
    def.articulations.push_back(cube("cube" + std::to_string(i), CubeParameters{}, Pose(p), V));
  }
  return def;
}

void expectSameBits(WorldDef def, int steps) {
  def.settings.leave_out = true;
  World planned(def);
  def.settings.leave_out = false;
  World general(def);
  ASSERT_NE(planned.planText(), general.planText()) << "nothing was left out: the comparison would say nothing";
  for (int i = 0; i < steps; ++i) {
    for (World* world : {&planned, &general}) {
      for (int k = 0; k < world->pointerCount(); ++k) {
        const double t = world->time();
        world->setPointerTarget(k, Pose(Vector3(0.02 * std::sin(9 * t), 0.01 * t, 0.04 - 0.02 * std::sin(5 * t))), Twist{});
      }
      world->step();
    }
    ASSERT_EQ(planned.hash(), general.hash()) << def.name << ", step " << i;
    ASSERT_EQ(planned.report().flags, general.report().flags);
    ASSERT_EQ(planned.report().contacts, general.report().contacts);
  }
}

class LeaveOut : public testing::TestWithParam<Attempts> {};

TEST_P(LeaveOut, FewPairsOnOneFloor) { expectSameBits(stack(5, CubeParameters{}, settingsFor(GetParam())), 200); }

TEST_P(LeaveOut, ManyPairsOnManyTiles) { expectSameBits(heap(settingsFor(GetParam()), 12, 4), 150); }

TEST_P(LeaveOut, NothingCanTouch) { expectSameBits(tumblingBody(settingsFor(GetParam())), 200); }

TEST_P(LeaveOut, FrictionlessWithAHand) {
  CubeParameters c;
  c.mu_static = c.mu_dynamic = 0;
  WorldDef def = cubeOnFloor(c, settingsFor(GetParam()));
  def.articulations.push_back(cube("tool", c, Pose(Vector3(0, 0, 0.2))));
  PointerDef hand;
  hand.articulation = 2;
  hand.link = 0;
  def.pointers.push_back(hand);
  expectSameBits(def, 200);
}

INSTANTIATE_TEST_SUITE_P(AllSteps, LeaveOut,
                         testing::Values(Attempts::kImplicitEuler, Attempts::kSdirk2, Attempts::kAll));

TEST(LeaveOut, IsTheSameAfterRestore) {
  WorldDef def = heap(settingsFor(Attempts::kAll), 6, 2);
  World first(def), second(def);
  for (int i = 0; i < 80; ++i) first.step();
  const auto saved = first.save();
  second.restore(saved);
  for (int i = 0; i < 80; ++i) {
    first.step();
    second.step();
    ASSERT_EQ(first.hash(), second.hash());
  }
}

TEST(StageTimes, AreThereWhenAskedForAndChangeNoBit) {
  WorldSettings settings;
  settings.comparator = comparators::velocityVerlet;
  const WorldDef def = heap(settings, 6, 2);
  World timed(def), plain(def);
  timed.measureStages(true);
  StageTimes sum{0, 0, 0, 0, 0};
  for (int i = 0; i < 200; ++i) {
    timed.step();
    plain.step();
    const StageTimes& t = timed.report().stages;
    sum.search += t.search;
    sum.detection += t.detection;
    sum.volume += t.volume;
    sum.force += t.force;
    sum.motion += t.motion;
  }
  EXPECT_EQ(timed.hash(), plain.hash());
  for (const double stage : {sum.search, sum.detection, sum.volume, sum.force, sum.motion}) EXPECT_GT(stage, 0);
  EXPECT_TRUE(std::isnan(plain.report().stages.total()));
  timed.measureStages(false);
  timed.step();
  EXPECT_TRUE(std::isnan(timed.report().stages.total()));
}

}  // namespace leave_out_test
}  // namespace haptic
