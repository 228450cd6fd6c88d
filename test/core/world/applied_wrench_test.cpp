/// Wrenches on links for a time, gravity while it runs, bodies and joints that are put elsewhere.
#include <gtest/gtest.h>

#include <limits>

#include "../../comparators/velocity_verlet.h"
#include "../../scenes/actors.h"
#include "haptic_core/base/error.h"
#include "haptic_core/world/model.h"

namespace haptic {
namespace applied_wrench_test {

using namespace scenes;

constexpr double kEps = std::numeric_limits<double>::epsilon();

LinkWrench inWorld(const Vector3& torque, const Vector3& force, const Vector3& p_L = Vector3::Zero()) {
  return {{torque, force}, p_L, false};
}

class Wrenches : public ::testing::TestWithParam<Attempts> {
 protected:
  WorldSettings settings() const {
    WorldSettings s;
    s.attempts = GetParam();
    return s;
  }
  /// Way after n steps at constant acceleration from rest.
  static double way(double acceleration, int n, double h) { return 0.5 * acceleration * h * h * n * n; }
};

/// n steps with force and torque, then as many without.
TEST_P(Wrenches, AFreeBodyMovesAsItsClosedFormSays) {
  const LoneBody body;
  WorldSettings s = settings();
  s.gravity = Vector3(0, 0, -3);
  World world(alone(body, s));
  const Vector3 force(2, -1, 0.5);
  const double torque = 0.01, inertia = body.inertia()(2, 2), h = s.step;
  world.step();  // so that something is remembered that no longer holds
  const Vector3 p0 = world.linkPose(0).p, v0 = world.linkTwist(0).linear;
  const int n = 200;
  world.applyWrench(0, inWorld(Vector3(0, 0, torque), force), n * h);
  for (int i = 0; i < n; ++i) world.step();
  const Vector3 a = force / body.mass + s.gravity;
  const double rounding = 64 * n * kEps;  // sums of n steps, and the solves' own
  Vector3 p = p0 + n * h * v0 + Vector3(way(a.x(), n, h), way(a.y(), n, h), way(a.z(), n, h)), v = v0 + n * h * a;
  EXPECT_LT((world.linkPose(0).p - p).norm(), rounding * (p.norm() + 1));
  EXPECT_LT((world.linkTwist(0).linear - v).norm(), rounding * (v.norm() + 1));
  const double turn = way(torque / inertia, n, h), rate = n * h * torque / inertia;
  EXPECT_NEAR(vectorFromRotation(Quaternion(world.linkPose(0).R)).z(), turn, rounding);
  EXPECT_NEAR(world.linkTwist(0).angular.z(), rate, rounding);
  EXPECT_EQ(world.wrenchCount(), 1) << "until the next step begins";
  for (int i = 0; i < n; ++i) world.step();
  EXPECT_EQ(world.wrenchCount(), 0);
  p += n * h * v + Vector3(way(0, n, h), way(0, n, h), way(s.gravity.z(), n, h));
  EXPECT_LT((world.linkPose(0).p - p).norm(), 2 * rounding * (p.norm() + 1));
  EXPECT_NEAR(world.linkTwist(0).angular.z(), rate, 2 * rounding);
}

/// A force at a point of the link is one at the centre of mass and a torque; in the link it turns with it.
TEST_P(Wrenches, ThePointAndTheFrameAreTheLinks) {
  const LoneBody body;
  WorldSettings s = settings();
  s.gravity.setZero();
  const Pose X_WL(rotationAbout(Vector3(1, 2, 3).normalized(), 0.7), Vector3(1, 2, 3));
  World one(alone(body, s, X_WL)), other(alone(body, s, X_WL));
  const Vector3 p_L(0.02, 0.05, -0.1), f_L(0.3, 0.1, -0.2), t_L(0.001, -0.002, 0.003);
  one.applyWrench(0, {{t_L, f_L}, p_L, true}, 0.1);
  other.applyWrench(0, {{t_L + p_L.cross(f_L), f_L}, Vector3::Zero(), true}, 0.1);
  for (int i = 0; i < 100; ++i) one.step(), other.step();
  EXPECT_LT((one.linkPose(0).p - other.linkPose(0).p).norm(), 1e4 * kEps);
  EXPECT_LT((one.linkPose(0).R - other.linkPose(0).R).norm(), 1e4 * kEps);
  // Halving the step shows what the closed form of the turning body is.
  WorldSettings fine = s;
  fine.step = s.step / 64;
  fine.comparator = comparators::velocityVerlet;
  World reference(alone(body, fine, X_WL));
  reference.applyWrench(0, {{t_L, f_L}, p_L, true}, 0.1);
  for (int i = 0; i < 6400; ++i) reference.step();
  const double order1 = 5e-2 * (reference.linkPose(0).p - X_WL.p).norm();
  EXPECT_LT((one.linkPose(0).p - reference.linkPose(0).p).norm(), order1);
  EXPECT_GT((reference.linkPose(0).p - X_WL.p).norm(), 1e-3);
}

/// A force in W has a potential: what it puts in is in the ledger, to the step's own error.
TEST_P(Wrenches, TheLedgerHasItsWork) {
  const LoneBody body;
  World world(alone(body, settings()));
  world.step();
  const double before = world.report().energy.balance();
  world.applyWrench(0, inWorld(Vector3(0, 0, 0.02), Vector3(3, 1, 8), Vector3(0.03, 0.05, 0.1)), 0.3);
  for (int i = 0; i < 300; ++i) world.step();
  const EnergyLedger& energy = world.report().energy;
  EXPECT_GT(std::abs(energy.external), 0.1);
  EXPECT_NEAR(energy.balance(), before, 1e-4 * std::abs(energy.external));
}

/// A double pendulum under gravity for 0.1 s and for 0.2 s more with m Δg besides at each link's centre of mass, about points and in the
/// frame of W: largest differences of position and of velocity from one whose gravity changes by Δg [rad, rad/s].
Vector2 missOfGravity(WorldSettings settings, double damping) {
  const auto pendulum = [&](const Vector3& gravity) {
    WorldDef def;
    def.name = "pendulum";
    def.settings = settings;
    def.settings.gravity = gravity;
    ArticulationDef arm = freeBox("arm", Vector3(0.05, 0.05, 0.4), 0.5, Pose());
    arm.links.push_back(arm.links[0]);
    for (int i = 0; i < 2; ++i) {
      LinkDef& link = arm.links[static_cast<std::size_t>(i)];
      link.name = link.joint.name = "link" + std::to_string(i);
      link.parent = i - 1;
      link.collisions.clear();
      link.inertia.p_LC = Vector3(0.02, 0, -0.2);
      link.joint.type = JointType::kRevolute;
      link.joint.axis = Vector3::UnitY();
      link.joint.damping = damping;
      if (i == 1) link.joint.X_PJ = Pose(Vector3(0, 0, -0.4));
    }
    def.articulations.push_back(arm);
    return def;
  };
  const Vector3 g(0, 0, -9.8), more(4, 0, 2);
  World pushed(pendulum(g)), tuned(pendulum(g));
  const long steps = std::lround(0.1 / settings.step);
  for (long i = 0; i < steps; ++i) pushed.step(), tuned.step();
  for (int l = 0; l < 2; ++l) pushed.applyWrench(l, inWorld(Vector3::Zero(), 0.5 * more, Vector3(0.02, 0, -0.2)), 0.2);
  WorldTuning tuning = tuned.tuning();
  tuning.gravity = g + more;
  tuned.tune(tuning);
  for (long i = 0; i < 2 * steps; ++i) pushed.step(), tuned.step();
  EXPECT_GT(std::abs(pushed.joint(0).position), 0.05);
  Vector2 most(0, 0);
  for (int j = 0; j < 2; ++j) {
    const JointReading a = pushed.joint(j), b = tuned.joint(j);
    most = most.cwiseMax(Vector2(a.position - b.position, a.velocity - b.velocity).cwiseAbs());
  }
  return most;
}

/// On joints with and without laws. Explicit steps move both to fourth order under gravity; wrenches kick those without laws, to second
/// order, and pull at those with laws as they are where a step starts, to first.
TEST_P(Wrenches, OnAllLinksTheyAreGravity) {
  const bool is_explicit = GetParam() != Attempts::kImplicitEuler && GetParam() != Attempts::kSdirk2;
  for (const double damping : {0.0, 1e-3}) {
    WorldSettings fine = settings();
    fine.step *= 0.5;
    const Vector2 miss = missOfGravity(settings(), damping), less = missOfGravity(fine, damping);
    if (is_explicit) {
      const double gain = damping == 0 ? 4 : 2;
      EXPECT_NEAR(miss[0] / less[0], gain, 0.1 * gain) << "damping " << damping;
      EXPECT_NEAR(miss[1] / less[1], gain, 0.1 * gain) << "damping " << damping;
    }
    const double order = !is_explicit ? 1e-9 : damping == 0 ? 1e-5 : 1e-3;
    EXPECT_LT(miss[0], order) << "damping " << damping;
    EXPECT_LT(miss[1], 10 * order) << "damping " << damping;
  }
}

/// Pressed down and pushed aside, a cube on the floor: what friction holds it holds, and it stands again afterwards.
TEST_P(Wrenches, APushBelowFrictionMovesNothing) {
  CubeParameters c;
  World world(cubeOnFloor(c, settings()));
  for (int i = 0; i < 500; ++i) world.step();
  const Vector3 before = world.linkPose(1).p;
  world.applyWrench(1, inWorld(Vector3::Zero(), Vector3(0.4 * c.mass * kGravity, 0, 0), Vector3(0, 0, -c.size / 2)), 1);
  for (int i = 0; i < 1000; ++i) world.step();
  ASSERT_EQ(world.contactCount(), 1);
  EXPECT_NEAR(world.contact(0).F_BP_W.force.x(), -0.4 * c.mass * kGravity, 1e-6);
  const double elastic = 0.4 * c.mass * kGravity / (c.tangential * c.stiffness * c.area());
  EXPECT_NEAR(world.linkPose(1).p.x() - before.x(), elastic, 1e-2 * elastic);
  for (int i = 0; i < 1000; ++i) world.step();
  EXPECT_NEAR(world.linkPose(1).p.x(), before.x(), 1e-3 * elastic);
}

INSTANTIATE_TEST_SUITE_P(Methods, Wrenches,
                         ::testing::Values(Attempts::kImplicitEuler,
                                           Attempts::kSdirk2, Attempts::kAll));

TEST(AppliedWrench, IsPartOfTheState) {
  CubeParameters c;
  const WorldDef def = stack(3, c, WorldSettings{});
  World one(def), two(def);
  for (int i = 0; i < 50; ++i) one.step();
  one.applyWrench(2, inWorld(Vector3(0, 0, 0.01), Vector3(1, 0, 0)), 0.1);
  for (int i = 0; i < 40; ++i) one.step();
  two.restore(one.save());
  EXPECT_EQ(two.wrenchCount(), 1);
  for (int i = 0; i < 200; ++i) {
    ASSERT_EQ(one.hash(), two.hash()) << i;
    one.step(), two.step();
  }
}

/// Who stands is not computed; a push wakes it, and its end as well.
TEST(AppliedWrench, WakesWhatStands) {
  CubeParameters c;
  World world(cubeOnFloor(c, WorldSettings{}));
  for (int i = 0; i < 3000; ++i) world.step();
  const Vector3 before = world.linkPose(1).p;
  world.applyWrench(1, inWorld(Vector3::Zero(), Vector3(0, 0, 2 * c.mass * kGravity)), 0.05);
  for (int i = 0; i < 50; ++i) world.step();
  EXPECT_NEAR(world.linkTwist(1).linear.z(), 0.05 * kGravity, 0.02 * kGravity);
  for (int i = 0; i < 3000; ++i) world.step();
  EXPECT_NEAR(world.linkPose(1).p.z(), before.z(), 1e-6);
}

TEST(AppliedWrench, BadOnesAreRefusedInOneLine) {
  CubeParameters c;
  World world(cubeOnFloor(c, WorldSettings{}));
  const auto problem = [&](int link, const LinkWrench& wrench, double seconds) -> std::string {
    try {
      world.applyWrench(link, wrench, seconds);
    } catch (const SetupError& error) {
      return error.what();
    }
    return "";
  };
  const LinkWrench push = inWorld(Vector3::Zero(), Vector3(1, 0, 0));
  EXPECT_NE(problem(2, push, 1).find("no link 2"), std::string::npos);
  EXPECT_NE(problem(0, push, 1).find("fixed"), std::string::npos);
  EXPECT_NE(problem(1, push, -1).find("give 0 to 86400 s"), std::string::npos);
  EXPECT_NE(problem(1, push, NAN).find("give 0 to 86400 s"), std::string::npos);
  EXPECT_NE(problem(1, inWorld(Vector3(NAN, 0, 0), Vector3::Zero()), 1).find("not finite"), std::string::npos);
  EXPECT_EQ(world.wrenchCount(), 0);
  for (int i = 0; i < kMostWrenches; ++i) EXPECT_EQ(problem(1, push, 1), "");
  EXPECT_NE(problem(1, push, 1).find("32 act already"), std::string::npos);
  EXPECT_EQ(problem(1, push, 0), "");
  EXPECT_EQ(world.wrenchCount(), 0);
}

TEST(Put, ABodyGoesWhereItIsPutAndItsContactsBeginAnew) {
  CubeParameters c;
  World world(cubeOnFloor(c, WorldSettings{}));
  world.applyWrench(1, inWorld(Vector3::Zero(), Vector3(0.4 * c.mass * kGravity, 0, 0)), 0.5);
  for (int i = 0; i < 500; ++i) world.step();  // friction holds something
  const Pose X_WL(rotationAbout(Vector3::UnitZ(), 0.3), Vector3(0.5, 0.2, c.size / 2 - c.restDepth()));
  world.setBodyPose(1, X_WL, Twist{});
  EXPECT_LT((world.linkPose(1).p - X_WL.p).norm(), 4 * kEps);
  EXPECT_LT((world.linkPose(1).R - X_WL.R).norm(), 16 * kEps);
  World fresh([&] {
    WorldDef def = cubeOnFloor(c, WorldSettings{});
    def.articulations[1].X_WA = X_WL;
    return def;
  }());
  for (int i = 0; i < 300; ++i) {
    world.step(), fresh.step();
    ASSERT_LT((world.linkPose(1).p - fresh.linkPose(1).p).norm(), 1e-12) << i;
  }
  const Twist V{Vector3(0, 0, 3), Vector3(0.1, 0, 1)};
  world.setBodyPose(1, Pose(Vector3(0, 0, 1)), V);
  EXPECT_LT((world.linkTwist(1).linear - V.linear).norm() + (world.linkTwist(1).angular - V.angular).norm(), 1e-15);
}

/// What is put deep into others parts as what starts there: slowly.
TEST(Put, WhatIsPutIntoTheFloorIsPushedOutSlowly) {
  CubeParameters c;
  World world(cubeOnFloor(c, WorldSettings{})), fresh(cubeOnFloor(c, WorldSettings{}, c.restDepth() - 0.5 * c.size));
  for (int i = 0; i < 100; ++i) world.step();
  world.setBodyPose(1, Pose(Vector3(0, 0, 0)), Twist{});
  for (int i = 0; i < 2000; ++i) {
    world.step(), fresh.step();
    ASSERT_LT((world.linkPose(1).p - fresh.linkPose(1).p).norm(), 1e-12) << i;
  }
  EXPECT_GT(world.linkPose(1).p.z(), 0.02);
}

/// F h²/m is the way of a free body in a step, τ h²/I its turn: up to its size, up to a radian, with all that act on it.
TEST(Wrench, ThatNoStepResolvesIsRefused) {
  const LoneBody body;
  World world(alone(body, WorldSettings{}));
  const double h = world.settings().step, size = world.model().links[0].size;
  const Vector3 most = body.mass * size / (h * h) * Vector3::UnitX(), turn = body.inertia()(2, 2) / (h * h) * Vector3::UnitZ();
  for (const Vector3& force : {Vector3(1.01 * most), Vector3(1e9 * Vector3::UnitZ())}) {
    EXPECT_THROW(world.applyWrench(0, inWorld(Vector3::Zero(), force), h), SetupError);
  }
  EXPECT_THROW(world.applyWrench(0, inWorld(1.01 * turn, Vector3::Zero()), h), SetupError);
  world.applyWrench(0, inWorld(0.99 * turn, Vector3::Zero()), h);
  world.applyWrench(0, inWorld(Vector3::Zero(), 0.99 * most), h);
  EXPECT_THROW(world.applyWrench(0, inWorld(Vector3::Zero(), 0.02 * most), h), SetupError);
  world.applyWrench(0, LinkWrench{}, 0);
  EXPECT_NO_THROW(world.applyWrench(0, inWorld(Vector3::Zero(), 0.02 * most), h));
  world.step();
  EXPECT_TRUE(world.report().finite);
}

TEST(Put, HandsFixedBodiesAndJointsAreLeft) {
  CubeParameters c;
  WorldDef def = cubeOnFloor(c, WorldSettings{});
  def.articulations.push_back(cube("tool", c, Pose(Vector3(0, 0, 1))));
  PointerDef pointer;
  pointer.articulation = 2, pointer.link = 0;
  def.pointers.push_back(pointer);
  World world(def);
  EXPECT_THROW(world.setBodyPose(0, Pose(), Twist{}), SetupError);
  EXPECT_THROW(world.setBodyPose(2, Pose(), Twist{}), SetupError);
  EXPECT_THROW(world.setBodyPose(7, Pose(), Twist{}), SetupError);
  EXPECT_THROW(world.setBodyPose(1, Pose(Vector3(NAN, 0, 0)), Twist{}), SetupError);
  EXPECT_THROW(world.setJointPositions({{0, 0.0}}), SetupError);
  EXPECT_THROW(world.applyWrench(2, inWorld(Vector3::Zero(), Vector3::UnitX()), 1), SetupError);
}

TEST(Gravity, ChangesWhileItRunsAndIsBounded) {
  World world(alone(LoneBody{}, WorldSettings{}));
  WorldTuning tuning = world.tuning();
  EXPECT_EQ(tuning.gravity, world.settings().gravity);
  tuning.gravity = Vector3(1, 2, 3);
  world.tune(tuning);
  EXPECT_EQ(world.settings().gravity, Vector3(1, 2, 3));
  for (int i = 0; i < 100; ++i) world.step();
  EXPECT_LT((world.linkTwist(0).linear - 0.1 * Vector3(1, 2, 3)).norm(), 1e-12);
  tuning.gravity = Vector3(0, 0, NAN);
  EXPECT_THROW(world.tune(tuning), SetupError);
  tuning.gravity = Vector3(0, 0, 1e4);
  EXPECT_THROW(world.tune(tuning), SetupError);
  WorldTuning rest;  // gravity is NaN: as it is
  rest.friction_scale = 0.25;
  world.tune(rest);
  EXPECT_EQ(world.settings().gravity, Vector3(1, 2, 3));
  EXPECT_EQ(world.tuning().friction_scale, 0.25);
}

}  // namespace applied_wrench_test
}  // namespace haptic
