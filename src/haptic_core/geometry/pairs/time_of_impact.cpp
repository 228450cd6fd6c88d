#include "haptic_core/geometry/pairs/time_of_impact.h"

#include <cmath>

#include "haptic_core/geometry/pairs/shape_distance.h"

namespace haptic {
namespace {

/// Advances of one search. A grazing rod that spins fast may need more: then the time reached so far is returned,
/// which is early, never late.
constexpr int kMostAdvances = 60;

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

}  // namespace haptic
