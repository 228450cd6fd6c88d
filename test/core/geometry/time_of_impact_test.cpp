// Oracles: closed forms of a point and a corner on a plane, and brute force over small steps.
#include "haptic_core/geometry/pairs/time_of_impact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

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

}  // namespace time_of_impact_test
}  // namespace haptic
