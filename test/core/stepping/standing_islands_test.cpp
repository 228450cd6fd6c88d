// What stands is not computed again, and the bits are those of the general pipeline, which computes everything in every step:
// while it stands, when something comes, and after the world was changed from outside.
#include <gtest/gtest.h>

#include <functional>

#include "../../scenes/blocks.h"

namespace haptic {
namespace standing_islands_test {

using namespace scenes;

constexpr double kStiff = 1e8;  // of k [N/m³]: implicit at 1 ms

WorldSettings settingsFor(Attempts attempts) {
  WorldSettings s;
  s.attempts = attempts;
  return s;
}

CubeParameters stiffCube() {
  CubeParameters c;
  c.stiffness = kStiff;
  return c;
}

/// Something touches, implicitly, and no contact was computed.
bool allStand(const World& world) {
  return world.contactCount() > 0 && world.report().implicit_islands > 0 && world.report().evaluations == 0;
}

void expectSameReport(const World& a, const World& b) {
  ASSERT_EQ(a.hash(), b.hash());
  ASSERT_EQ(a.report().flags, b.report().flags);
  ASSERT_EQ(a.report().energy.elastic, b.report().energy.elastic);
  ASSERT_EQ(a.report().energy.tangential, b.report().energy.tangential);
  ASSERT_EQ(a.report().wrench_error, b.report().wrench_error);
  ASSERT_EQ(a.contactCount(), b.contactCount());
  for (int i = 0; i < a.contactCount(); ++i) {
    ASSERT_EQ(a.contact(i).shape_a, b.contact(i).shape_a);
    ASSERT_EQ(a.contact(i).shape_b, b.contact(i).shape_b);
    ASSERT_EQ(a.contact(i).volume, b.contact(i).volume);
    ASSERT_EQ(a.contact(i).F_BP_W.force, b.contact(i).F_BP_W.force);
    ASSERT_EQ(a.contact(i).F_BP_W.torque, b.contact(i).F_BP_W.torque);
    ASSERT_EQ(a.contact(i).sticking, b.contact(i).sticking);
  }
}

/// The same world twice, one of which leaves nothing out. Both get what `disturb` does before a step.
struct Twins {
  explicit Twins(WorldDef def) : standing((def.settings.leave_out = true, def)), general((def.settings.leave_out = false, def)) {}
  void run(int steps, const std::function<void(World&)>& disturb = nullptr) {
    for (int i = 0; i < steps; ++i) {
      for (World* world : {&standing, &general}) {
        if (disturb) disturb(*world);
        world->step();
      }
      ASSERT_FALSE(allStand(general));
      ASSERT_NO_FATAL_FAILURE(expectSameReport(standing, general)) << "step " << i;
      stood += allStand(standing);
    }
  }
  World standing, general;
  int stood = 0;  ///< steps in which nothing was computed
};

class Standing : public testing::TestWithParam<Attempts> {};

TEST_P(Standing, AStackThatWasDroppedComesToStand) {
  WorldDef def = stack(4, stiffCube(), settingsFor(GetParam()), 2e-3);
  for (std::size_t i = 1; i < def.articulations.size(); ++i) def.articulations[i].X_WA.p.z() += 1e-3 * static_cast<double>(i);
  Twins twins(def);
  ASSERT_NO_FATAL_FAILURE(twins.run(3000));
  EXPECT_TRUE(allStand(twins.standing));
  EXPECT_GT(twins.stood, 1000);
}

TEST_P(Standing, WhatIsHitMovesAndStandsAgain) {
  const CubeParameters c = stiffCube();
  WorldDef def = stack(2, c, settingsFor(GetParam()));
  def.articulations.push_back(cube("falls", c, Pose(Vector3(0.03, 0.02, 2))));  // lands after 0.6 s
  Twins twins(def);
  ASSERT_NO_FATAL_FAILURE(twins.run(500));
  const double before = twins.standing.linkPose(2).p.x();
  EXPECT_GT(twins.stood, 0) << "beside what falls by itself";
  ASSERT_NO_FATAL_FAILURE(twins.run(300));
  EXPECT_NE(twins.standing.linkPose(2).p.x(), before);
  ASSERT_NO_FATAL_FAILURE(twins.run(4000));
  EXPECT_TRUE(allStand(twins.standing));
}

TEST_P(Standing, ABoxOnASlopeStandsByItsFriction) {
  const double slope = 0.2;
  WorldSettings settings = settingsFor(GetParam());
  settings.gravity = kGravity * Vector3(std::sin(slope), 0, -std::cos(slope));
  Twins twins(cubeOnFloor(stiffCube(), settings));
  ASSERT_NO_FATAL_FAILURE(twins.run(1500));
  EXPECT_TRUE(allStand(twins.standing));
  const double across = twins.standing.contact(0).F_BP_W.force.x();
  EXPECT_NEAR(across, -0.1 * kGravity * std::sin(slope), 1e-9);  // mass 0.1 kg; on the cube
}

TEST_P(Standing, AHandWakesWhatItTouches) {
  const CubeParameters c = stiffCube();
  WorldDef def = stack(2, c, settingsFor(GetParam()));
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
  EXPECT_TRUE(allStand(twins.standing));
}

TEST_P(Standing, AHandThatComesLaterWakesWhatItPulls) {
  WorldDef def = stack(2, stiffCube(), settingsFor(GetParam()));
  PointerDef hand;
  hand.articulation = 2;
  hand.link = 0;
  hand.coupling.mode = PointerCoupling::Mode::kVirtual;
  def.pointers.push_back(hand);
  Twins twins(def);
  ASSERT_NO_FATAL_FAILURE(twins.run(300));
  ASSERT_TRUE(allStand(twins.standing)) << "a hand without a target does not act";
  const Pose start = twins.standing.linkPose(2);
  ASSERT_NO_FATAL_FAILURE(twins.run(300, [&](World& world) {
    world.setPointerTarget(0, Pose(start.R, start.p + Vector3(0, 0, 0.02)), Twist{});
  }));
  EXPECT_GT(twins.standing.linkPose(2).p.z(), start.p.z() + 1e-3);
}

TEST_P(Standing, NothingStandsOnWhatWasChanged) {
  Twins twins(stack(3, stiffCube(), settingsFor(GetParam())));
  ASSERT_NO_FATAL_FAILURE(twins.run(500));
  ASSERT_TRUE(allStand(twins.standing));
  const std::vector<double> saved = twins.standing.save();
  WorldTuning softer = twins.standing.tuning();
  softer.stiffness_scale = 0.5;
  const double high = twins.standing.linkPose(3).p.z();
  for (World* world : {&twins.standing, &twins.general}) world->tune(softer);
  ASSERT_NO_FATAL_FAILURE(twins.run(1500));
  EXPECT_LT(twins.standing.linkPose(3).p.z(), high - 1e-7);
  for (World* world : {&twins.standing, &twins.general}) world->restore(saved);
  ASSERT_NO_FATAL_FAILURE(twins.run(1500));
}

/// Soft bodies stand where k V holds their weight, and move again once something has hit them.
TEST(StandingByChoice, SoftBodiesStandToo) {
  CubeParameters c;
  c.stiffness = 1e6;
  WorldDef def = cubeOnFloor(c, settingsFor(Attempts::kAll), 1e-4);
  def.articulations.push_back(cube("falls", c, Pose(Vector3(0.03, 0.02, 3.25))));  // lands after 0.8 s
  Twins twins(def);
  ASSERT_NO_FATAL_FAILURE(twins.run(720));
  EXPECT_TRUE(twins.standing.stands(1));
  // It stands once it is slower than 5e-13 m/s, on its way to rest at about ω.
  const double omega = std::sqrt(c.stiffness * c.area() / c.mass);
  EXPECT_NEAR(twins.standing.linkPose(1).p.z(), 0.05 - c.restDepth(), 4 * 5e-13 / omega);
  int moves_again = 0;
  ASSERT_NO_FATAL_FAILURE(twins.run(4000, [&](World& world) { moves_again += !world.stands(1); }));
  EXPECT_GT(moves_again, 0);
  EXPECT_TRUE(allStand(twins.standing));
}

INSTANTIATE_TEST_SUITE_P(ImplicitSteps, Standing,
                         testing::Values(Attempts::kImplicitEuler, Attempts::kSdirk2, Attempts::kAll));

}  // namespace standing_islands_test
}  // namespace haptic
