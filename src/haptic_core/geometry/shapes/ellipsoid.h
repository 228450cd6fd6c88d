/// A true ellipsoid.
#pragma once
#include <memory>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic {

/// Centred on its frame's origin, with the axes of its frame. On planes and polyhedra it is exact (ellipsoid_contact.h); where it
/// meets other round shapes a polyhedron of 642 corners and the same volume stands in for one of the two. Throws SetupError unless
/// all three radii [m] are positive and finite.
class Ellipsoid : public ConvexShape {
 public:
  explicit Ellipsoid(const Vector3& radii, const std::string& name = "ellipsoid");  ///< along x, y and z [m]; `name` for messages

  const Vector3& radii() const { return radii_; }  ///< half of its axes [m]
  using ConvexShape::aabb;
  Box aabb(const Pose& X_WS) const override;
  TriangleMesh triangles() const override { return hull_->triangles(); }
  bool flat() const override { return false; }
  double surface() const override { return hull_->surface(); }  ///< of the tessellation: 0.3 % off for a ball
  double leastWidth() const override { return 2 * radii_.minCoeff(); }
  int faceCount() const override { return hull_->faceCount(); }
  int edgeCount() const override { return hull_->edgeCount(); }
  std::vector<Vector3> sides() const override { return {Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()}; }
  std::vector<Vector3> corners() const override { return hull_->vertices(); }
  void eachNumber(NumberVisitor& visitor) const override;
  Vector3 core(const Vector3& direction) const override;
  /// All about the normal through its outermost point: as it rolls there, V follows, and its form changes as the curvature alone does.
  OwnTurns ownTurns(const ContactPlace& place) const override { return {core(place.normal), Matrix3::Identity()}; }
  const ConvexPolyhedron* tessellation() const override { return hull_.get(); }
  double tessellationError() const override { return error_; }

 private:
  Vector3 radii_;
  std::shared_ptr<const ConvexPolyhedron> hull_;
  double error_;
};

inline const Ellipsoid* ConvexShape::ellipsoid() const {
  return kind_ == ShapeKind::kEllipsoid ? static_cast<const Ellipsoid*>(this) : nullptr;
}

}  // namespace haptic
