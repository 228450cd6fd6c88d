/// Hulls with fewer corners: inside the given one, nowhere farther than asked, the same bits each time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/hulls/mesh_to_convex.h"
#include "haptic_core/geometry/hulls/thinned_hull.h"

namespace haptic {
namespace thinned_hull_test {

constexpr double kRadius = 0.03;

/// Corners on rings of a ball: all are extreme.
std::vector<Vector3> onBall(int rings, int around) {
  std::vector<Vector3> points;
  for (int i = 0; i < rings; ++i) {
    const double t = M_PI * (i + 0.5) / rings;
    for (int j = 0; j < around; ++j) {
      const double a = 2 * M_PI * (j + 0.5 * (i % 2)) / around;
      points.push_back(kRadius * Vector3(std::sin(t) * std::cos(a), std::sin(t) * std::sin(a), std::cos(t)));
    }
  }
  return points;
}

double farthestOutside(const ConvexPolyhedron& inner, const std::vector<Vector3>& points) {
  double most = 0;
  for (const Vector3& p : points) {
    for (const auto& face : inner.faces()) most = std::max(most, face.normal.dot(p) - face.offset);
  }
  return most;
}

/// A cap of a ball that a plane facet leaves outside has the height δ = c²/2R for a radius c of the facet, so a hull within δ needs at
/// least the ball's area over that of such caps, R²·4π/(πc²) = 2R/δ facets; a triangle of corners on the ball covers less of a cap.
TEST(ThinnedHull, IsWithinTheToleranceWithAsManyCornersAsThatTakes) {
  const auto points = onBall(50, 100);
  const auto whole = std::make_shared<const ConvexPolyhedron>(ConvexPolyhedron::hull(points));
  ASSERT_GT(whole->vertexCount(), 4900);
  for (const double tolerance : {0.5e-3, 0.2e-3}) {
    double distance = -1;
    const auto thin = thinnedHull(whole, tolerance, "ball", distance);
    const double outside = farthestOutside(*thin, points), facets = 2 * kRadius / tolerance;
    EXPECT_LE(outside, tolerance);
    EXPECT_NEAR(distance, outside, 1e-12 * kRadius);
    EXPECT_GE(static_cast<double>(thin->faces().size()), facets);
    EXPECT_LE(thin->vertexCount(), 4 * facets);
    EXPECT_LE(farthestOutside(*whole, thin->vertices()), 1e-12 * kRadius);
    EXPECT_EQ(thinnedHull(whole, tolerance, "ball", distance)->vertices(), thin->vertices());
  }
}

TEST(ThinnedHull, FewCornersStayAndKeptOnesAreIn) {
  double distance = -1;
  const auto few = std::make_shared<const ConvexPolyhedron>(ConvexPolyhedron::hull(onBall(6, 10)));
  EXPECT_EQ(thinnedHull(few, 1, "few", distance), few);
  EXPECT_EQ(distance, 0);
  const auto whole = std::make_shared<const ConvexPolyhedron>(ConvexPolyhedron::hull(onBall(40, 60)));
  const auto above = [](const Vector3& p) { return p.z() > 0.9 * kRadius; };
  const auto thin = thinnedHull(whole, 1e-3, "ball", distance, above);
  const auto count = [&](const ConvexPolyhedron& hull) { return std::count_if(hull.vertices().begin(), hull.vertices().end(), above); };
  EXPECT_EQ(count(*thin), count(*whole));
  EXPECT_LT(thin->vertexCount(), whole->vertexCount() / 2);
}

/// A mesh of a ball says how far its hull is from it.
TEST(ThinnedHull, AMeshSaysTheDistance) {
  const auto whole = ConvexPolyhedron::hull(onBall(60, 80));
  ConvexReport report;
  const auto pieces = convexPieces(whole.triangles(), ConvexSettings{}, report);
  ASSERT_EQ(pieces.size(), 1u);
  const double outside = farthestOutside(*pieces[0], whole.vertices()), asked = std::max(0.01 * report.size, 0.5e-3);
  EXPECT_LE(pieces[0]->vertexCount(), 4 * 2 * kRadius / (kThinnedShare * asked));  // as above
  EXPECT_LE(outside, kThinnedShare * asked);
  EXPECT_GE(report.hull_distance, outside - 1e-12 * kRadius);
  EXPECT_LE(report.hull_distance, asked);
}

}  // namespace thinned_hull_test
}  // namespace haptic
