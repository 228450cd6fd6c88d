/// Distance and a separating direction of two convex polyhedra.
#pragma once
#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic {

/// The nearest points of two convex polyhedra, and a direction that separates them.
struct ClosestPoints {
  bool separated = false;  ///< `direction` proves it: no point of A reaches the lowest of B
  double distance = 0;     ///< [m]; 0 unless separated
  Vector3 direction =
      Vector3::Zero();             ///< unit, from A to B, in A's frame; the best found when not separated
  Vector3 p_A = Vector3::Zero();   ///< closest point of A, in A's frame; a common point when not separated
  Vector3 p_B = Vector3::Zero();   ///< closest point of B, in A's frame
  int vertex_a = 0, vertex_b = 0;  ///< supports, hints for the next call
};

/// Gilbert, Johnson & Keerthi 1988: the point of the difference A − B nearest to the origin, by descending
/// over simplices of support points. `direction` starts the search: with last step's result it takes one or
/// two iterations. `separated` is only set when the two supports along `direction` prove it, so rounding
/// cannot make a false claim. (in realtime)
void closestPoints(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
                   const Vector3& direction, ClosestPoints& result) noexcept;

/// The same of the cores of any two shapes; `distance` is the gap along `direction`. (in realtime)
void closestCores(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, const Vector3& direction,
                  ClosestPoints& result) noexcept;

/// Gap of A and B along unit `direction` (from A to B, in A's frame): > 0 proves them separated. Updates the
/// hints.
double gapAlong(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
                const Vector3& direction, int& vertex_a, int& vertex_b) noexcept;

}  // namespace haptic
