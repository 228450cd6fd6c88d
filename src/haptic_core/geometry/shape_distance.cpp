#include "haptic_core/geometry/shape_distance.h"

#include <cmath>

#include "haptic_core/geometry/ball.h"
#include "haptic_core/geometry/half_space.h"
#include "haptic_core/geometry/nearest_point.h"
#include "haptic_core/geometry/rod.h"

namespace haptic {
namespace {

/// From a polyhedron at X_AS to a ball about `centre_A`: unit direction to the centre, and its distance,
/// negative inside.
double centreDistance(const ConvexPolyhedron& shape, const Pose& X_AS, const Vector3& centre_A,
                      Vector3& direction_A) {
  const NearestPoint nearest = nearestPoint(shape, X_AS.R.transpose() * (centre_A - X_AS.p));
  direction_A = -(X_AS.R * nearest.direction);
  return nearest.distance - nearest.depth;
}

void closestWithRod(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, const Vector3& direction,
                    ClosestPoints& result) {
  closestCores(A, B, X_AB, direction, result);
  const double ra = A.rounding(), rb = B.rounding(), gap = result.distance - ra - rb;
  result.p_A += ra * result.direction;
  result.p_B -= rb * result.direction;
  result.separated = result.separated && gap > 0;
  result.distance = result.separated ? gap : 0;
  if (!result.separated) result.p_A = result.p_B = 0.5 * (result.p_A + result.p_B);
}

/// `shape` lies at X_HS in the half-space's frame. The half-space is A, or B.
void closestWithHalfSpace(const ConvexShape& shape, const Pose& X_HS, bool is_a, const Pose& X_AH, ClosestPoints& result) {
  const Vector3 down = -Vector3::UnitZ();
  const Vector3 lowest = X_HS * shape.core(X_HS.R.transpose() * down) + shape.rounding() * down;
  const Vector3 below(lowest.x(), lowest.y(), 0), up_A = X_AH.R.col(2);
  result = ClosestPoints{};
  result.separated = lowest.z() > 0;
  result.distance = std::max(0.0, lowest.z());
  result.direction = is_a ? up_A : Vector3(-up_A);
  result.p_A = X_AH * (is_a ? below : lowest);
  result.p_B = X_AH * (is_a ? lowest : below);
  if (!result.separated) result.p_A = result.p_B = 0.5 * (result.p_A + result.p_B);
}

/// Sine of an angle to a half-space's normal that is rounding.
constexpr double kUpright = 1e-12;

}  // namespace

void closestPoints(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, const Vector3& direction,
                   ClosestPoints& result) noexcept {
  if (A.polyhedron() && B.polyhedron())
    return closestPoints(*A.polyhedron(), *B.polyhedron(), X_AB, direction, result);
  if (A.halfSpace()) return closestWithHalfSpace(B, X_AB, true, Pose(), result);
  if (B.halfSpace()) return closestWithHalfSpace(A, X_AB.inverse(), false, X_AB, result);
  if (A.rod() || B.rod()) return closestWithRod(A, B, X_AB, direction, result);
  const double ra = A.ball() ? A.ball()->radius() : 0, rb = B.ball() ? B.ball()->radius() : 0;
  double between;
  Vector3 n;
  if (A.ball() && B.ball()) {
    between = X_AB.p.norm();
    n = between > 0                   ? Vector3(X_AB.p / between)
        : direction.squaredNorm() > 0 ? direction
                                      : Vector3(Vector3::UnitZ());
  } else if (A.ball()) {
    between = centreDistance(*B.polyhedron(), X_AB, Vector3::Zero(), n);
    n = -n;
  } else {
    between = centreDistance(*A.polyhedron(), Pose(), X_AB.p, n);
  }
  const double gap = between - ra - rb;
  result = ClosestPoints{};
  result.separated = gap > 0;
  result.distance = std::max(0.0, gap);
  result.direction = n;
  result.p_A = A.ball() ? Vector3(ra * n) : Vector3(X_AB.p - between * n);
  result.p_B = B.ball() ? Vector3(X_AB.p - rb * n) : Vector3(between * n);
  if (!result.separated) result.p_A = result.p_B = 0.5 * (result.p_A + result.p_B);
}

double supportHeight(const ConvexShape& shape, const Pose& X_AS, const Vector3& direction) noexcept {
  if (shape.halfSpace() && (direction - X_AS.R.col(2)).norm() > kUpright) return INFINITY;
  return direction.dot(X_AS * shape.core(X_AS.R.transpose() * direction)) + shape.rounding();
}

}  // namespace haptic
