/// Bodies whose motion is given: the curve, what they carry, what they push, and belts.
#include <gtest/gtest.h>

#include <limits>

#include "../../scenes/actors.h"
#include "../../scenes/turntable.h"
#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/half_space.h"

namespace haptic {
namespace led_motion_test {

using namespace scenes;

constexpr double kEps = std::numeric_limits<double>::epsilon();

Vector3 turnFrom(const Pose& from, const Pose& to) { return vectorFromRotation(Quaternion(Matrix3(to.R * from.R.transpose()))); }

/// The twist that is told is the rate of the poses that are told, and nothing jumps at the rows.
TEST(LedMotion, TwistsAreTheRatesOfPoses) {
  std::vector<Pose> path;
  for (int i = 0; i < 12; ++i) {
    path.emplace_back(rotationAbout(Vector3(1, i % 3 - 1, 0.5).normalized(), 0.9 * elementary::sin(1.3 * i)),
                      Vector3(elementary::sin(0.7 * i), 0.1 * i, elementary::cos(1.1 * i)));
  }
  World world(onCarrier(Load{}, WorldSettings{}, path, 0.1));
  const ModelMotion& motion = world.motion(0);
  const double e = 1e-5;
  for (double t = 0.003; t < 1.09; t += 0.0071) {
    const MotionPoint before = motionAt(motion, {}, t - e), at = motionAt(motion, {}, t), after = motionAt(motion, {}, t + e);
    const Vector3 v = (after.p_WL - before.p_WL) / (2 * e);
    const Vector3 omega = turnFrom(Pose(before.q_WL, {}), Pose(after.q_WL, {})) / (2 * e);
    // Speeds bend at the rows, by accelerations of up to 1e3; elsewhere the error is e² times their slope.
    EXPECT_LT((at.V_WL.linear - v).norm(), 2e3 * e + 8 * kEps / e) << t;
    EXPECT_LT((at.V_WL.angular - omega).norm(), 2e3 * e + 8 * kEps / e) << t;
  }
  for (std::size_t i = 0; i < path.size(); ++i) {
    const MotionPoint at = motionAt(motion, {}, motion.time[i]);
    EXPECT_LT((at.p_WL - path[i].p).norm(), 4 * kEps * 2);
    EXPECT_LT(turnFrom(path[i], Pose(at.q_WL, {})).norm(), 64 * kEps);
    const MotionPoint left = motionAt(motion, {}, motion.time[i] - 1e-9), right = motionAt(motion, {}, motion.time[i] + 1e-9);
    EXPECT_LT((left.V_WL.linear - right.V_WL.linear).norm(), 1e-5);
    EXPECT_LT((left.V_WL.angular - right.V_WL.angular).norm(), 1e-5);
  }
  EXPECT_EQ(motionAt(motion, {}, 0).V_WL.linear, Vector3::Zero());
  EXPECT_EQ(motionAt(motion, {}, 99).V_WL.angular, Vector3::Zero());
}

/// Rows a quarter turn apart: it turns at a constant rate, for ever.
TEST(LedMotion, ATurntableTurnsEvenly) {
  std::vector<Pose> path;
  for (int i = 0; i <= 4; ++i) path.emplace_back(rotationAbout(Vector3::UnitZ(), 0.5 * M_PI * i), Vector3(0.3, 0, 0));
  path[4] = path[0];
  World world(onCarrier(Load{}, WorldSettings{}, path, 0.5, true));
  for (const double t : {0.0, 0.123, 0.5, 1.77, 2.0, 13.579}) {
    const MotionPoint at = motionAt(world.motion(0), {}, t);
    EXPECT_NEAR(at.V_WL.angular.z(), M_PI, 1e-13) << t;
    const double turned = elementary::atan2(at.q_WL.toRotationMatrix()(1, 0), at.q_WL.toRotationMatrix()(0, 0));
    EXPECT_NEAR(std::remainder(turned - M_PI * t, 2 * M_PI), 0, 1e-13 * (1 + t));
  }
}

class Carried : public ::testing::TestWithParam<Attempts> {
 protected:
  WorldSettings settings() const {
    WorldSettings s;
    s.attempts = GetParam();
    return s;
  }
};

/// 3 s of a platform that wanders and turns, from rest to rest: what friction holds is where it was.
TEST_P(Carried, AStuckBodyStaysOnItsPlatform) {
  World world(onCarrier(Load{}, settings(), wandering(3, 0.05), 0.05));
  const Vector3 first = placeOnCarrier(world);
  double farthest = 0;
  while (world.time() < 3.7) {
    world.step();
    farthest = std::max(farthest, (placeOnCarrier(world) - first).norm());
  }
  EXPECT_TRUE(world.report().finite);
  EXPECT_LT((placeOnCarrier(world) - first).norm(), 1e-7);  // the elastic share is gone, to what is not yet damped
  EXPECT_GT(farthest, 1e-7) << "friction had nothing to hold";
  EXPECT_LT(farthest, 1e-4);
}

/// A bullet beside what a motion leads goes in spans; the motion is where it shall be at the end of each step.
TEST_P(Carried, SpansOfOthersLeaveTheMotionAlone) {
  WorldDef def = onCarrier(Load{}, settings(), wandering(2, 0.05), 0.05);
  def.articulations.push_back(staticBox("wall", Vector3(0.005, 1, 1), Pose(Vector3(3, 0, 0))));
  const Twist fast{Vector3::Zero(), Vector3(40, 0, 0)};
  def.articulations.push_back(freeBox("bullet", Vector3::Constant(0.02), 0.1, Pose(Vector3(2, 0, 0.2)), fast));
  World world(def);
  const Vector3 first = placeOnCarrier(world);
  int most = 0;
  while (world.time() < 2.4) {
    world.step();
    most = std::max(most, world.report().parts);
    const MotionPoint at = motionAt(world.motion(0), {}, world.time());
    ASSERT_LT((world.linkPose(0).p - at.p_WL).norm(), 1e-12) << world.time();
    ASSERT_LT((world.linkTwist(0).linear - at.V_WL.linear).norm(), 1e-12) << world.time();
  }
  EXPECT_GT(most, 1);
  EXPECT_LT((placeOnCarrier(world) - first).norm(), 1e-6);
}

/// A wall at 0.2 m/s meets a cube on ice: afterwards both have its speed, and what the wall put in is what the cube has and what was lost.
TEST_P(Carried, AWallPushes) {
  CubeParameters c;
  c.mu_static = c.mu_dynamic = 0;
  WorldDef def = cubeOnFloor(c, settings());
  def.articulations.push_back(freeBox("wall", Vector3(0.1, 0.5, 0.3), 1, Pose(Vector3(-0.2, 0, 0.2))));
  MotionDef motion;
  motion.name = "wall";
  motion.articulation = 2, motion.link = 0;
  for (int i = 0; i <= 20; ++i) motion.time.push_back(0.1 * i), motion.pose.emplace_back(Vector3(-0.2 + 0.02 * i, 0, 0.2));
  def.motions.push_back(motion);
  World world(def);
  while (world.time() < 1.85) world.step();
  EXPECT_TRUE(world.report().finite);
  EXPECT_NEAR(world.linkTwist(2).linear.x(), 0.2, 1e-12);
  EXPECT_GT(world.linkTwist(1).linear.x(), 0.2 * (1 - 1e-9)) << "it is pushed, or it has bounced off";
  EXPECT_LT(world.linkTwist(1).linear.x(), 0.4 * (1 + 1e-2)) << "no faster than an elastic blow of what has no end of mass";
  EXPECT_LT(world.linkTwist(1).angular.norm(), 0.1);
  const EnergyLedger& energy = world.report().energy;
  EXPECT_GT(energy.external, 0.5 * c.mass * 0.2 * 0.2 * 0.99);
  EXPECT_LT(std::abs(energy.numerical), 0.2 * energy.external);  // implicit Euler makes the blow plastic
}

TEST_P(Carried, ALiftCarriesItsWeight) {
  std::vector<Pose> path;
  for (int i = 0; i <= 40; ++i) {
    const double bell = 0.5 - 0.5 * elementary::cos(M_PI * i / 40);
    path.emplace_back(Vector3(0, 0, 0.5 * bell));
  }
  const Load load;
  World world(onCarrier(load, settings(), path, 0.05));
  const Vector3 first = placeOnCarrier(world);
  while (world.time() < 2.5) world.step();
  EXPECT_LT((placeOnCarrier(world) - first).norm(), 1e-7);
  EXPECT_NEAR(world.report().energy.external, load.mass * kGravity * 0.5, 2e-3 * load.mass * kGravity * 0.5);
}

/// Friction on a belt that slides under its load is μ m g, and then the load rides at the belt's speed.
TEST_P(Carried, ABeltDrivesItsLoad) {
  const Load load;
  const double speed = 4;
  World world(onBelt(load, settings(), speed));
  while (world.time() < 0.5) world.step();
  ASSERT_EQ(world.contactCount(), 1);
  const double force = load.mu * load.mass * kGravity;
  EXPECT_FALSE(world.contact(0).sticking);
  EXPECT_NEAR(world.contact(0).F_BP_W.force.x(), force, 1e-4 * force);
  EXPECT_NEAR(world.linkTwist(1).linear.x(), load.mu * kGravity * 0.5, 1e-3 * load.mu * kGravity * 0.5);
  while (world.time() < 2) world.step();
  EXPECT_TRUE(world.report().finite);
  EXPECT_NEAR(world.linkTwist(1).linear.x(), speed, 1e-6 * speed);
  EXPECT_TRUE(world.contact(0).sticking);
  // The belt put in μ m g times its way while it slid: half is motion, half is heat.
  const EnergyLedger& energy = world.report().energy;
  EXPECT_NEAR(energy.external, load.mass * speed * speed, 2e-2 * load.mass * speed * speed);
  EXPECT_NEAR(energy.friction + energy.damping, 0.5 * load.mass * speed * speed, 2e-2 * load.mass * speed * speed);
}

/// A load that a wrench holds back stands, while friction works.
TEST_P(Carried, ALoadThatIsHeldBackStandsOnItsBelt) {
  const Load load;
  WorldDef def = onBelt(load, settings(), 0.5);
  def.articulations.push_back(staticBox("stop", Vector3(0.1, 1, 1), Pose(Vector3(0.15, 0, 0.5))));
  World world(def);
  while (world.time() < 1) world.step();
  const double before = world.report().energy.friction, external = world.report().energy.external;
  while (world.time() < 2) world.step();
  EXPECT_LT(world.linkTwist(1).linear.norm(), 1e-5);
  const double force = load.mu * load.mass * kGravity;  // the stop has friction too, and carries a little of the weight
  EXPECT_NEAR(world.report().energy.friction - before, force * 0.5, 0.5 * force * 0.5);
  EXPECT_NEAR(world.report().energy.external - external, world.report().energy.friction - before, 1e-3 * force * 0.5);
}

INSTANTIATE_TEST_SUITE_P(Methods, Carried,
                         ::testing::Values(Attempts::kImplicitEuler,
                                           Attempts::kSdirk2, Attempts::kAll));

/// What turns on the spot: a disc-like belt turns what lies over its centre, at its own rate.
TEST(Belt, OneThatTurnsTurnsItsLoad) {
  const Load load;
  WorldDef def = onBelt(load, WorldSettings{}, 0, 4);
  def.articulations[0].X_WA = Pose(Vector3(0, 0, -0.25));
  def.articulations[0].links[0].collisions[0].belt.V_L.angular = Vector3(0, 0, 2);
  World world(def);
  while (world.time() < 3) world.step();
  EXPECT_NEAR(world.linkTwist(1).angular.z(), 2, 1e-6);
  EXPECT_LT(world.linkPose(1).p.head<2>().norm(), 1e-4);
}

/// A stuck load goes exactly as far as its belt, whatever the step: the surface's way is told, not a rate.
TEST(Belt, AStuckLoadGoesAsFarAsItsBelt) {
  for (const Attempts attempts :
       {Attempts::kImplicitEuler, Attempts::kSdirk2, Attempts::kAll}) {
    WorldSettings s;
    s.attempts = attempts;
    WorldDef def = onBelt(Load{}, s, 0.3);
    def.articulations[1].V_WA.linear = Vector3(0.3, 0, 0);
    World world(def);
    for (int i = 0; i < 100; ++i) world.step();
    const double x = world.linkPose(1).p.x(), t = world.time();
    for (int i = 0; i < 3000; ++i) world.step();
    EXPECT_NEAR(world.linkPose(1).p.x() - x, 0.3 * (world.time() - t), 1e-9) << static_cast<int>(attempts);
  }
}

/// A block at .8 of friction's limit rides on a circle, the elastic slip of its layer outward and no more, and its angle lags by the
/// square of the step.
TEST(Belt, OneThatTurnsCarriesItsLoadInACircle) {
  const double share = 0.8, slip = turntableSlip(share);
  for (const Attempts attempts : {Attempts::kImplicitEuler, Attempts::kSdirk2, Attempts::kAll}) {
    for (const double h : {1e-3, 2e-3}) {
      WorldDef def = onTurntable(share);
      def.settings.step = h;
      def.settings.attempts = attempts;
      World world(def);
      double most = 0, fall = 0;
      while (world.time() < 2 - 0.5 * h) {
        world.step();
        most = std::max(most, world.report().energy.friction);
        fall = std::max(fall, most - world.report().energy.friction);
      }
      const Turned end = turnedTo(world, share);
      EXPECT_NEAR(end.radius - kTurntableRadius, slip, 0.1 * slip) << h << " " << static_cast<int>(attempts);
      EXPECT_NEAR(end.beyond * kTurntableRadius, 0, 0.1 * slip) << h << " " << static_cast<int>(attempts);
      EXPECT_LT(fall, 1e-12) << h << " " << static_cast<int>(attempts);
    }
  }
}

TEST(LedMotion, ToldPosesAreReachedAndThenItStops) {
  World world(onCarrier(Load{}, WorldSettings{}, {}, 0));
  const MotionPoint to{Vector3(0.1, 0, 0), Quaternion(rotationAbout(Vector3::UnitZ(), 0.2)), {Vector3(0, 0, 0.4), Vector3(0.2, 0, 0)}};
  for (int i = 0; i < 10; ++i) world.step();
  EXPECT_EQ(world.linkTwist(0).linear, Vector3::Zero());
  ASSERT_TRUE(world.leadBody(world.motionIndex("carrier"), to, 0.5));
  for (int i = 0; i < 500; ++i) world.step();
  EXPECT_LT((world.linkPose(0).p - to.p_WL).norm(), 1e-12);
  EXPECT_LT((world.linkTwist(0).linear - to.V_WL.linear).norm(), 1e-10);
  EXPECT_LT((world.linkTwist(0).angular - to.V_WL.angular).norm(), 1e-10);
  for (int i = 0; i < 600; ++i) world.step();
  EXPECT_LT(world.linkTwist(0).linear.norm(), 1e-12) << "nobody told it more: it has slowed down";
  EXPECT_NEAR(world.linkPose(0).p.x(), 0.1 + 0.5 * 0.2 * 0.5, 1e-9);
  EXPECT_FALSE(world.leadBody(1, to, 1));
  EXPECT_FALSE(world.leadBody(0, {Vector3(NAN, 0, 0), Quaternion::Identity(), {}}, 1));
}

/// The carrier follows a sender of poses every 10 ms, which moves steadily, is silent for 3 s and comes back elsewhere, or is set back.
TEST(LedMotion, APoseThatJumpsIsApproached) {
  const double kPeriod = 0.01, kSpeed = 0.05;
  for (const double jump : {0.0, 0.004, 0.15, -1.0}) {
    World world(onCarrier(Load{}, WorldSettings{}, {}, 0));
    const int each = static_cast<int>(std::lround(kPeriod / world.settings().step));
    double told = 0, fastest = 0, left = 0;
    for (int message = 0; message < 600; ++message) {
      told += kSpeed * kPeriod + (message == 100 ? jump : 0.0);
      const MotionPoint to{Vector3(told, 0, 0), Quaternion::Identity(), {Vector3::Zero(), Vector3(kSpeed, 0, 0)}};
      ASSERT_TRUE(world.followBody(0, to, kPeriod));
      for (int i = 0; i < each; ++i) {
        world.step();
        fastest = std::max(fastest, std::abs(world.linkTwist(0).linear.x() - kSpeed));
      }
      left = std::abs(told - world.linkPose(0).p.x());
      if (message == 100 + static_cast<int>(1.5 * std::abs(jump) / kFollowSpeed / kPeriod) + 20) {
        EXPECT_LT(left, 1e-9) << "the gap of " << jump << " m is closed";
      }
    }
    EXPECT_LT(fastest, 25.0 / 16 * kFollowSpeed + kSpeed) << jump;
    EXPECT_LT(left, 1e-9) << jump;
  }
}

TEST(LedMotion, ATurnThatJumpsIsApproached) {
  World world(onCarrier(Load{}, WorldSettings{}, {}, 0));
  const MotionPoint to{Vector3::Zero(), Quaternion(rotationAbout(Vector3::UnitZ(), 1.5)), {}};
  double fastest = 0;
  for (int message = 0; message < 100; ++message) {
    ASSERT_TRUE(world.followBody(0, to, 0.01));
    for (int i = 0; i < 10; ++i) world.step(), fastest = std::max(fastest, world.linkTwist(0).angular.norm());
  }
  EXPECT_LT(fastest, 25.0 / 16 * kFollowTurn);
  EXPECT_LT(Quaternion(world.linkPose(0).R).angularDistance(to.q_WL), 1e-9);
}

TEST(LedMotion, IsPartOfTheStateAndOfTheReset) {
  const WorldDef def = onCarrier(Load{}, WorldSettings{}, wandering(1, 0.05), 0.05, true);
  World one(def), two(def);
  const std::vector<double> start = one.save();
  const std::uint64_t first = one.hash();
  for (int i = 0; i < 333; ++i) one.step();
  two.restore(one.save());
  for (int i = 0; i < 100; ++i) {
    ASSERT_EQ(one.hash(), two.hash());
    one.step(), two.step();
  }
  one.restore(start);
  EXPECT_EQ(one.hash(), first);
}

TEST(LedMotion, BadOnesAreRefusedInOneLine) {
  const auto problem = [](const WorldDef& def) -> std::string {
    try {
      World world(def);
    } catch (const SetupError& error) {
      return error.what();
    }
    return "";
  };
  WorldDef def = onCarrier(Load{}, WorldSettings{}, wandering(1, 0.1), 0.1);
  EXPECT_EQ(problem(def), "");
  WorldDef bad = def;
  bad.motions[0].time[3] = bad.motions[0].time[2];
  EXPECT_NE(problem(bad).find("row 4: does not come after the row before"), std::string::npos);
  bad = def;
  bad.motions[0].pose[3].R = rotationAbout(Vector3::UnitX(), 3.1) * bad.motions[0].pose[2].R;
  EXPECT_NE(problem(bad).find("row 4: turns by more than 3 rad"), std::string::npos);
  bad = def;
  bad.motions[0].repeat = true;
  bad.motions[0].pose.back().p.x() += 0.01;
  EXPECT_NE(problem(bad).find("close the path"), std::string::npos);
  bad = def;
  bad.motions.push_back(bad.motions[0]);
  EXPECT_NE(problem(bad).find("a motion already"), std::string::npos);
  bad = def;
  bad.articulations[0].links[0].joint.type = JointType::kFixed;
  EXPECT_NE(problem(bad).find("hangs on joints or is fixed"), std::string::npos);
  bad = def;
  PointerDef pointer;
  pointer.articulation = pointer.link = 0;
  bad.pointers.push_back(pointer);
  EXPECT_NE(problem(bad).find("led along carrier"), std::string::npos);
}

/// Of a surface that turns and has no end no speed bounds what it throws off.
TEST(Belt, OneWithoutEndRunsAndDoesNotTurn) {
  WorldDef def = cubeOnFloor({}, {});
  CollisionDef& floor = def.articulations[0].links[0].collisions[0];
  floor.shape = std::make_shared<HalfSpace>();
  floor.belt.V_L.linear = Vector3(0.1, 0, 0);
  EXPECT_NO_THROW(World{def});
  floor.belt.V_L.angular = Vector3(0, 0, 1);
  EXPECT_THROW(World{def}, SetupError);
}

/// A pointer presses on a platform that moves: it goes with it, in the hand's bounds, and nothing runs away.
TEST(LedMotion, AHandMayTouchIt) {
  WorldDef def = onCarrier(Load{}, WorldSettings{}, wandering(2, 0.05), 0.05, true);
  CubeParameters c;
  def.articulations.push_back(cube("tool", c, Pose(Vector3(-0.3, 0, 0.2))));
  PointerDef pointer;
  pointer.articulation = 2, pointer.link = 0;
  def.pointers.push_back(pointer);
  World world(def);
  bool pressed = false;
  for (int i = 0; i < 4000; ++i) {
    world.setPointerTarget(0, Pose(Vector3(-0.3, 0, 0.06)), Twist{});
    world.step();
    pressed |= world.pointerWrench(0).force.z() > 0.1;
    ASSERT_TRUE(world.report().finite);
  }
  EXPECT_TRUE(pressed);
}

}  // namespace led_motion_test
}  // namespace haptic
