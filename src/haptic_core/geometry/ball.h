/// A true ball.
#pragma once
#include "haptic_core/geometry/convex_shape.h"

namespace haptic {

/// Centred on its frame's origin. Throws SetupError unless the radius [m] is positive and finite.
class Ball : public ConvexShape {
 public:
  explicit Ball(double radius, const std::string& name = "ball");  ///< `radius` [m]; `name` for messages

  double radius() const { return boundingRadius(); }  ///< [m]
  using ConvexShape::aabb;
  Box aabb(const Pose& X_WS) const override {
    return {X_WS.p - Vector3::Constant(radius_), X_WS.p + Vector3::Constant(radius_)};
  }
  TriangleMesh triangles() const override;  ///< 320 triangles, corners on the sphere
  Vector3 core(const Vector3&) const override { return Vector3::Zero(); }
  double rounding() const override { return radius_; }  ///< its core is a point
};

inline const Ball* ConvexShape::ball() const {
  return kind_ == Kind::kBall ? static_cast<const Ball*>(this) : nullptr;
}

}  // namespace haptic
