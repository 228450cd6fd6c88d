#include "haptic_core/geometry/shapes/support_shape.h"

#include <algorithm>

#include "haptic_core/geometry/shapes/shapes.h"

namespace haptic {

void SupportShape::tessellate() {
  static const ConvexPolyhedron directions = makeSphere(1, 3);
  std::vector<Vector3> points;
  for (const Vector3& n : directions.vertices()) {
    const Vector3 point = core(n) + rounding() * n;
    if (std::find(points.begin(), points.end(), point) == points.end()) points.push_back(point);  // edges answer many directions
  }
  ConvexPolyhedron hull = ConvexPolyhedron::hull(points, name_);
  const MassProperties properties = hull.massProperties(1);
  tessellate(std::move(hull), properties);
}

void SupportShape::tessellate(ConvexPolyhedron hull, const MassProperties& properties) {
  properties_ = properties;
  hull_ = std::make_shared<const ConvexPolyhedron>(std::move(hull));
  error_ = haptic::tessellationError(*this, *hull_);
  for (const Vector3& corner : hull_->vertices()) radius_ = std::max(radius_, (corner - centre()).norm() + error_);
  aabb_ = aabb(Pose());
}

ConvexShape::Box SupportShape::aabb(const Pose& X_WS) const {
  Box box;
  for (int i = 0; i < 3; ++i) {
    const Vector3 up = X_WS.R.row(i).transpose();
    box.upper[i] = X_WS.p[i] + up.dot(core(up)) + rounding();
    box.lower[i] = X_WS.p[i] + up.dot(core(-up)) - rounding();
  }
  return box;
}

std::vector<Vector3> SupportShape::sides() const {
  std::vector<Vector3> sides;
  for (int i = 0; i < 3; ++i) sides.push_back(Vector3::Unit(i)), sides.push_back(-Vector3::Unit(i));
  return sides;
}

}  // namespace haptic
