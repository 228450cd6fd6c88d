#include "haptic_core/geometry/pairs/shape_distance.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/search/nearest_point.h"

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

void setGap(double gap, const Vector3& n, const Vector3& p_A, const Vector3& p_B, ClosestPoints& result) {
  result = ClosestPoints{};
  result.separated = gap > 0;
  result.distance = std::max(0.0, gap);
  result.direction = n;
  result.p_A = p_A, result.p_B = p_B;
  if (!result.separated) result.p_A = result.p_B = 0.5 * (p_A + p_B);
}

/// Sine of an angle to a half-space's normal that is rounding.
constexpr double kUpright = 1e-12;

}  // namespace

void polyhedraDistance(const ShapePair& pair, const Vector3& direction, ClosestPoints& result) noexcept {
  closestPoints(*pair.A().polyhedron(), *pair.B().polyhedron(), pair.X_AB, direction, result);
}

void halfSpaceDistance(const ShapePair& pair, const Vector3&, ClosestPoints& result) noexcept {
  const ConvexShape& shape = pair.second;
  const bool is_a = !pair.turned;
  const Pose X_AH = is_a ? Pose() : pair.X_AB, X_HS = is_a ? pair.X_AB : pair.X_AB.inverse();
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

void coresDistance(const ShapePair& pair, const Vector3& direction, ClosestPoints& result) noexcept {
  closestCores(pair.A(), pair.B(), pair.X_AB, direction, result);
  const double ra = pair.A().rounding(), rb = pair.B().rounding(), gap = result.distance - ra - rb;
  result.p_A += ra * result.direction;
  result.p_B -= rb * result.direction;
  result.separated = result.separated && gap > 0;
  result.distance = result.separated ? gap : 0;
  if (!result.separated) result.p_A = result.p_B = 0.5 * (result.p_A + result.p_B);
}

void ballsDistance(const ShapePair& pair, const Vector3& direction, ClosestPoints& result) noexcept {
  const Vector3& p = pair.X_AB.p;
  const double ra = pair.A().rounding(), rb = pair.B().rounding(), between = p.norm();
  const Vector3 n = between > 0                   ? Vector3(p / between)
                    : direction.squaredNorm() > 0 ? direction
                                                  : Vector3(Vector3::UnitZ());
  setGap(between - ra - rb, n, ra * n, p - rb * n, result);
}

void polyhedronBallDistance(const ShapePair& pair, const Vector3&, ClosestPoints& result) noexcept {
  const ConvexPolyhedron& shape = *pair.first.polyhedron();
  const double r = pair.second.rounding();
  Vector3 n;
  if (pair.turned) {
    const double between = centreDistance(shape, pair.X_AB, Vector3::Zero(), n);
    n = -n;
    setGap(between - r, n, r * n, between * n, result);
  } else {
    const double between = centreDistance(shape, Pose(), pair.X_AB.p, n);
    setGap(between - r, n, pair.X_AB.p - between * n, pair.X_AB.p - r * n, result);
  }
}

double supportHeight(const ConvexShape& shape, const Pose& X_AS, const Vector3& direction) noexcept {
  if (!shape.bounded() && (direction - X_AS.R.col(2)).norm() > kUpright) return INFINITY;
  return direction.dot(X_AS * shape.core(X_AS.R.transpose() * direction)) + shape.rounding();
}

}  // namespace haptic
