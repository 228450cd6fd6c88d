#include "haptic_core/geometry/shapes/ellipsoid.h"

#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/shapes.h"

namespace haptic {
namespace {

/// The ball's tessellation, stretched.
ConvexPolyhedron stretchedBall(const Vector3& radii, const std::string& name) {
  static const ConvexPolyhedron ball = makeSphere(1, 3, RoundFit::kEqualVolume);
  std::vector<Vector3> corners = ball.vertices();
  for (Vector3& corner : corners) corner = corner.cwiseProduct(radii);
  std::vector<std::vector<int>> loops(ball.faceCount());
  for (int f = 0; f < ball.faceCount(); ++f) {
    for (int i = 0; i < ball.cornerCount(f); ++i) loops[f].push_back(ball.key(f, i));
  }
  return ConvexPolyhedron(std::move(corners), loops, name);
}

}  // namespace

Ellipsoid::Ellipsoid(const Vector3& radii, const std::string& name) : ConvexShape(ShapeKind::kEllipsoid, name), radii_(radii) {
  checkLength(radii.x(), "radius along x", name);
  checkLength(radii.y(), "radius along y", name);
  checkLength(radii.z(), "radius along z", name);
  const double volume = 4 * M_PI / 3 * radii.prod();
  if (!(volume > 0) || !std::isfinite(volume)) throw SetupError(name, "its volume is no number", "give radii in metres");
  const Vector3 squares = 0.2 * volume * radii.cwiseProduct(radii);
  properties_ = {volume, volume, Vector3::Zero(), Matrix3(Vector3(Vector3::Constant(squares.sum()) - squares).asDiagonal())};
  spins_ = true;
  radius_ = radii.maxCoeff();
  aabb_ = {-radii, radii};
  hull_ = std::make_shared<const ConvexPolyhedron>(stretchedBall(radii, name));
  error_ = haptic::tessellationError(*this, *hull_);
}

ConvexShape::Box Ellipsoid::aabb(const Pose& X_WS) const {
  Vector3 reach;
  for (int i = 0; i < 3; ++i) reach[i] = X_WS.R.row(i).transpose().cwiseProduct(radii_).norm();
  return {X_WS.p - reach, X_WS.p + reach};
}

void Ellipsoid::eachNumber(NumberVisitor& visitor) const {
  visitor.visit(static_cast<int>(kind()));  // three lengths may be a rod's as well
  for (int i = 0; i < 3; ++i) visitor.visit(radii_[i]);
}

Vector3 Ellipsoid::core(const Vector3& direction) const {
  const Vector3 stretched = radii_.cwiseProduct(direction);
  return radii_.cwiseProduct(stretched) / stretched.norm();
}

}  // namespace haptic
