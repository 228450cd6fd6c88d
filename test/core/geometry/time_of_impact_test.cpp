// Oracles: closed forms of a point and a corner on a plane, and brute force over small steps.
#include "haptic_core/geometry/pairs/time_of_impact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/search/gjk.h"
#include "haptic_core/geometry/shapes/shapes.h"

namespace haptic {
namespace time_of_impact_test {

ShapeMotion motion(const Pose& X_WS, const Twist& V_W, double reach) { return {X_WS, X_WS.p, V_W, reach}; }

TEST(TimeOfImpact, ABulletMeetsAPlateWhenItGetsThere) {
  const ConvexPolyhedron bullet = makeBox(Vector3::Constant(0.01)), plate = makeBox(Vector3(1, 1, 1e-3));
  const double clearance = 1e-5;
  for (double speed : {0.1, 10.0, 1000.0}) {
    const ShapeMotion a = motion(Pose(Vector3(0.1, 0.2, 0.5)), {Vector3::Zero(), Vector3(0, 0, -speed)}, 0.01);
    const ShapeMotion b = motion(Pose(), {}, 1);
    const double meet = (0.5 - 0.005 - 0.5e-3) / speed;
    Vector3 direction(0, 0, -1);
    const double found = timeOfImpact(bullet, a, plate, b, 10, clearance, direction);
    EXPECT_LE(found, meet);
    EXPECT_GE(found, meet - 2 * clearance / speed);
    EXPECT_EQ(timeOfImpact(bullet, a, plate, b, 0.9 * meet, clearance, direction), 0.9 * meet);
  }
}

TEST(TimeOfImpact, WhatPassesBySeesNothing) {
  const ConvexPolyhedron bullet = makeBox(Vector3::Constant(0.01)), plate = makeBox(Vector3(1, 1, 1e-3));
  const ShapeMotion a = motion(Pose(Vector3(0.51, 0, 0.5)), {Vector3::Zero(), Vector3(0, 0, -100)}, 0.01);
  Vector3 direction(0, 0, -1);
  EXPECT_EQ(timeOfImpact(bullet, a, plate, motion(Pose(), {}, 1), 0.1, 1e-5, direction), 0.1);
}

// A corner of the turning box comes down to the plane: half the diagonal times the cosine of what is left to turn.
TEST(TimeOfImpact, ATurningBoxTouchesWithItsCorner) {
  const ConvexPolyhedron box = makeBox(Vector3(0.2, 1, 0.2)), floor = makeBox(Vector3(2, 2, 0.2));
  const double diagonal = 0.1 * std::sqrt(2.0), height = 0.13, omega = 3;
  const ShapeMotion a =
      motion(Pose(Vector3(0, 0, height + 0.1)), {Vector3(0, omega, 0), Vector3::Zero()}, box.boundingRadius());
  Vector3 direction(0, 0, -1);
  const double meet = (M_PI / 4 - std::acos(height / diagonal)) / omega;
  const double found = timeOfImpact(box, a, floor, motion(Pose(), {}, 2), 1, 1e-7, direction);
  EXPECT_LE(found, meet);
  EXPECT_GE(found, meet - 1e-3);  // a turn is bounded by its fastest point: many short advances
}

TEST(TimeOfImpact, IsNeverLate) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto vector = [&](double scale) { return Vector3(scale * Vector3(normal(random), normal(random), normal(random))); };
  const ConvexPolyhedron A = makeBox(Vector3(0.3, 0.2, 0.01)), B = makeBox(Vector3(0.1, 0.4, 0.2));
  int met = 0;
  for (int i = 0; i < 300; ++i) {
    const ShapeMotion a = motion(Pose(Quaternion(vector(1).x(), 1, 0.3, 0.2).normalized(), vector(0.5)),
                                 {vector(5), vector(3)}, A.boundingRadius());
    const ShapeMotion b = motion(Pose(), {vector(5), vector(1)}, B.boundingRadius());
    Vector3 direction = Vector3::UnitX();
    const double found = timeOfImpact(A, a, B, b, 0.5, 1e-4, direction);
    met += found < 0.5;
    for (int k = 0; k < 200; ++k) {
      ClosestPoints closest;
      closestPoints(A, B, relativePose(a.at(found * k / 200), b.at(found * k / 200)), Vector3::UnitX(), closest);
      ASSERT_TRUE(found == 0 || closest.separated) << "pair " << i << " at " << k;
    }
  }
  EXPECT_GT(met, 20);
  EXPECT_LT(met, 270);
}

TEST(LeastWidth, IsTheThinnestSideOfABox) {
  EXPECT_NEAR(makeBox(Vector3(0.3, 0.001, 5)).leastWidth(), 0.001, 1e-15);
}

// A block goes straight into a floor: the way over the speed, and all the time where it stops short of that.
TEST(TimeOfDepth, IsTheWayOverTheSpeed) {
  const ConvexPolyhedron block = makeBox(Vector3::Constant(0.1)), floor = makeBox(Vector3(2, 2, 0.2));
  const double speed = 3, depth = 0.02, meet = 0.1;
  const ShapeMotion a = motion(Pose(Vector3(0, 0, 0.15 + speed * meet)), {Vector3::Zero(), Vector3(0, 0, -speed)}, 0.1);
  const ShapeMotion b = motion(Pose(), {}, 2);
  const Vector3 down(0, 0, -1);
  EXPECT_NEAR(timeOfDepth(block, a, floor, b, meet, 1, depth, down), meet + depth / speed, 1e-12);
  EXPECT_EQ(timeOfDepth(block, a, floor, b, meet, meet + 0.99 * depth / speed, depth, down), meet + 0.99 * depth / speed);
}

// A plate on its edge falls over, or two plates tumble together: parts far away move fast, and nothing gets deeper.
TEST(TimeOfDepth, WhatTipsOrTumblesTogetherHasAllTheTime) {
  const ConvexPolyhedron plate = makeBox(Vector3(0.4, 0.4, 0.01)), floor = makeBox(Vector3(2, 2, 0.2));
  const double omega = 10, h = 0.05, tilt = 1;  // [rad/s], [s], [rad] from lying
  const Matrix3 R = rotationFromVector(Vector3(0, tilt, 0)).toRotationMatrix();
  const Vector3 edge(0.2, 0, -0.005), p(0, 0, 0.1 - (R * edge).z());  // the edge is on the floor
  const Vector3 turn(0, -omega, 0);
  const ShapeMotion tipping = motion(Pose(R, p), {turn, turn.cross(-(R * edge))}, plate.boundingRadius());
  const ShapeMotion still = motion(Pose(), {}, 2);
  const double depth = 0.25 * 0.01;
  const Vector3 down(0, 0, -1);
  EXPECT_GT(approachRate(tipping, still, down) * h, 50 * depth);
  EXPECT_EQ(timeOfDepth(plate, tipping, floor, still, 0, h, depth, down), h);

  const Vector3 v(1, 2, 3);
  const ShapeMotion below = motion(Pose(), {turn, v}, plate.boundingRadius());
  const ShapeMotion above = motion(Pose(Vector3(0, 0, 0.01)), {turn, v + turn.cross(Vector3(0, 0, 0.01))}, plate.boundingRadius());
  EXPECT_EQ(timeOfDepth(plate, below, plate, above, 0, h, depth, -down), h);
}

// No deeper along the direction of contact, as it turns with one of them, than allowed; and cut short only where it would be.
TEST(TimeOfDepth, IsNeverLate) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  const auto vector = [&](double scale) { return Vector3(scale * Vector3(normal(random), normal(random), normal(random))); };
  const ConvexPolyhedron A = makeBox(Vector3(0.3, 0.2, 0.02)), B = makeBox(Vector3(0.1, 0.4, 0.2));
  const auto overlap = [&](const Pose& X_WA, const Pose& X_WB, const Vector3& n) {
    return supportHeight(A, X_WA, n) + supportHeight(B, X_WB, -n);
  };
  const double h = 0.01, depth = 0.25 * 0.02;
  int cut = 0;
  for (int i = 0; i < 300; ++i) {
    const Pose X_WA(Quaternion(1, normal(random), normal(random), normal(random)).normalized(), vector(0.1));
    const Vector3 n = vector(1).normalized();
    const ShapeMotion b = motion(Pose(Vector3::Zero()), {vector(8), vector(1)}, B.boundingRadius());
    ShapeMotion a = motion(X_WA, {vector(8), vector(1)}, A.boundingRadius());
    a.X_WS.p -= overlap(a.X_WS, b.X_WS, n) * n;  // touching along n
    a.p_W = a.X_WS.p;
    const double t = timeOfDepth(A, a, B, b, 0, h, depth, n);
    double deep = std::numeric_limits<double>::infinity();
    const Pose X_A = a.at(t), X_B = b.at(t);
    const Vector3 with_A = X_A.R * a.X_WS.R.transpose() * n, with_B = X_B.R * b.X_WS.R.transpose() * n;
    for (const Vector3& direction : {with_A, with_B}) deep = std::min(deep, overlap(X_A, X_B, direction));
    EXPECT_LE(deep, depth + 1e-12);
    if (t == h) continue;
    ++cut;
    const Pose E_A = a.at(h), E_B = b.at(h);
    EXPECT_GT(overlap(E_A, E_B, E_A.R * a.X_WS.R.transpose() * n), depth);
    EXPECT_GT(overlap(E_A, E_B, E_B.R * b.X_WS.R.transpose() * n), depth);
  }
  EXPECT_GT(cut, 50);
  EXPECT_LT(cut, 250);
}

}  // namespace time_of_impact_test
}  // namespace haptic
