/// A cone, or a frustum of one.
#pragma once
#include "haptic_core/geometry/shapes/support_shape.h"

namespace haptic {

/// All between two discs across z, centred on it: one of `radius` at z = −length/2, one of `top_radius`, which may be 0, at +length/2.
/// Mass, bounds, distance and time of impact are exact. In contacts a polyhedron of 64 sides stands in, whose ends have the true
/// areas and whose volume is the true one; its side is within 0.09 % of the larger radius. Throws SetupError unless length and
/// radius [m] are positive and finite, and the top's not negative.
class Cone : public SupportShape {
 public:
  Cone(double radius, double top_radius, double length, const std::string& name = "cone");  ///< [m]; `name` for messages

  double radius() const { return r_; }         ///< at −z [m]
  double topRadius() const { return top_; }    ///< at +z [m]
  double halfLength() const { return half_; }  ///< [m]
  std::vector<Vector3> sides() const override;
  void eachNumber(NumberVisitor& visitor) const override;
  Vector3 core(const Vector3& direction) const override;

 private:
  double r_, top_, half_;
};

}  // namespace haptic
