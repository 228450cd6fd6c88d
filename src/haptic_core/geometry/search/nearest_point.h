/// The point of a convex polyhedron that is nearest to a given one.
#pragma once
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/volume/cut_solid.h"

namespace haptic {

/// The point of a polyhedron nearest to a given one.
struct NearestPoint {
  Vector3 direction = Vector3::UnitZ();  ///< unit, from the given point to the nearest one; from inside: against the nearest face's normal
  double distance = 0;                   ///< [m]; 0 inside
  double depth = 0;                      ///< inside: to the nearest face's plane [m]; else 0
};

/// To `c` in the shape's frame. (in realtime) Exact: over the faces that look towards c, and their edges. Cost O(faces).
NearestPoint nearestPoint(const ConvexPolyhedron& shape, const Vector3& c) noexcept;
NearestPoint nearestPoint(const CutSolid& solid, double size, const Vector3& c) noexcept;  ///< `size` [m]: of its coordinates

}  // namespace haptic
