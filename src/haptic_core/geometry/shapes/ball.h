/// A true ball.
#pragma once
#include "haptic_core/geometry/shapes/convex_shape.h"

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
  bool flat() const override { return false; }
  double surface() const override { return 4 * M_PI * radius_ * radius_; }
  double leastWidth() const override { return 2 * radius_; }
  std::vector<Vector3> sides() const override { return {Vector3::UnitZ()}; }
  std::vector<Vector3> corners() const override;  ///< of 80 triangles
  void eachNumber(NumberVisitor& visitor) const override { visitor.visit(radius_); }
  Vector3 core(const Vector3&) const override { return Vector3::Zero(); }
  double rounding() const override { return radius_; }  ///< its core is a point
  OwnTurns ownTurns(const ContactPlace&) const override { return {Vector3::Zero(), Matrix3::Identity()}; }  ///< all about its centre
};

inline const Ball* ConvexShape::ball() const {
  return kind_ == ShapeKind::kBall ? static_cast<const Ball*>(this) : nullptr;
}

}  // namespace haptic
