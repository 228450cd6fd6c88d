#include "haptic_core/geometry/nearest_point.h"

#include <Eigen/Geometry>
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

}  // namespace

NearestPoint nearestPoint(const ConvexPolyhedron& shape, const Vector3& c) noexcept {
  NearestPoint nearest;
  double highest = -std::numeric_limits<double>::infinity();
  const ConvexPolyhedron::Face* top = nullptr;
  // The nearest corner first: few faces are nearer.
  double square = std::numeric_limits<double>::infinity();
  Vector3 to = Vector3::Zero();
  for (const Vector3& corner : shape.vertices()) {
    const Vector3 way = corner - c;
    if (way.squaredNorm() >= square) continue;
    square = way.squaredNorm();
    to = way;
  }
  double least = std::sqrt(square);
  for (const ConvexPolyhedron::Face& face : shape.faces()) {
    const double over = face.normal.dot(c) - face.offset;
    if (over > highest) {
      highest = over;
      top = &face;
    }
    if (!(over > 0) || over >= least) continue;
    bool above = true;
    Vector3 p = shape.vertices()[shape.loopVertex(face.first)] - c;
    for (int i = 0; i < face.count; ++i) {
      const Vector3 q = shape.vertices()[shape.loopVertex(face.first + (i + 1 < face.count ? i + 1 : 0))] - c;
      if (face.normal.dot((q - p).cross(p)) > 0) {
        // The foot of c lies beyond this edge: what is nearest lies on one such edge.
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
  if (!(highest > 0) || !(least > kOnPlane * shape.boundingRadius())) {
    nearest.direction = -top->normal;
    nearest.depth = std::max(0.0, -highest);
    return nearest;
  }
  nearest.distance = least;
  nearest.direction = to / least;
  // A foot in the face has its normal exactly, which the caller compares.
  if (least == highest) nearest.direction = -top->normal;
  return nearest;
}

}  // namespace haptic
