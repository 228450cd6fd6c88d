/// A half-space: ground without an end and without a far side.
#pragma once
#include "haptic_core/geometry/shapes/convex_shape.h"

namespace haptic {

/// All points with z ≤ 0 in its frame; its surface looks along +z. It has no mass and no size, so it belongs on links that do
/// not move. However deep something lies in it, the way out is up.
class HalfSpace : public ConvexShape {
 public:
  explicit HalfSpace(const std::string& name = "half-space");  ///< `name` for messages

  using ConvexShape::aabb;
  /// Infinite, but for the side that it faces where that is an axis of W.
  Box aabb(const Pose& X_WS) const override;
  TriangleMesh triangles() const override;  ///< a square of 2 m about the frame's origin
  bool flat() const override { return true; }
  double surface() const override { return INFINITY; }
  double leastWidth() const override { return INFINITY; }
  std::vector<Vector3> sides() const override { return {Vector3::UnitZ()}; }
  std::vector<Vector3> corners() const override { return {}; }
  void eachNumber(NumberVisitor& visitor) const override { visitor.visit(radius_); }
  /// Has none: farther than any point along all directions but +z (`supportHeight` knows).
  Vector3 core(const Vector3&) const override { return Vector3::Zero(); }
};

inline const HalfSpace* ConvexShape::halfSpace() const {
  return kind_ == ShapeKind::kHalfSpace ? static_cast<const HalfSpace*>(this) : nullptr;
}

}  // namespace haptic
