#include "haptic_core/geometry/hulls/thinned_hull.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

/// Corners of the hull that go into the thinned one first: those of the box, its edges and its diagonals.
void takeExtremes(const std::vector<Vector3>& corners, std::vector<bool>& taken) {
  for (int i = 0; i < 27; ++i) {
    const Vector3 along(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (along.isZero()) continue;
    std::size_t farthest = 0;
    for (std::size_t c = 1; c < corners.size(); ++c) {
      if (along.dot(corners[c]) > along.dot(corners[farthest])) farthest = c;
    }
    taken[farthest] = true;
  }
}

/// Takes the corner farthest outside of each face of `inner`, where it is beyond the tolerance; the largest distance of one that is left.
double takeFarthest(const std::vector<Vector3>& corners, const ConvexPolyhedron& inner, double tolerance, std::vector<bool>& taken) {
  std::vector<double> farthest(inner.faces().size(), tolerance);
  std::vector<std::size_t> corner(inner.faces().size(), corners.size());
  double left = 0;
  for (std::size_t c = 0; c < corners.size(); ++c) {
    if (taken[c]) continue;
    double out = 0;
    std::size_t face = 0;
    for (std::size_t f = 0; f < inner.faces().size(); ++f) {
      const double above = inner.faces()[f].normal.dot(corners[c]) - inner.faces()[f].offset;
      if (above > out) out = above, face = f;
    }
    left = std::max(left, out);
    if (out > farthest[face]) farthest[face] = out, corner[face] = c;
  }
  for (const std::size_t c : corner) {
    if (c < corners.size()) taken[c] = true;
  }
  return left;
}

}  // namespace

std::shared_ptr<const ConvexPolyhedron> thinnedHull(std::shared_ptr<const ConvexPolyhedron> hull, double tolerance, const std::string& name,
                                                    double& distance, const std::function<bool(const Vector3&)>& kept) {
  distance = 0;
  if (hull->vertexCount() <= kFewCorners || !(tolerance > 0)) return hull;
  const std::vector<Vector3>& corners = hull->vertices();
  std::vector<bool> taken(corners.size(), false);
  for (std::size_t c = 0; kept && c < corners.size(); ++c) taken[c] = kept(corners[c]);
  takeExtremes(corners, taken);
  try {
    for (;;) {  // each pass takes a corner, or is the last
      std::vector<Vector3> some;
      for (std::size_t c = 0; c < corners.size(); ++c) {
        if (taken[c]) some.push_back(corners[c]);
      }
      if (2 * some.size() > corners.size() + kFewCorners) break;  // too little is saved
      auto inner = std::make_shared<const ConvexPolyhedron>(ConvexPolyhedron::hull(some, name));
      distance = takeFarthest(corners, *inner, tolerance, taken);
      if (distance <= tolerance) return inner;
    }
  } catch (const SetupError&) {  // corners that doubles hardly tell from a plane's
  }
  distance = 0;
  return hull;
}

}  // namespace haptic
