/// Distance and a separating direction of any two convex shapes.
#pragma once
#include "haptic_core/geometry/convex_shape.h"
#include "haptic_core/geometry/gjk.h"

namespace haptic {

/// As for polyhedra (gjk.h), of the shapes' cores (convex_shape.h). With a cylinder `distance` is a lower bound that the
/// direction proves. Pairs of a ball with a ball or polyhedron are exact and need no search: O(faces) of the other shape. Where
/// a ball holds the other shape's nearest point the direction is the shortest way out of it. (in realtime)
void closestPoints(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, const Vector3& direction,
                   ClosestPoints& result) noexcept;

/// Extent of a shape in the frame A along `direction` (unit, in A) [m]: its highest point's height. X_AS: of the shape.
double supportHeight(const ConvexShape& shape, const Pose& X_AS, const Vector3& direction) noexcept;

}  // namespace haptic
