/// Bodies come and go while a world runs.
#include <gtest/gtest.h>

#include <cstring>

#include "../../scenes/actors.h"
#include "haptic_core/base/error.h"

namespace haptic {
namespace exchange_test {

using namespace scenes;

/// A stack of four, a cube that slides, a pendulum with a law, and a pointer; index of articulations: floor 0, cubes 1…4, slider 5,
/// pendulum 6, tool 7.
WorldDef busy(Attempts attempts) {
  CubeParameters c;
  WorldSettings s;
  s.attempts = attempts;
  WorldDef def = stack(4, c, s, 1e-3);
  def.articulations.push_back(cube("slider", c, Pose(Vector3(0.5, 0, c.size / 2 - c.restDepth())), {Vector3::Zero(), Vector3(1, 0.3, 0)}));
  ArticulationDef pendulum = freeBox("pendulum", Vector3(0.05, 0.05, 0.4), 0.5, Pose(Vector3(0, -1, 2)));
  pendulum.links[0].joint.type = JointType::kRevolute;
  pendulum.links[0].joint.axis = Vector3::UnitY();
  pendulum.links[0].joint.damping = 1e-3;
  pendulum.links[0].inertia.p_LC = Vector3(0.05, 0, -0.2);
  def.articulations.push_back(pendulum);
  def.articulations.push_back(cube("tool", c, Pose(Vector3(-0.5, 0, 0.3))));
  PointerDef pointer;
  pointer.articulation = 7, pointer.link = 0;
  def.pointers.push_back(pointer);
  return def;
}

std::vector<int> all(int n) {
  std::vector<int> kept(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) kept[static_cast<std::size_t>(i)] = i;
  return kept;
}

/// The definition without articulation `gone`; what refers to others goes on doing so.
WorldDef without(WorldDef def, int gone, std::vector<int>& kept) {
  kept.clear();
  for (int a = 0; a < static_cast<int>(def.articulations.size()); ++a) {
    if (a != gone) kept.push_back(a);
  }
  def.articulations.erase(def.articulations.begin() + gone);
  for (PointerDef& pointer : def.pointers) pointer.articulation -= pointer.articulation > gone;
  return def;
}

bool sameBits(const Pose& a, const Pose& b) {
  return std::memcmp(a.R.data(), b.R.data(), 9 * sizeof(double)) == 0 && std::memcmp(a.p.data(), b.p.data(), 3 * sizeof(double)) == 0;
}

class Exchange : public ::testing::TestWithParam<Attempts> {};

/// What comes far away changes no bit of anything else, and when it goes nothing does.
TEST_P(Exchange, WhatComesFarAwayChangesNoBitOfTheRest) {
  const WorldDef def = busy(GetParam());
  World world(def), alone(def);
  const auto step = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      for (World* w : {&world, &alone}) {
        w->setPointerTarget(0, Pose(Vector3(-0.5, 0, 0.3 - 0.25 * std::min(1.0, w->time()))), Twist{});
        w->step();
      }
      for (int l = 0; l < alone.linkCount(); ++l) {
        const int now = world.linkIndex(alone.linkName(l));
        ASSERT_TRUE(sameBits(world.linkPose(now), alone.linkPose(l))) << alone.linkName(l) << " at " << alone.time();
      }
      ASSERT_EQ(world.pointerWrench(0).force, alone.pointerWrench(0).force);
    }
  };
  step(300);
  WorldDef more = def;
  more.articulations.push_back(cube("late", CubeParameters{}, Pose(Vector3(1.5, 1.5, 0.2))));
  NextWorld next(world, more, all(8));
  step(7);  // the world goes on while it is made
  for (const bool steps : {false, true, true}) {
    world.rehearse(next, steps);  // changes nothing
    step(1);
  }
  ASSERT_TRUE(world.exchange(next));
  EXPECT_FALSE(world.exchange(next)) << "it holds the old world now";
  EXPECT_EQ(world.linkCount(), alone.linkCount() + 1);
  EXPECT_EQ(world.time(), alone.time());
  const double before = world.report().energy.numerical;
  step(600);
  EXPECT_NEAR(world.report().energy.numerical, before, 0.5) << "the ledger goes on";
  EXPECT_LT(world.linkPose(world.linkIndex("late")).p.z(), 0.15) << "it has fallen";
  NextWorld back(world, def, all(8));
  ASSERT_TRUE(world.exchange(back));
  step(300);
}

/// The cube under three others goes: those fall, and everything else has the bits that it had.
TEST_P(Exchange, WhatGoesLetsGoOfWhatItTouched) {
  const WorldDef def = busy(GetParam());
  World world(def), alone(def);
  for (int i = 0; i < 400; ++i) world.step(), alone.step();
  std::vector<int> kept;
  const WorldDef less = without(def, 1, kept);
  NextWorld next(world, less, kept);
  ASSERT_TRUE(world.exchange(next));
  EXPECT_EQ(world.linkIndex("cube0"), -1);
  const double top = world.linkPose(world.linkIndex("cube3")).p.z();
  for (int i = 0; i < 100; ++i) world.step(), alone.step();
  const double h = world.settings().step, fallen = 0.5 * kGravity * 0.01;
  EXPECT_NEAR(top - world.linkPose(world.linkIndex("cube3")).p.z(), fallen, 0.05 * fallen + kGravity * h * 0.1 + 1e-3);
  for (const char* name : {"slider", "pendulum"}) {
    EXPECT_TRUE(sameBits(world.linkPose(world.linkIndex(name)), alone.linkPose(alone.linkIndex(name)))) << name;
  }
  for (int i = 0; i < 1500; ++i) world.step();
  EXPECT_TRUE(world.report().finite);
  EXPECT_NEAR(world.linkPose(world.linkIndex("cube3")).p.z(), top - 0.1, 2e-3) << "it stands again, one cube lower";
}

