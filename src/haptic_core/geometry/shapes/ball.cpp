#include "haptic_core/geometry/shapes/ball.h"

#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/shapes.h"

namespace haptic {

Ball::Ball(double radius, const std::string& name) : ConvexShape(ShapeKind::kBall, name) {
  if (!(radius > 0) || !std::isfinite(radius)) {
    throw SetupError(name, "radius is " + std::to_string(radius), "give a positive length in metres");
  }
  const double volume = 4 * M_PI / 3 * radius * radius * radius;
  if (!(volume > 0) || !std::isfinite(volume)) {
    throw SetupError(name, "the volume of radius " + std::to_string(radius) + " m is no number",
                     "give coordinates in metres");
  }
  spins_ = true;
  properties_ = {volume, volume, Vector3::Zero(), 0.4 * volume * radius * radius * Matrix3::Identity()};
  radius_ = radius;
  aabb_ = {Vector3::Constant(-radius), Vector3::Constant(radius)};
}

std::vector<Vector3> Ball::corners() const {
  return makeSphere(radius_, 1).vertices();
}

TriangleMesh Ball::triangles() const {
  return makeSphere(radius_, 2, RoundFit::kInscribed, name_).triangles();
}

}  // namespace haptic
