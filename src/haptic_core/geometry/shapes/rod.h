/// A true cylinder or capsule.
#pragma once
#include <algorithm>
#include <memory>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic {

/// All points within `radius` of an axis of length `length` along z, centred on the frame's origin, and, unless the ends are
/// flat, of its ends. Throws SetupError unless both lengths [m] are positive and finite.
class Rod : public ConvexShape {
 public:
  /// A cylinder's ends are flat, a capsule's round.
  enum class Ends : unsigned char { kFlat, kRound };

  /// Radius and length of the axis [m]; `name` is for messages.
  Rod(double radius, double length, Ends ends, const std::string& name = "rod");

  double radius() const { return r_; }         ///< [m]
  double halfLength() const { return half_; }  ///< of the axis: without the round ends
  bool isCapsule() const { return ends_ == Ends::kRound; }  ///< the ends are round
  using ConvexShape::aabb;
  Box aabb(const Pose& X_WS) const override;
  Vector3 core(const Vector3& direction) const override;
  double rounding() const override { return isCapsule() ? r_ : 0; }  ///< a capsule is all that is near its axis
  OwnTurns ownTurns(const ContactPlace& place) const override;  ///< about its axis; on a round end all about the end's centre
  TriangleMesh triangles() const override { return hull_->triangles(); }
  bool flat() const override { return false; }
  double surface() const override;
  double leastWidth() const override { return 2 * std::min(r_, half_ + rounding()); }
  std::vector<Vector3> sides() const override { return {Vector3::UnitZ(), Vector3::UnitX()}; }
  std::vector<Vector3> corners() const override { return hull_->vertices(); }
  void eachNumber(NumberVisitor& visitor) const override;

  /// A polyhedron of the same volume, for drawing and where faces are counted; contacts do not use it.
  const ConvexPolyhedron& hull() const { return *hull_; }

 private:
  double r_, half_;
  Ends ends_;
  std::shared_ptr<const ConvexPolyhedron> hull_;
};

inline const Rod* ConvexShape::rod() const {
  return kind_ == ShapeKind::kRod ? static_cast<const Rod*>(this) : nullptr;
}

}  // namespace haptic
