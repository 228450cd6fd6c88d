#include "haptic_core/geometry/hulls/mesh_to_convex.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/hulls/plane_decomposition.h"
#include "haptic_core/geometry/hulls/thinned_hull.h"

namespace haptic {
namespace {

/// Distance of a point inside the hull from the hull's surface, or a number ≤ `found`.
double depthBelow(const ConvexPolyhedron& hull, const Vector3& p, double found) {
  double depth = std::numeric_limits<double>::infinity();
  for (const auto& face : hull.faces()) {
    depth = std::min(depth, face.offset - face.normal.dot(p));
    if (depth <= found) break;
  }
  return depth;
}

/// No point of the triangle lies deeper: below the one face whose plane is nearest to all three corners. Zero
/// for a triangle in a face of the hull, so that those are never split. Or a number ≤ `enough`.
double deepestPossible(const ConvexPolyhedron& hull, const Vector3& a, const Vector3& b, const Vector3& c, double enough) {
  double bound = std::numeric_limits<double>::infinity();
  for (const auto& face : hull.faces()) {
    const double lowest = std::min({face.normal.dot(a), face.normal.dot(b), face.normal.dot(c)});
    bound = std::min(bound, face.offset - lowest);
    if (bound <= enough) break;
  }
  return bound;
}

/// Largest depth of a triangle below the hull's surface, to `resolution`. A reflex edge can have both ends on
/// the hull, so the vertices alone would not do. The bound of deepestPossible leaves few triangles to be
/// split.
double deepest(const ConvexPolyhedron& hull, const Vector3& a, const Vector3& b, const Vector3& c,
               double found, double resolution) {
  found = std::max(found, depthBelow(hull, (a + b + c) / 3, found));
  if (deepestPossible(hull, a, b, c, found + resolution) <= found + resolution) return found;
  // Split across the longest side: slivers get shorter, too.
  const double ab = (a - b).squaredNorm(), bc = (b - c).squaredNorm(), ca = (c - a).squaredNorm();
  const Vector3& p = ab >= bc && ab >= ca ? a : bc >= ca ? b : c;
  const Vector3& q = ab >= bc && ab >= ca ? b : bc >= ca ? c : a;
  const Vector3& r = ab >= bc && ab >= ca ? c : bc >= ca ? a : b;
  const Vector3 half = 0.5 * (p + q);
  found = deepest(hull, p, half, r, found, resolution);
  return deepest(hull, half, q, r, found, resolution);
}

std::vector<std::shared_ptr<const ConvexPolyhedron>> decomposed(const TriangleMesh& mesh,
                                                                const ConvexSettings& settings,
                                                                double tolerance, ConvexReport& report) {
  DecompositionSettings cutting;
  cutting.tolerance = tolerance;
  cutting.max_pieces = settings.max_pieces;
  cutting.progress = settings.progress;
  DecompositionReport cut;
  const auto pieces = cutIntoConvexPieces(mesh, cutting, settings.name, cut);
  report.decomposed = true;
  report.hull_distance = cut.distance;
  report.unfinished = cut.unfinished;
  report.pieces = static_cast<int>(pieces.size());
  for (const auto& piece : pieces) report.pieces_volume += piece->volume();
  return pieces;
}

}  // namespace

std::vector<std::shared_ptr<const ConvexPolyhedron>> convexPieces(const TriangleMesh& mesh,
                                                                  const ConvexSettings& settings,
                                                                  ConvexReport& report) {
  if (mesh.triangles.empty())
    throw SetupError(settings.name, "the mesh has no triangles", "export it with faces");
  auto hull = std::make_shared<const ConvexPolyhedron>(ConvexPolyhedron::hull(mesh.vertices, settings.name));
  report = ConvexReport{};
  report.size = (hull->aabb().upper - hull->aabb().lower).maxCoeff();
  report.mesh_volume = firstOpenEdge(mesh)[0] < 0 ? massProperties(mesh, 1.0).volume : std::nan("");
  const double tolerance = std::max(settings.relative_tolerance * report.size, settings.absolute_tolerance);
  double inward = 0;
  hull = thinnedHull(hull, kThinnedShare * tolerance, settings.name, inward);
  for (const auto& t : mesh.triangles) {
    if (settings.decompose && report.hull_distance > tolerance) break;  // the pieces have a distance of their own
    report.hull_distance = deepest(*hull, mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]],
                                   report.hull_distance, 0.02 * tolerance);
  }
  if (report.hull_distance > tolerance) {
    if (!settings.decompose)
      throw SetupError(
          settings.name,
          "the mesh is concave: " + std::to_string(1e3 * report.hull_distance) + " mm below its hull",
          "split it into convex meshes");
    return decomposed(mesh, settings, tolerance, report);
  }
  report.pieces = 1;
  report.hull_distance = std::max(report.hull_distance, inward);
  report.pieces_volume = hull->volume();
  return {hull};
}

}  // namespace haptic
