#include "haptic_core/geometry/search/nearest_point.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

/// Closer than this to an edge or a corner, relative to the shape, its direction is rounding: the nearest
/// face's normal is taken.
constexpr double kOnPlane = 1e-14;

/// Vector from the origin to the nearest point of p … q.
Vector3 toSegment(const Vector3& p, const Vector3& q) {
  const Vector3 d = q - p;
  const double t = -p.dot(d) / d.squaredNorm();
  return t <= 0 ? p : t >= 1 ? q : Vector3(p + t * d);
}

template <class Solid, class Points>
NearestPoint nearestOf(const Solid& shape, const Points& corners, double size, const Vector3& c) {
  NearestPoint nearest;
  double highest = -std::numeric_limits<double>::infinity();
  Vector3 top = Vector3::UnitZ();
  // The nearest corner first: few faces are nearer.
  double square = std::numeric_limits<double>::infinity();
  Vector3 to = Vector3::Zero();
  for (const Vector3& corner : corners) {
    const Vector3 way = corner - c;
    if (way.squaredNorm() >= square) continue;
    square = way.squaredNorm();
    to = way;
  }
  double least = std::sqrt(square);
  for (int f = 0; f < shape.faceCount(); ++f) {
    const auto& face = shape.plane(f);
    const double over = face.normal.dot(c) - face.offset;
    if (over > highest) {
      highest = over;
      top = face.normal;
    }
    if (!(over > 0) || over >= least) continue;
    bool above = true;
    Vector3 p = shape.corner(f, 0) - c;
    for (int i = 0; i < shape.cornerCount(f); ++i) {
      const Vector3 q = shape.corner(f, i + 1) - c;
      if (face.normal.dot((q - p).cross(p)) > 0) {
        // The foot of c lies beyond this edge: the nearest point lies on one such edge.
        above = false;
        const Vector3 way = toSegment(p, q);
        const double distance = way.norm();
        if (distance < least) {
          least = distance;
          to = way;
        }
      }
      p = q;
    }
    if (above) {
      least = over;
      to = -over * face.normal;
    }
  }
  if (!(highest > 0) || !(least > kOnPlane * size)) {
    nearest.direction = -top;
    nearest.depth = std::max(0.0, -highest);
    return nearest;
  }
  nearest.distance = least;
  nearest.direction = to / least;
  // A foot in the face has its normal exactly, which the caller compares.
  if (least == highest) nearest.direction = -top;
  return nearest;
}

}  // namespace

NearestPoint nearestPoint(const ConvexPolyhedron& shape, const Vector3& c) noexcept {
  return nearestOf(shape, shape.vertices(), shape.boundingRadius(), c);
}

NearestPoint nearestPoint(const CutSolid& solid, double size, const Vector3& c) noexcept {
  return nearestOf(solid, solid.points, size, c);
}

}  // namespace haptic
