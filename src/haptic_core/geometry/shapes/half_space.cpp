#include "haptic_core/geometry/shapes/half_space.h"

#include <cmath>

namespace haptic {
namespace {

/// Sine of a tilt that moves the surface by less than a rounding of W's coordinates within a thousand metres.
constexpr double kLevel = 1e-19;

}  // namespace

HalfSpace::HalfSpace(const std::string& name) : ConvexShape(ShapeKind::kHalfSpace, name) {
  properties_ = {INFINITY, INFINITY, Vector3::Zero(), Matrix3::Identity() * INFINITY};
  radius_ = INFINITY;
  aabb_ = aabb(Pose());
}

ConvexShape::Box HalfSpace::aabb(const Pose& X_WS) const {
  Box box{Vector3::Constant(-INFINITY), Vector3::Constant(INFINITY)};
  const Vector3 n = X_WS.R.col(2);
  for (int i = 0; i < 3; ++i) {
    if (std::abs(n[(i + 1) % 3]) > kLevel || std::abs(n[(i + 2) % 3]) > kLevel) continue;
    (n[i] > 0 ? box.upper : box.lower)[i] = X_WS.p[i];
  }
  return box;
}

TriangleMesh HalfSpace::triangles() const {
  TriangleMesh mesh;
  mesh.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

}  // namespace haptic
