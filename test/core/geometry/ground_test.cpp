// Ground under a surface: its pieces fill the solid, and together they meet a body as one plane does.
#include "haptic_core/geometry/hulls/ground.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "../../scenes/ground.h"
#include "haptic_core/base/error.h"
#include "haptic_core/geometry/pairs/internal_faces.h"
#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/cone.h"
#include "haptic_core/geometry/shapes/ellipsoid.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "random_pairs.h"

namespace haptic {
namespace ground_test {

using namespace scenes;
using random_pairs::randomTurn;
using random_pairs::stone;
constexpr double kEps = std::numeric_limits<double>::epsilon();

double volumeOf(const GroundShapes& pieces) {
  double sum = 0;
  for (const auto& piece : pieces) sum += piece->volume();
  return sum;
}

/// Prism by prism under the triangles: ∫ (z − base) over each.
double volumeUnder(const TriangleMesh& mesh, double base) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Vector3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    sum += 0.5 * (b - a).cross(c - a).z() * ((a.z() + b.z() + c.z()) / 3 - base);
  }
  return sum;
}

double hills(double x, double y) { return 0.1 * elementary::sin(3 * x) * elementary::cos(2 * y) + 0.05 * x; }

TEST(Ground, PiecesFillWhatLiesUnderTheSurface) {
  const TriangleMesh mesh = surfaceOf(heightGrid(12, 2, hills), "hills");
  GroundReport report;
  const GroundShapes pieces = groundPieces(mesh, 0.3, "hills", report);
  EXPECT_EQ(report.triangles, 288);
  EXPECT_EQ(report.pieces, static_cast<int>(pieces.size()));
  EXPECT_GT(report.pieces, 200);
  EXPECT_NEAR(report.base, report.lowest - 0.3, 1e-15);
  EXPECT_NEAR(volumeOf(pieces), volumeUnder(mesh, report.base), 1e-12);
  // Nothing lies in two of them: points at random are in one piece below the surface, in none above.
  std::mt19937 random(5);
  const auto number = [&] { return 1.98 * random() / random.max() - 0.99; };
  for (int i = 0; i < 2000; ++i) {
    const Vector3 p(number(), number(), 0.4 * number());
    int inside = 0;
    for (const auto& piece : pieces) {
      bool in = true;
      for (const ConvexPolyhedron::Face& face : piece->polyhedron()->faces()) in = in && face.normal.dot(p) <= face.offset;
      inside += in;
    }
    ASSERT_LE(inside, 1);
    if (p.z() < report.base || p.z() > report.highest) { ASSERT_EQ(inside, 0); }
    if (p.z() > report.base && p.z() < report.lowest) { ASSERT_EQ(inside, 1); }
  }
}

/// A level field, or one that tilts, is one solid whatever its grid; plateaus are few.
TEST(Ground, JoinsTrianglesOfOnePlane) {
  for (const double slope : {0.0, 0.1, 1.0 / 3}) {
    for (const int cells : {1, 2, 7, 50}) {
      const GroundShapes pieces = groundOf(heightGrid(cells, 3, [&](double x, double y) { return slope * (x + 0.4 * y); }));
      ASSERT_EQ(pieces.size(), 1u) << slope << " " << cells;
      EXPECT_EQ(pieces[0]->faceCount(), 6);
    }
  }
  // Two planes with a fold: two pieces. Steps, whose risers are upright triangles: one piece a tread.
  EXPECT_EQ(groundOf(heightGrid(10, 2, [](double x, double) { return std::abs(x); })).size(), 2u);
  TriangleMesh steps;
  for (int i = 0; i < 3; ++i) {
    const int first = static_cast<int>(steps.vertices.size());
    for (const double x : {0.0, 1.0}) {
      for (const double y : {0.0, 1.0}) steps.vertices.emplace_back(i + x, y, 0.2 * i);
    }
    steps.triangles.push_back({first, first + 2, first + 3});
    steps.triangles.push_back({first, first + 3, first + 1});
    if (i > 0) steps.triangles.push_back({first - 2, first, first + 1});
  }
  GroundReport report;
  const GroundShapes treads = groundPieces(steps, 0.1, "steps", report);
  ASSERT_EQ(treads.size(), 3u);
  EXPECT_NEAR(volumeOf(treads), 0.1 + 0.3 + 0.5, 1e-12);
  // A level part that is not convex: fewer pieces than triangles, none lost.
  const HeightGrid rough = plateau(20, 2);
  const GroundShapes some = groundOf(rough);
  EXPECT_LT(some.size(), 650u);
  EXPECT_NEAR(volumeOf(some), volumeUnder(surfaceOf(rough, "rough"), some[0]->aabb().lower.z()), 1e-12);
}

