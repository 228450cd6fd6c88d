// Dampers and bodies that turn along their own surface: what rolls compresses nothing, what rocks does.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "../geometry/random_pairs.h"
#include "haptic_core/contact/pressure_law.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/cone.h"
#include "haptic_core/geometry/shapes/ellipsoid.h"
#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/geometry/shapes/shapes.h"

namespace haptic {
namespace rolling_test {

using random_pairs::Contact;
using random_pairs::contactOf;

ContactMaterial material() {
  ContactMaterial m;
  m.stiffness = 1e7;
  m.damping = 1e4;
  m.dissipation = 10;
  return m;
}

/// Torque about P of the pressure, on B in P's axes.
Vector3 torqueOf(const NormalPressure& p) { return {p.first.y(), -p.first.x(), 0}; }

/// B's axis of revolution lies along y of the half-space, its surface reaches 1 mm into it.
Pose lying(double height) {
  Matrix3 R;
  R << 1, 0, 0, 0, 0, 1, 0, -1, 0;  // z to y
  return {R, Vector3(0, 0, height - 1e-3)};
}

class Rolling : public testing::TestWithParam<PressureLaw> {};

TEST_P(Rolling, CompressesNothing) {
  const HalfSpace floor;
  for (const std::shared_ptr<const ConvexShape>& shape :
       {std::shared_ptr<const ConvexShape>(std::make_shared<Ball>(0.02)),
        std::shared_ptr<const ConvexShape>(std::make_shared<Rod>(0.02, 0.1, Rod::Ends::kRound)),
        std::shared_ptr<const ConvexShape>(std::make_shared<Rod>(0.02, 0.1, Rod::Ends::kFlat)),
        std::shared_ptr<const ConvexShape>(std::make_shared<Ellipsoid>(Vector3(0.02, 0.02, 0.05)))}) {
    Contact c = contactOf(floor, *shape, lying(0.02));
    ASSERT_EQ(c.volume.status, ContactVolume::Status::kOverlap);
    const Vector3 axis_P = c.volume.X_AP.R.transpose() * Vector3::UnitY(), across_P = c.volume.X_AP.R.transpose() * Vector3::UnitX();
    // At P nothing slips: B turns about its axis of revolution, and its centre moves over the floor.
    const NormalPressure p = normalPressure(c.volume, c.workspace, {25 * axis_P, Vector3::Zero()}, GetParam(), material());
    EXPECT_NEAR(p.force, 1e7 * c.volume.volume, 1e-12 * p.force) << shape->name();
    EXPECT_NEAR(torqueOf(p).norm(), 0, 1e-12 * p.force * p.radius) << shape->name();
    // Turned about the direction in which it rolled, rods lower one end and lift the other. Balls and ellipsoids roll this way as well.
    const NormalPressure rocks = normalPressure(c.volume, c.workspace, {0.1 * across_P, Vector3::Zero()}, GetParam(), material());
    EXPECT_NEAR(torqueOf(rocks).dot(axis_P), 0, 1e-12 * p.force * p.radius) << shape->name();
    const Matrix2 moments = jumpsAtTouch(GetParam()) ? Matrix2(1e4 * c.volume.A2) : Matrix2(1e7 * 10 * c.volume.V2);
    const Vector2 slope = (shape->rod() ? 0.1 : 0) * Vector2(across_P.y(), -across_P.x());
    const double expected = slope.dot(moments * slope) / 0.1;
    EXPECT_NEAR(-torqueOf(rocks).dot(across_P), expected, 1e-12 * p.force * p.radius) << shape->name();
  }
}

// Over a tile's edge, where V lies beside the ball's centre, as over any of several pieces.
TEST_P(Rolling, CompressesNothingBesideTheCentre) {
  const ConvexPolyhedron tile = makeBox(Vector3(0.2, 0.2, 0.1));
  const Ball ball(0.02);
  const Vector3 centre(0.101, 0, 0.069);
  Contact c = contactOf(tile, ball, Pose(Matrix3::Identity(), centre));
  ASSERT_EQ(c.volume.status, ContactVolume::Status::kOverlap);
  ASSERT_GT((c.volume.X_AP.p - centre).head<2>().norm(), 1e-4);
  const Vector3 turn(3, 25, 0), to_P = c.volume.X_AP.p - centre;
  // The centre moves along the patch alone.
  const Matrix3 into_P = c.volume.X_AP.R.transpose();
  const Vector3 way = 0.5 * c.volume.X_AP.R.col(0);
  const NormalPressure p =
      normalPressure(c.volume, c.workspace, {into_P * turn, into_P * (way + turn.cross(to_P))}, GetParam(), material());
  EXPECT_NEAR(p.force, 1e7 * c.volume.volume, 1e-12 * p.force);
  EXPECT_NEAR(torqueOf(p).norm(), 0, 1e-12 * p.force * p.radius);
}

/// A body of revolution, tilted, 0.2 mm deep in a half-space.
Contact tiltedOnFloor(const HalfSpace& floor, const ConvexShape& shape, double tilt, Pose& X_FB) {
  X_FB.R = (Eigen::AngleAxisd(0.3, Vector3::UnitZ()) * Eigen::AngleAxisd(tilt, Vector3::UnitY())).toRotationMatrix();
  const Vector3 lowest = shape.core(X_FB.R.transpose() * -Vector3::UnitZ());
  X_FB.p = Vector3(0.1, 0.2, -2e-4 + shape.rounding() - X_FB.R.row(2).dot(lowest));
  return contactOf(floor, shape, X_FB);
}

// Turns of the body about its axis, of the floor about its normal, anywhere, and slides along the floor leave the overlap congruent,
// at every tilt: the coin that rolls on its edge turns about both axes.
TEST_P(Rolling, AtEveryTiltCompressesNothing) {
  const HalfSpace floor;
  for (const std::shared_ptr<const ConvexShape>& shape :
       {std::shared_ptr<const ConvexShape>(std::make_shared<Rod>(0.0375, 0.001, Rod::Ends::kFlat)),
        std::shared_ptr<const ConvexShape>(std::make_shared<Rod>(0.02, 0.1, Rod::Ends::kFlat)),
        std::shared_ptr<const ConvexShape>(std::make_shared<Rod>(0.02, 0.05, Rod::Ends::kRound)),
        std::shared_ptr<const ConvexShape>(std::make_shared<Cone>(0.03, 0.01, 0.06)),
        std::shared_ptr<const ConvexShape>(std::make_shared<Ellipsoid>(Vector3(0.02, 0.02, 0.05)))}) {
    for (const double tilt : {0.03, 0.1, 0.35, 0.7, 1.2, 1.5}) {
      Pose X_FB;
      Contact c = tiltedOnFloor(floor, *shape, tilt, X_FB);
      ASSERT_EQ(c.volume.status, ContactVolume::Status::kOverlap);
      const Matrix3 into_P = c.volume.X_AP.R.transpose();
      const Vector3 spin = 12 * X_FB.R.col(2), yaw(0, 0, -7), slide(0.3, 0.1, 0);
      const Vector3 at_P = slide + spin.cross(c.volume.X_AP.p - X_FB.p) + yaw.cross(c.volume.X_AP.p);
      const NormalPressure p = normalPressure(c.volume, c.workspace, {into_P * (spin + yaw), into_P * at_P}, GetParam(), material());
      EXPECT_NEAR(p.force, p.elastic_force, 1e-9 * p.elastic_force) << shape->name() << " " << tilt;
      EXPECT_NEAR(torqueOf(p).norm(), 0, 1e-9 * p.elastic_force * p.radius) << shape->name() << " " << tilt;
    }
  }
}

// A coin on its face: a tilt that leaves the whole face pressed rocks, about every axis alike; the damper's share vanishes smoothly as it
// comes to stand on its edge.
TEST_P(Rolling, ACoinOnItsFaceRocks) {
  const HalfSpace floor;
  const Rod coin(0.0375, 0.001, Rod::Ends::kFlat);
  double last = 2;
  for (const double tilt : {0.0, 1e-5, 1e-3, 2e-3, 3e-3, 4e-3, 6e-3, 1e-2, 2e-2}) {
    Pose X_FB;
    X_FB.R = Eigen::AngleAxisd(tilt, Vector3::UnitY()).toRotationMatrix();
    X_FB.p = Vector3(0, 0, 5e-4 - 1e-4 + std::max(0.0, tilt * 0.0375 - 1e-4));
    const Contact c = contactOf(floor, coin, X_FB);
    // The axis that leans turns the lower side on: a turn about x.
    const Vector2 slope = c.volume.X_AP.R.topLeftCorner<2, 2>().transpose() * Vector2(0, -1);
    const double share = slope.dot(c.volume.compressing.slope * slope);
    EXPECT_LE(share, last + 1e-12) << tilt;
    if (tilt < 1e-4) EXPECT_NEAR(share, 1, 1e-2);
    if (tilt > 9e-3) EXPECT_NEAR(share, 0, 1e-12);
    EXPECT_NEAR(Vector2(slope.y(), -slope.x()).dot(c.volume.compressing.slope * Vector2(slope.y(), -slope.x())), 1, 1e-9) << tilt;
    last = share;
  }
}

// Two bodies of revolution in one another: both turn about their own axes, and the overlap stays.
TEST_P(Rolling, PairsCompressNothing) {
  const std::vector<std::shared_ptr<const ConvexShape>> shapes{
      std::make_shared<Ball>(0.03), std::make_shared<Rod>(0.02, 0.08, Rod::Ends::kRound),
      std::make_shared<Rod>(0.02, 0.06, Rod::Ends::kFlat), std::make_shared<ConvexPolyhedron>(makeBox(Vector3(0.05, 0.06, 0.07)))};
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  int tried = 0;
  for (int i = 0; i < 40000 && tried < 200; ++i) {
    const ConvexShape &A = *shapes[random() % shapes.size()], &B = *shapes[random() % shapes.size()];
    const Pose X_AB = random_pairs::randomPose(random, 0.08);
    Contact c = contactOf(A, B, X_AB);
    if (c.volume.status != ContactVolume::Status::kOverlap || c.volume.depth > 5e-4 || !(A.spins() || B.spins())) continue;
    const Matrix3 into_P = c.volume.X_AP.R.transpose();
    const Vector3 P = c.volume.X_AP.p;
    // Of two rods that are all but parallel, or stand on an end, some slope stays.
    if (c.volume.compressing.slope.norm() > 1e-9 && A.spins() && B.spins()) continue;
    ++tried;
    const Vector3 of_A = A.spins() ? Vector3(9 * normal(random) * Vector3::UnitZ()) : Vector3::Zero();
    const Vector3 of_B = B.spins() ? Vector3(9 * normal(random) * X_AB.R.col(2)) : Vector3::Zero();
    Twist V{of_B - of_A, of_B.cross(P - X_AB.p) - of_A.cross(P)};
    const NormalPressure p = normalPressure(c.volume, c.workspace, V.rotated(into_P), GetParam(), material());
    // Where V lies half in a capsule's round end, turns about that end count in part: 1e-3 of the elastic force on other rods.
    const double off = (A.rod() && B.rod() ? 3e-3 : 1e-9) * p.elastic_force;
    EXPECT_NEAR(p.force, p.elastic_force, off) << A.name() << " " << B.name();
    EXPECT_NEAR(torqueOf(p).norm(), 0, off * p.radius) << A.name() << " " << B.name();
  }
  EXPECT_EQ(tried, 200);
}

INSTANTIATE_TEST_SUITE_P(Laws, Rolling, testing::Values(PressureLaw::kLinear, PressureLaw::kHuntCrossley));

// The damper's wrench on B takes power from every motion, its tangent is the derivative, and neither depends on the order of the bodies
// beyond rounding: over all kinds, poses and twists.
TEST(RollingPairs, DampersOnlyTake) {
  std::vector<std::shared_ptr<const ConvexShape>> shapes{
      std::make_shared<Ball>(0.03),       std::make_shared<Rod>(0.02, 0.08, Rod::Ends::kRound),
      std::make_shared<Rod>(0.02, 0.08, Rod::Ends::kFlat), std::make_shared<Ellipsoid>(Vector3(0.02, 0.03, 0.04)),
      std::make_shared<Cone>(0.03, 0.01, 0.06), std::make_shared<ConvexPolyhedron>(makeBox(Vector3(0.05, 0.06, 0.07)))};
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  const ContactMaterial m = material();
  int tried = 0;
  for (int i = 0; i < 3000 && tried < 500; ++i) {
    const ConvexShape &A = *shapes[random() % shapes.size()], &B = *shapes[random() % shapes.size()];
    const Pose X_AB = random_pairs::randomPose(random, 0.05);
    Contact c = contactOf(A, B, X_AB);
    if (c.volume.status != ContactVolume::Status::kOverlap) continue;
    ++tried;
    Contact turned = contactOf(B, A, X_AB.inverse());
    const Matrix3 P = c.volume.X_AP.R, Q = X_AB.R * turned.volume.X_AP.R;
    for (const PressureLaw law : {PressureLaw::kLinear, PressureLaw::kHuntCrossley}) {
      const Twist V{Vector3(normal(random), normal(random), normal(random)), Vector3(0, 0, 0.02 * normal(random))};
      const NormalPressure p = normalPressure(c.volume, c.workspace, V, law, m);
      const double taken = -(p.force - p.elastic_force) * V.linear.z() - torqueOf(p).dot(V.angular);
      EXPECT_GE(taken, -1e-12 * p.elastic_force) << A.name() << " " << B.name();
      if (p.clipped) continue;
      Matrix3 D;  // of (v_z, slope)
      D << p.damping.m0, p.damping.m1.transpose(), p.damping.m1, p.damping.m2;
      const Vector3 rate(-V.linear.z(), V.angular.y(), -V.angular.x()), force(p.force - p.elastic_force, p.first.x(), p.first.y());
      EXPECT_NEAR((D * rate - force).norm(), 0, 1e-12 * (1 + force.norm())) << A.name() << " " << B.name();
      // Seen from B: the same torque in the world, from the twist of A over B.
      const Twist W{Q.transpose() * P * -V.angular, Q.transpose() * P * -V.linear};
      const NormalPressure q = normalPressure(turned.volume, turned.workspace, W, law, m);
      if (q.clipped || (P.col(2) + Q.col(2)).norm() > 1e-6) continue;
      EXPECT_NEAR((P * torqueOf(p) + Q * torqueOf(q)).norm(), 0, 1e-6 * (p.force * p.radius + 1e-9)) << A.name() << " " << B.name();
    }
  }
  EXPECT_EQ(tried, 500);
}

}  // namespace rolling_test
}  // namespace haptic
