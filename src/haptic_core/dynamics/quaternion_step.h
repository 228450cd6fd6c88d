/// Quaternions among the numbers of q, and turning them by a rotation vector, for the inner loops.
#pragma once
#include "haptic_core/base/spatial.h"

namespace haptic {

/// The quaternion w, x, y, z at these places of q.
inline Quaternion quaternionAt(const double* q) { return Quaternion(q[0], q[1], q[2], q[3]); }

/// Puts it there.
inline void storeQuaternion(const Quaternion& r, double* q) {
  q[0] = r.w();
  q[1] = r.x();
  q[2] = r.y();
  q[3] = r.z();
}

/// Unit quaternion of the rotation vector `theta`. Below half an angle of 0.5 rad by the series of cos and
/// sin(x)/x, whose next term (x²)⁹/18! is below 1e-20: no square root, no library call, same bits everywhere.
inline Quaternion quaternionStep(const Vector3& theta) {
  const double x2 = 0.25 * theta.squaredNorm();
  if (x2 > 0.25) return rotationFromVector(theta);
  // By pairs of terms: half as long a chain of operations as by Horner's rule.
  const double x4 = x2 * x2, x8 = x4 * x4;
  const double c = 1 - x2 * (((1.0 / 2 - x2 * (1.0 / 24)) + x4 * (1.0 / 720 - x2 * (1.0 / 40320))) +
                             x8 * ((1.0 / 3628800 - x2 * (1.0 / 479001600)) + x4 * (1.0 / 87178291200)));
  const double s = 1 - x2 * (((1.0 / 6 - x2 * (1.0 / 120)) + x4 * (1.0 / 5040 - x2 * (1.0 / 362880))) +
                             x8 * ((1.0 / 39916800 - x2 * (1.0 / 6227020800)) + x4 * (1.0 / 1307674368000)));
  const Vector3 v = 0.5 * s * theta;
  return Quaternion(c, v.x(), v.y(), v.z());
}

/// Unit length again, for a quaternion that left it by rounding only: one Newton step of 1/sqrt, error
/// (3/8)ε².
inline Quaternion renormalised(const Quaternion& r) {
  return Quaternion(r.coeffs() * (1.5 - 0.5 * r.squaredNorm()));
}

}  // namespace haptic