/// Sum over pieces of V, its moment and its area vectors without inner walls.
struct Sum {
  double volume = 0, worst_tilt = 0;
  Vector3 moment = Vector3::Zero();
  int pieces = 0;
};

Sum sumOver(const GroundShapes& ground, const std::vector<InnerFaces>& inner, const ConvexShape& body, const Pose& X, const Vector3& n) {
  Sum sum;
  ContactWorkspace workspace;
  for (std::size_t i = 0; i < ground.size(); ++i) {
    workspace.reserve(*ground[i], body);
    PairCache cache;
    ContactVolume volume;
    ContactRequest request;
    request.inner.a = inner[i].covers.empty() ? nullptr : &inner[i];
    contactVolume(*ground[i], body, X, cache, workspace, volume, request);
    if (volume.status != ContactVolume::Status::kOverlap) continue;
    ++sum.pieces;
    sum.volume += volume.volume;
    sum.moment += volume.volume * volume.X_AP.p;
    // A sliver's normal is as exact as its area.
    sum.worst_tilt = std::max(sum.worst_tilt, (volume.normal() - n).norm() * volume.A0);
  }
  return sum;
}

std::vector<InnerFaces> wallsOf(const GroundShapes& ground) {
  std::vector<PlacedPiece> placed;
  for (const auto& piece : ground) placed.push_back({piece.get(), Pose()});
  return internalFaces(placed).inner;
}

/// Each kind of body, on prisms under each triangle of level ground: what they have in common with it is what the plane has, and all
/// push along its normal.
TEST(Ground, MeetsEveryShapeAsThePlaneDoes) {
  const GroundShapes prisms = flatPrisms(8, 1.6, 1);
  const std::vector<InnerFaces> inner = wallsOf(prisms);
  const HalfSpace plane;
  const std::vector<std::shared_ptr<const ConvexShape>> bodies{
      std::make_shared<Ball>(0.15), box(Vector3(0.2, 0.3, 0.1)), std::make_shared<ConvexPolyhedron>(stone(30, 0.2, 3)),
      std::make_shared<Rod>(0.1, 0.3, Rod::Ends::kFlat), std::make_shared<Rod>(0.1, 0.3, Rod::Ends::kRound),
      std::make_shared<Ellipsoid>(Vector3(0.2, 0.15, 0.1)), std::make_shared<Cone>(0.15, 0.05, 0.3)};
  std::mt19937 random(11);
  int spread = 0;
  for (const auto& body : bodies) {
    for (int i = 0; i < 12; ++i) {
      const double depth = body->leastWidth() * std::pow(10.0, -1 - i % 3);
      const Matrix3 R = randomTurn(random);
      const double low = supportHeight(*body, Pose(R, Vector3::Zero()), -Vector3::UnitZ());
      const Pose X(R, Vector3(0.01 * i, -0.02 * i + 0.05, low - depth));
      ContactWorkspace workspace;
      workspace.reserve(plane, *body);
      PairCache cache;
      ContactVolume whole;
      contactVolume(plane, *body, X, cache, workspace, whole);
      ASSERT_EQ(whole.status, ContactVolume::Status::kOverlap);
      const Sum sum = sumOver(prisms, inner, *body, X, Vector3::UnitZ());
      spread += sum.pieces > 2;
      // Roundings of the corners' coordinates over the depth, on each piece.
      const double rounding = 200 * kEps / depth + 1e-11;
      EXPECT_NEAR(sum.volume, whole.volume, rounding * whole.volume) << body->name() << " " << i;
      EXPECT_NEAR((sum.moment / sum.volume - whole.X_AP.p).norm(), 0, rounding) << body->name() << " " << i;
      EXPECT_LT(sum.worst_tilt, 1e-9 * whole.A0) << body->name() << " " << i;
    }
  }
  EXPECT_GT(spread, 20);
}

