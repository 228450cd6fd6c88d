/// What others do for the same pair, for the benchmark of contacts.
#pragma once
#include <memory>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic::bench {

/// Two boxes of Bullet, made before anything is timed: shapes outlive their contacts there as here.
class BulletBoxes {
 public:
  BulletBoxes(const Vector3& half_a, const Vector3& half_b);
  ~BulletBoxes();
  /// Number of points of their manifold; -1 when Bullet is not installed.
  int points(const Pose& X_AB) const;

 private:
  struct Shapes;
  std::unique_ptr<Shapes> shapes_;
};
/// Number of points of two boxes; -1 when ODE is not installed. Its function takes sizes, no shapes.
int odeBoxPoints(const Vector3& half_a, const Vector3& half_b, const Pose& X_AB);

}  // namespace haptic::bench
