#include "point_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic::comparators {
namespace {

/// Faces flatter than this against n do not bound the thickness along it.
constexpr double kAlongFace = 1e-9;

/// Way from x along `n` to the nearest face of `owner` that looks that way.
double wayOut(const ContactWorkspace& workspace, Owner owner, const Vector3& n, const Vector3& x) {
  double way = std::numeric_limits<double>::infinity();
  for (const ContactFace& face : workspace.faces()) {
    const double rise = face.normal.dot(n);
    if (face.owner == owner && rise > kAlongFace) way = std::min(way, (face.offset - face.normal.dot(x)) / rise);
  }
  return way;
}

}  // namespace

void pointContact(const ConvexShape& A, const ConvexShape& B, ContactWorkspace& workspace, ContactVolume& contact) noexcept {
  const double area = std::min(A.surface(), B.surface()) / 6;  // ground without end has an infinite one
  const Vector3 n = contact.normal();
  const LoadedVector<Vector3>& vertices = workspace.vertices();
  Vector3 point = contact.X_AP.p;
  double depth = contact.depth;
  if (!vertices.empty()) {
    const auto lower = [&](const Vector3& x, const Vector3& y) { return n.dot(x) < n.dot(y); };
    const Vector3 lowest = *std::min_element(vertices.begin(), vertices.end(), lower);
    const Vector3 highest = *std::max_element(vertices.begin(), vertices.end(), lower);
    // B's lowest point below A's surface, or A's highest above B's.
    const double below = wayOut(workspace, Owner::kA, n, lowest),
                 above = wayOut(workspace, Owner::kB, -n, highest);
    depth = std::clamp(below >= above ? below : above, 0.0, contact.depth);
    point = below >= above ? Vector3(lowest + 0.5 * depth * n) : Vector3(highest - 0.5 * depth * n);
  }
  contact.X_AP.p = point;
  contact.depth = depth;
  contact.volume = area * depth;
  contact.area_vector_A = area * n;
  contact.A0 = area;
  contact.A1.setZero();
  contact.A2.setZero();
  contact.V2.setZero();
  workspace.clear();
}

}  // namespace haptic::comparators