/// Round shapes whose axis stands exactly over a wall, and whose circle just misses or just holds the wall's end: both halves of the
/// wall's line run through the centre, where one rounding or a zero's sign tells left from right.
TEST(Ground, AWallThroughTheAxisIsNotFelt) {
  const GroundShapes prisms = flatPrisms(4, 1.2, 1);  // corners 0.3 m apart
  const std::vector<InnerFaces> inner = wallsOf(prisms);
  const double R = 0.05, depth = 1e-3, disc = std::sqrt(depth * (2 * R - depth));
  const std::vector<std::pair<std::shared_ptr<const ConvexShape>, double>> bodies{
      {std::make_shared<Ball>(R), disc}, {std::make_shared<Rod>(R, 0.02, Rod::Ends::kFlat), R}};
  for (const auto& [body, radius] : bodies) {
    const double height = (radius == R ? 0.01 : R) - depth;
    const double area = M_PI * radius * radius, expected = radius == R ? area * depth : M_PI * depth * depth * (R - depth / 3);
    for (const Vector3& along : {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(std::sqrt(0.5), std::sqrt(0.5), 0)}) {
      for (const double sign : {-1.0, 1.0}) {
        for (const double beyond : {-1e-3, -1e-5, -1e-8, 0.0, 1e-12, 1e-8, 1e-5, 1e-4, 1e-3}) {
          const Pose X(Vector3(sign * (radius + beyond) * along + Vector3(0, 0, height)));
          const Sum sum = sumOver(prisms, inner, *body, X, Vector3::UnitZ());
          EXPECT_NEAR(sum.volume, expected, 1e-10 * expected) << body->name() << " " << along.transpose() << " " << sign * beyond;
          EXPECT_LT(sum.worst_tilt, 1e-9 * area);
        }
      }
    }
  }
}

std::string refusal(const TriangleMesh& mesh, double thickness) {
  GroundReport report;
  try {
    groundPieces(mesh, thickness, "mesh", report);
  } catch (const SetupError& error) {
    return error.what();
  }
  return "";
}

TEST(Ground, RefusesWhatIsNoGround) {
  const TriangleMesh good{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.1}}, {{0, 1, 2}, {1, 3, 2}}};
  EXPECT_EQ(refusal(good, 0.1), "");
  EXPECT_NE(refusal(good, 0).find("thickness"), std::string::npos);
  EXPECT_NE(refusal(good, std::nan("")).find("thickness"), std::string::npos);
  TriangleMesh bad = good;
  bad.triangles[1] = {1, 2, 3};
  EXPECT_NE(refusal(bad, 0.1).find("triangle 1 looks down"), std::string::npos);
  bad = good;
  bad.vertices[3].z() = std::nan("");
  EXPECT_NE(refusal(bad, 0.1).find("triangle 1 has a corner that is not finite"), std::string::npos);
  bad = good;
  bad.vertices.insert(bad.vertices.end(), {{0.2, 0.2, 0.5}, {0.8, 0.2, 0.5}, {0.2, 0.8, 0.5}});
  bad.triangles.push_back({4, 5, 6});
  EXPECT_NE(refusal(bad, 0.1).find("lie over one another"), std::string::npos);
  EXPECT_NE(refusal({{{0, 0, 0}, {1, 0, 0}, {1, 0, 1}}, {{0, 1, 2}}}, 0.1).find("no triangle looks up"), std::string::npos);
  HeightGrid grid{1, 2, Vector2(1, 1), {0, 0}};
  EXPECT_THROW(surfaceOf(grid, "grid"), SetupError);
  grid = {2, 2, Vector2(1, 0), {0, 0, 0, 0}};
  EXPECT_THROW(surfaceOf(grid, "grid"), SetupError);
  grid = {2, 2, Vector2(1, 1), {0, 0, 0, std::nan("")}};
  EXPECT_THROW(surfaceOf(grid, "grid"), SetupError);
}

}  // namespace ground_test
}  // namespace haptic
