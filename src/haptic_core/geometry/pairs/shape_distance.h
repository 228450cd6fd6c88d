/// Distance and a separating direction of any two convex shapes.
#pragma once
#include "haptic_core/geometry/pairs/table.h"

namespace haptic {

/// As for polyhedra (gjk.h), of the shapes' cores (convex_shape.h). With a cylinder `distance` is a lower bound that the
/// direction proves. Pairs of a ball with a ball or polyhedron are exact and need no search: O(faces) of the other shape. Where
/// a ball holds the other shape's nearest point the direction is the shortest way out of it. (in realtime)
void closestPoints(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, const Vector3& direction,
                   ClosestPoints& result) noexcept;

/// (in realtime) For the table of pairs (table.h): cores by search (gjk.h), the others in closed form or by the polyhedron's faces.
void polyhedraDistance(const ShapePair& pair, const Vector3& direction, ClosestPoints& result) noexcept;
void coresDistance(const ShapePair& pair, const Vector3& direction, ClosestPoints& result) noexcept;           ///< see above
void ballsDistance(const ShapePair& pair, const Vector3& direction, ClosestPoints& result) noexcept;           ///< see above
void polyhedronBallDistance(const ShapePair& pair, const Vector3& direction, ClosestPoints& result) noexcept;  ///< see above
void halfSpaceDistance(const ShapePair& pair, const Vector3& direction, ClosestPoints& result) noexcept;       ///< see above

/// Extent of a shape in the frame A along `direction` (unit, in A) [m]: its highest point's height. X_AS: of the shape.
double supportHeight(const ConvexShape& shape, const Pose& X_AS, const Vector3& direction) noexcept;

}  // namespace haptic
