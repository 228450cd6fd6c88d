#include "haptic_core/geometry/search/gjk.h"

#include <gtest/gtest.h>

#include <random>

#include "ccd_oracle.h"
#include "exact_volume.h"
#include "haptic_core/geometry/shapes/shapes.h"

namespace haptic {
namespace gjk_test {

struct Gjk : testing::Test {
  Vector3 direction() { return Vector3(normal(random), normal(random), normal(random)).normalized(); }
  Matrix3 rotation() {
    return Quaternion(normal(random), normal(random), normal(random), normal(random))
        .normalized()
        .toRotationMatrix();
  }
  std::mt19937 random{6};
  std::normal_distribution<double> normal;
};

bool inside(const ConvexPolyhedron& shape, const Vector3& p, double tolerance) {
  for (const auto& f : shape.faces())
    if (f.normal.dot(p) > f.offset + tolerance) return false;
  return true;
}

/// Euclid on paper: face to face, edge to crossing edge, corner to corner.
TEST_F(Gjk, DistancesOfBoxesAreTheClosedForms) {
  const ConvexPolyhedron box = makeBox(Vector3(0.1, 0.1, 0.1));
  const Matrix3 quarter = Eigen::AngleAxisd(M_PI / 4, Vector3::UnitX()).toRotationMatrix();
  const Matrix3 crossed = Eigen::AngleAxisd(M_PI / 4, Vector3::UnitY()).toRotationMatrix();
  struct {
    Pose X;
    double distance;
  } const cases[] = {
      {Pose(Vector3(0.02, -0.01, 0.13)), 0.03},
      {Pose(Vector3(0.13, 0.14, 0.0)), 0.05},
      {Pose(Vector3(0.12, 0.13, 0.16)), std::sqrt(0.02 * 0.02 + 0.03 * 0.03 + 0.06 * 0.06)},
      {Pose(quarter, Vector3(0, 0, 0.15)), 0.1 - 0.05 * std::sqrt(2.0)},
      // Both on an edge, A's along x and B's along y, 0.2 m between the centres.
      {Pose(quarter.transpose() * crossed, quarter.transpose() * Vector3(0, 0, 0.2)),
       0.2 - 0.1 * std::sqrt(2.0)},
  };
  for (const auto& c : cases) {
    ClosestPoints near;
    closestPoints(box, box, c.X, Vector3::Zero(), near);
    ASSERT_TRUE(near.separated);
    EXPECT_NEAR(near.distance, c.distance, 1e-14);
  }
}

/// The closest points lie on both bodies, their line separates, and the gap along it is the distance: then no
/// pair of points can be closer.
TEST_F(Gjk, ProvesItsDistance) {
  std::vector<Vector3> points;
  for (int i = 0; i < 60; ++i) points.push_back(0.05 * direction());
  const std::vector<ConvexPolyhedron> shapes = {makeBox(Vector3(0.1, 0.08, 0.06)),
                                                ConvexPolyhedron::hull(points), makeCylinder(0.04, 0.1, 12)};
  int separated = 0;
  for (int i = 0; i < 3000; ++i) {
    const ConvexPolyhedron &a = shapes[i % 3], &b = shapes[i / 3 % 3];
    const Pose X(rotation(), std::uniform_real_distribution<double>(0.05, 0.2)(random) * direction());
    ClosestPoints near;
    closestPoints(a, b, X, i % 2 ? direction() : Vector3::Zero(), near);
    const double exact = static_cast<double>(oracle::PolygonVolume<long double>::volume(a, b, Pose(), X));
    EXPECT_EQ(near.separated, !(exact > 0));
    if (!near.separated) continue;
    ++separated;
    EXPECT_TRUE(inside(a, near.p_A, 1e-14));
    EXPECT_TRUE(inside(b, X.inverse() * near.p_B, 1e-14));
    EXPECT_NEAR((near.p_B - near.p_A).norm(), near.distance, 1e-15);
    int va = 0, vb = 0;
    // The line through the points is known to roundings of 0.2 m over the distance, and the bodies reach 0.1
    // m aside.
    const double tolerance = 1e-14 + 0.1 * 4e-17 / near.distance;
    EXPECT_NEAR(gapAlong(a, b, X, (near.p_B - near.p_A).normalized(), va, vb), near.distance, tolerance);
    EXPECT_GT(gapAlong(a, b, X, near.direction, va, vb), 0);
  }
  EXPECT_GT(separated, 1000);
}

/// Two implementations agree on every pair, but where the bodies touch to within what libccd resolves.
TEST_F(Gjk, AgreesWithLibccd) {
  std::vector<Vector3> points;
  for (int i = 0; i < 40; ++i) points.push_back(0.05 * direction());
  const std::vector<ConvexPolyhedron> shapes = {makeBox(Vector3(0.1, 0.08, 0.002)), ConvexPolyhedron::hull(points),
                                                makeCylinder(0.04, 0.1, 16), makeSphere(0.05, 1)};
  int separated = 0, overlapping = 0;
  for (int i = 0; i < 4000; ++i) {
    const ConvexPolyhedron &a = shapes[i % 4], &b = shapes[i / 4 % 4];
    const Pose X(rotation(), std::uniform_real_distribution<double>(0, 0.15)(random) * direction());
    ClosestPoints near;
    closestPoints(a, b, X, Vector3::Zero(), near);
    if (near.separated && near.distance < 1e-9) continue;
    EXPECT_EQ(near.separated, !oracle::ccdIntersects(a, b, X)) << "pair " << i << ", distance " << near.distance;
    ++(near.separated ? separated : overlapping);
  }
  EXPECT_GT(separated, 1000);
  EXPECT_GT(overlapping, 1000);
}

TEST_F(Gjk, GivesACommonPointOfBodiesThatIntersect) {
  const ConvexPolyhedron a = makeBox(Vector3(0.1, 0.1, 0.1)), b = makeSphere(0.05, 1);
  for (int i = 0; i < 300; ++i) {
    const Pose X(rotation(), 0.06 * direction());
    ClosestPoints near;
    closestPoints(a, b, X, Vector3::Zero(), near);
    if (near.separated) continue;
    EXPECT_TRUE(inside(a, near.p_A, 1e-12));
    EXPECT_TRUE(inside(b, X.inverse() * near.p_B, 1e-12));
  }
}

}  // namespace gjk_test
}  // namespace haptic
