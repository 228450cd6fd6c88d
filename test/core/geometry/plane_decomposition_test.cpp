/// Convex pieces of concave meshes: they cover the solid and, for shapes made of boxes, nothing else.
#include "haptic_core/geometry/hulls/plane_decomposition.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/hulls/mesh_to_convex.h"
#include "haptic_core/geometry/shapes/shapes.h"

namespace haptic {
namespace plane_decomposition_test {

/// A prism of height `height` over a polygon (counter-clockwise), its caps cut into fans from `centres`.
TriangleMesh prism(const std::vector<Vector2>& outline, const std::vector<std::array<int, 3>>& cap,
                   double height) {
  TriangleMesh mesh;
  const int n = static_cast<int>(outline.size());
  for (double z : {0.0, height}) {
    for (const Vector2& p : outline) mesh.vertices.emplace_back(p.x(), p.y(), z);
  }
  for (const auto& t : cap) {
    mesh.triangles.push_back({t[0], t[2], t[1]});
    mesh.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  }
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.triangles.push_back({i, j, j + n});
    mesh.triangles.push_back({i, j + n, i + n});
  }
  return mesh;
}

TriangleMesh lShape() {
  return prism({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},
               {{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 4}}, {{0, 4, 5}}}, 0.5);
}

TriangleMesh uShape() {
  return prism({{0, 0}, {3, 0}, {3, 2}, {2, 2}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},
               {{{0, 5, 7}}, {{5, 6, 7}}, {{0, 1, 4}}, {{0, 4, 5}}, {{1, 2, 4}}, {{2, 3, 4}}}, 1);
}

TriangleMesh turned(TriangleMesh mesh) {
  const Matrix3 R = rotationFromVector(Vector3(0.4, -1.1, 0.7)).toRotationMatrix();
  for (Vector3& v : mesh.vertices) v = R * v + Vector3(0.3, -2, 5);
  return mesh;
}

double sum(const std::vector<std::shared_ptr<const ConvexPolyhedron>>& pieces) {
  double volume = 0;
  for (const auto& piece : pieces) volume += piece->volume();
  return volume;
}

bool covered(const std::vector<std::shared_ptr<const ConvexPolyhedron>>& pieces, const Vector3& p,
             double within) {
  for (const auto& piece : pieces) {
    bool inside = true;
    for (const auto& face : piece->faces()) inside = inside && face.normal.dot(p) <= face.offset + within;
    if (inside) return true;
  }
  return false;
}

/// Shapes of boxes can be cut exactly: the pieces' volumes add up to the mesh's, in any pose.
TEST(PlaneDecomposition, ShapesOfBoxesAreCutExactly) {
  for (const TriangleMesh& mesh : {lShape(), uShape(), turned(lShape()), turned(uShape())}) {
    ASSERT_LT(firstOpenEdge(mesh)[0], 0);
    DecompositionReport report;
    const auto pieces = cutIntoConvexPieces(mesh, {}, "shape", report);
    const double volume = massProperties(mesh, 1).volume;
    // Cuts within 1e-7 of the size of a vertex pass through it: as much volume may be lost or shared.
    EXPECT_NEAR(sum(pieces), volume, 1e-5 * volume);
    EXPECT_LE(pieces.size(), 3u);
    EXPECT_GE(pieces.size(), 2u);
    EXPECT_LT(report.distance, 1e-3);
  }
}

/// Every point of the solid lies in a piece, also when the number of pieces ends the cutting.
TEST(PlaneDecomposition, CoversTheSolid) {
  const TriangleMesh mesh = uShape();
  for (int max_pieces : {1, 2, 3, 8}) {
    DecompositionSettings settings;
    settings.max_pieces = max_pieces;
    DecompositionReport report;
    const auto pieces = cutIntoConvexPieces(mesh, settings, "u", report);
    EXPECT_LE(static_cast<int>(pieces.size()), max_pieces);
    EXPECT_EQ(report.distance > 0.4, max_pieces < 3);  // its bottom is half the height from either cap
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 2000; ++i) {
      const Vector3 p(3 * unit(random), 2 * unit(random), unit(random));
      const bool in_hollow = p.x() > 1 && p.x() < 2 && p.y() > 1;
      if (!in_hollow) EXPECT_TRUE(covered(pieces, p, 1e-6)) << p.transpose();
      if (in_hollow && max_pieces >= 3) EXPECT_FALSE(covered(pieces, p, -1e-6)) << p.transpose();
    }
  }
}

TEST(PlaneDecomposition, AConvexMeshStaysWhole) {
  DecompositionReport report;
  EXPECT_EQ(cutIntoConvexPieces(makeSphere(1, 2).triangles(), {}, "sphere", report).size(), 1u);
  EXPECT_LT(report.distance, 1e-12);
}

TEST(MeshToConvex, HullsDecomposesOrRefuses) {
  ConvexSettings settings;
  ConvexReport report;
  EXPECT_EQ(convexPieces(makeBox(Vector3(1, 2, 3)).triangles(), settings, report).size(), 1u);
  EXPECT_FALSE(report.decomposed);
  EXPECT_GE(convexPieces(lShape(), settings, report).size(), 2u);
  EXPECT_TRUE(report.decomposed);
  settings.decompose = false;
  EXPECT_THROW(convexPieces(lShape(), settings, report), SetupError);
  // A dent of 0.3 mm in a cube of 0.1 m is within the tolerance of 1 % (a printed distance, not a cut).
  TriangleMesh dented = makeBox(Vector3(0.1, 0.1, 0.1)).triangles();
  const auto corner = dented.triangles[0];
  dented.vertices.push_back(
      (dented.vertices[corner[0]] + dented.vertices[corner[1]] + dented.vertices[corner[2]]) / 3 *
      (1 - 0.006));
  const int dent = static_cast<int>(dented.vertices.size()) - 1;
  dented.triangles[0] = {corner[0], corner[1], dent};
  dented.triangles.push_back({corner[1], corner[2], dent});
  dented.triangles.push_back({corner[2], corner[0], dent});
  EXPECT_EQ(convexPieces(dented, settings, report).size(), 1u);
  EXPECT_NEAR(report.hull_distance, 0.006 * 0.05, 3e-5);  // resolved to 2 % of the tolerance
}

}  // namespace plane_decomposition_test
}  // namespace haptic