/// The floor goes, and nothing can touch any more: the world has no implicit attempts left, and the cube that had some falls freely.
TEST(ExchangeOfAll, WhatIsLeftAloneFallsFreely) {
  CubeParameters c;
  c.stiffness = 1e10;
  const WorldDef def = cubeOnFloor(c, WorldSettings{});
  World world(def);
  for (int i = 0; i < 50; ++i) world.step();
  ASSERT_EQ(world.state().mode[1], TreeMode::kImplicit);
  std::vector<int> kept;
  const WorldDef less = without(def, 0, kept);
  NextWorld next(world, less, kept);
  ASSERT_TRUE(world.exchange(next));
  const double start = world.linkPose(0).p.z(), speed = world.linkTwist(0).linear.z(), t = 0.5;
  for (int i = 0; i < 500; ++i) world.step();
  constexpr double kRounding = 500 * 10 * 2.3e-16;  // of 500 sums of numbers of some metres
  EXPECT_NEAR(world.linkPose(0).p.z() - start, speed * t - 0.5 * kGravity * t * t, kRounding);
}

/// Deep in a cube of the stack something comes: both part slowly.
TEST_P(Exchange, WhatComesInsideAnotherIsPushedOutSlowly) {
  const WorldDef def = busy(GetParam());
  World world(def);
  for (int i = 0; i < 400; ++i) world.step();
  WorldDef more = def;
  more.articulations.push_back(cube("late", CubeParameters{}, Pose(Vector3(0.02, 0, 0.38))));
  NextWorld next(world, more, all(8));
  ASSERT_TRUE(world.exchange(next));
  double fastest = 0;
  for (int i = 0; i < 1000; ++i) {
    world.step();
    fastest = std::max(fastest, world.linkTwist(world.linkIndex("late")).linear.norm());
  }
  EXPECT_TRUE(world.report().finite);
  EXPECT_LT(fastest, std::sqrt(2 * kGravity * 0.5)) << "no faster than by a fall from there";
}

INSTANTIATE_TEST_SUITE_P(Methods, Exchange,
                         ::testing::Values(Attempts::kImplicitEuler,
                                           Attempts::kSdirk2, Attempts::kAll));

/// A wrench, a motion and what a hand has grabbed go on; what acts on what goes, ends.
TEST(Exchanged, WrenchesMotionsAndHandsGoOn) {
  WorldDef def = busy(Attempts::kAll);
  for (const auto& body : onCarrier(Load{}, WorldSettings{}, {}, 0).articulations) {
    def.articulations.push_back(body);
    def.articulations.back().X_WA.p.y() += 5;
  }
  MotionDef motion;
  motion.name = "carrier";
  motion.articulation = 8, motion.link = 0;
  def.motions.push_back(motion);
  World world(def);
  world.applyWrench(world.linkIndex("slider"), {{Vector3::Zero(), Vector3(0, 0, 3)}, Vector3::Zero(), false}, 0.2);
  world.applyWrench(world.linkIndex("cube0"), {{Vector3::Zero(), Vector3(0, 0.1, 0)}, Vector3::Zero(), false}, 0.2);
  ASSERT_TRUE(world.leadBody(0, {Vector3(0.1, 5, 0), Quaternion::Identity(), {}}, 0.3));
  ASSERT_TRUE(world.tryGrab(0, world.linkIndex("cube3")));
  for (int i = 0; i < 100; ++i) world.step();
  std::vector<int> kept;
  WorldDef less = without(def, 1, kept);
  less.motions[0].articulation = 7;
  NextWorld next(world, less, kept);
  ASSERT_TRUE(world.exchange(next));
  EXPECT_EQ(world.wrenchCount(), 1);
  EXPECT_EQ(world.pointerLink(0), world.linkIndex("cube3"));
  EXPECT_GE(next.linkNow(6), 5);
  for (int i = 0; i < 210; ++i) world.step();
  EXPECT_LT((world.linkPose(world.linkIndex("carrier")).p - Vector3(0.1, 5, 0)).norm(), 1e-9);
  std::vector<int> again;
  WorldDef none = without(less, 3, again);  // cube3
  none.motions[0].articulation = 6;
  NextWorld after(world, none, again);
  ASSERT_TRUE(world.exchange(after));
  EXPECT_EQ(world.pointerLink(0), world.linkIndex("tool")) << "what the hand held is gone: it has the scene's link again";
  for (int i = 0; i < 100; ++i) world.step();
  EXPECT_TRUE(world.report().finite);
}

TEST(Exchanged, OtherWorldsAreRefused) {
  const WorldDef def = busy(Attempts::kAll);
  World world(def), other(def);
  NextWorld of_other(other, def, all(8));
  EXPECT_FALSE(world.exchange(of_other));
  std::vector<int> kept;
  EXPECT_THROW(NextWorld(world, without(def, 7, kept), {0, 1, 2, 3, 4, 5, 6}), std::exception) << "the pointer's link goes";
  EXPECT_THROW(NextWorld(world, def, {1, 0, 2, 3, 4, 5, 6, 7}), SetupError) << "out of order";
  EXPECT_THROW(NextWorld(world, def, {0, 1, 2, 3, 4, 5, 6, 12}), SetupError) << "there is none";
  WorldDef coarse = def;
  coarse.settings.step = 2e-3;
  EXPECT_THROW(NextWorld(world, coarse, all(8)), SetupError);
}

}  // namespace exchange_test
}  // namespace haptic
