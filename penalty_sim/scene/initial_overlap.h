/// Links that overlap before anything moves.
#pragma once
#include "haptic_core/geometry/shapes/convex_shape.h"
#include "scene/robot_tree.h"

namespace haptic {

inline constexpr double kTouches = 1e-6;  ///< [m]: what is not as deep is the rounding of a pose, or a resting contact

/// An upper bound of how far B must move to leave A [m]: the least overlap along a face normal of either, with a ball
/// along the way to its centre; 0 when a direction proves them apart. Exact but for edge against edge.
double overlapDepth(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB);

/// Pairs of one robot that overlap at the start (hulls of neighbours beyond one joint, closed fingers) do not
/// collide, with a warning that names them: their contact would throw the robot apart. Pairs of different
/// bodies stay, and are warned of when they overlap deeper than contact ever would.
void filterInitialOverlaps(LoadContext& context);

}  // namespace haptic
