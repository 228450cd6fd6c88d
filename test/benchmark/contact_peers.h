/// What others do for the same pair, for the benchmark of contacts.
#pragma once
#include "haptic_core/geometry/convex_polyhedron.h"

namespace haptic::bench {


/// Point manifolds of two boxes: number of points found; -1 when the peer is not installed.
int bulletBoxPoints(const Vector3& half_a, const Vector3& half_b, const Pose& X_AB);
int odeBoxPoints(const Vector3& half_a, const Vector3& half_b, const Pose& X_AB);

}  // namespace haptic::bench
