/// Sums over edges from which all moments of V are made.
#pragma once
#include "haptic_core/base/spatial.h"

namespace haptic {

/// Integrals over V and over its projection, in coordinates with P's axes and any origin o.
///
/// V is the sum of signed tetrahedra (o, m, p, q), one per half edge p → q of each face with any point m of
/// the face's plane as apex: the triangles (m, p, q) of a loop add up to the face. The projection is the sum
/// of signed triangles (o, p, q) along the seam.
struct MomentSums {
  double volume = 0, A0 = 0;                           ///< ∫ dV [m³], ∫ dA [m²]
  Vector3 V1 = Vector3::Zero();                        ///< ∫ x dV [m⁴]
  Vector2 A1 = Vector2::Zero();                        ///< ∫ r dA [m³], r = (x, y)
  Matrix2 V2 = Matrix2::Zero(), A2 = Matrix2::Zero();  ///< ∫ r rᵀ dV [m⁵], ∫ r rᵀ dA [m⁴]

  /// Adds the signed tetrahedron (o, m, p, q) to the volume.
  void addTetrahedron(const Vector3& m, const Vector3& p, const Vector3& q) {
    const double v = m.dot(p.cross(q)) / 6;
    const Vector3 sum = m + p + q;
    volume += v;
    V1 += v / 4 * sum;
    V2 += v / 20 * (square(sum) + square(m) + square(p) + square(q));
  }

  /// Adds the signed triangle (o, p, q) to the projection.
  void addTriangle(const Vector3& p, const Vector3& q) {
    const double a = 0.5 * (p.x() * q.y() - p.y() * q.x());
    const Vector3 sum = p + q;
    A0 += a;
    A1 += a / 3 * sum.head<2>();
    A2 += a / 12 * (square(sum) + square(p) + square(q));
  }

  /// The same integrals with the origin at `c`.
  MomentSums about(const Vector3& c) const {
    MomentSums s = *this;
    const Vector2 t = c.head<2>();
    s.V1 = V1 - volume * c;
    s.A1 = A1 - A0 * t;
    s.V2 = V2 - V1.head<2>() * t.transpose() - t * V1.head<2>().transpose() + volume * t * t.transpose();
    s.A2 = A2 - A1 * t.transpose() - t * A1.transpose() + A0 * t * t.transpose();
    return s;
  }

 private:
  static Matrix2 square(const Vector3& x) { return x.head<2>() * x.head<2>().transpose(); }
};

}  // namespace haptic
