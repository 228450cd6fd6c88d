#include "haptic_core/geometry/pairs/time_of_impact.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/pairs/shape_distance.h"

namespace haptic {
namespace {

/// Advances of one search. A grazing rod that spins fast may need more: then the time reached so far is returned,
/// which is early, never late.
constexpr int kMostAdvances = 60;
/// Secants of one search; then the bound of the rate decides, which is early, never late.
constexpr int kMostSecants = 8;

double overlap(const ConvexShape& A, const Pose& X_WA, const ConvexShape& B, const Pose& X_WB, const Vector3& n) noexcept {
  return supportHeight(A, X_WA, n) + supportHeight(B, X_WB, -n);
}

}  // namespace

Pose ShapeMotion::at(double t) const {
  const Matrix3 turn = rotationFromVector(t * V_W.angular).toRotationMatrix();
  return {turn * X_WS.R, p_W + t * V_W.linear + turn * (X_WS.p - p_W)};
}

double approachRate(const ShapeMotion& a, const ShapeMotion& b, const Vector3& n) noexcept {
  return (a.V_W.linear - b.V_W.linear).dot(n) + a.V_W.angular.cross(n).norm() * a.reach +
         b.V_W.angular.cross(n).norm() * b.reach;
}

double timeOfImpact(const ConvexShape& A, const ShapeMotion& a, const ConvexShape& B, const ShapeMotion& b,
                    double h, double clearance, Vector3& direction_A) noexcept {
  double t = 0;
  for (int i = 0; i < kMostAdvances; ++i) {
    const Pose X_WA = a.at(t);
    ClosestPoints closest;
    closestPoints(A, B, relativePose(X_WA, b.at(t)), direction_A, closest);
    direction_A = closest.direction;
    if (!closest.separated || closest.distance <= clearance) return t;
    const double rate = approachRate(a, b, X_WA.R * closest.direction);
    // `distance` is that of the points found; along the direction it may be less by their rounding.
    const double gap = closest.distance - 0.5 * clearance;
    if (rate <= 0 || gap >= rate * (h - t)) return h;
    t += gap / rate;
  }
  return t;
}

double timeOfDepth(const ConvexShape& A, const ShapeMotion& a, const ConvexShape& B, const ShapeMotion& b,
                   double from, double h, double depth, const Vector3& n) noexcept {
  const Pose X_WA = a.at(from), X_WB = b.at(from);
  const double now = overlap(A, X_WA, B, X_WB, n);
  const Vector3 n_A = X_WA.R.transpose() * n, n_B = X_WB.R.transpose() * n;
  const double rate = approachRate(a, b, n), safe = rate * (h - from) > depth ? from + depth / rate : h;
  double t = h;
  for (int i = 0; i < kMostSecants && t > safe; ++i) {
    const Pose X_A = a.at(t), X_B = b.at(t);
    const double deeper = std::min(overlap(A, X_A, B, X_B, X_A.R * n_A), overlap(A, X_A, B, X_B, X_B.R * n_B)) - now;
    if (deeper <= depth) return t;
    t = from + (t - from) * depth / deeper;
  }
  return safe;
}

DepthTimes timesOfDepth(const ConvexShape& A, const ShapeMotion& a, const ConvexShape& B, const ShapeMotion& b, double h,
                        double clearance, double depth, const Vector3* touching_W) noexcept {
  if (touching_W) return {0, timeOfDepth(A, a, B, b, 0, h, depth, *touching_W)};
  Vector3 direction_A = a.X_WS.R.transpose() * (b.p_W - a.p_W);
  const double touch = timeOfImpact(A, a, B, b, h, clearance, direction_A);
  if (touch >= h) return {h, h};
  return {touch, timeOfDepth(A, a, B, b, touch, h, depth, a.at(touch).R * direction_A)};
}

}  // namespace haptic
