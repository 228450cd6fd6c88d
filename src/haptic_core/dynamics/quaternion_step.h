/// Quaternions among the numbers of q, and turning them by a rotation vector, for the inner loops.
#pragma once
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/base/lane_vector.h"
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

/// cos x and sin(x)/x of half an angle x [rad], by its square. Below 0.5 rad by their series, whose next term (x²)⁹/18! is
/// below 1e-20: no square root, no library call, same bits everywhere.
struct HalfTurn {
  explicit HalfTurn(double x2) {  ///< of x² [rad²]
    if (x2 > 0.25) {
      const double x = std::sqrt(x2);
      const elementary::SineCosine of_x = elementary::sinCos(x);
      cosine = of_x.cosine;
      sine_over_x = of_x.sine / x;
      return;
    }
    // By pairs of terms: half as long a chain of operations as by Horner's rule.
    const double x4 = x2 * x2, x8 = x4 * x4;
    cosine = 1 - x2 * (((1.0 / 2 - x2 * (1.0 / 24)) + x4 * (1.0 / 720 - x2 * (1.0 / 40320))) +
                       x8 * ((1.0 / 3628800 - x2 * (1.0 / 479001600)) + x4 * (1.0 / 87178291200)));
    sine_over_x = 1 - x2 * (((1.0 / 6 - x2 * (1.0 / 120)) + x4 * (1.0 / 5040 - x2 * (1.0 / 362880))) +
                            x8 * ((1.0 / 39916800 - x2 * (1.0 / 6227020800)) + x4 * (1.0 / 1307674368000)));
  }
  double cosine, sine_over_x;  ///< cos x, sin(x)/x
};

/// Unit quaternion of the rotation vector `theta` [rad].
inline Quaternion quaternionStep(const Vector3& theta) {
  const HalfTurn half(0.25 * theta.squaredNorm());
  const Vector3 v = 0.5 * half.sine_over_x * theta;
  return Quaternion(half.cosine, v.x(), v.y(), v.z());
}
/// The same.
inline LaneQuaternion quaternionStep(const Lanes& theta) {
  const HalfTurn half(0.25 * dot(theta, theta));
  return {half.cosine, lanes(0.5 * half.sine_over_x) * theta};
}

/// Unit length again, for a quaternion that left it by rounding only: one Newton step of 1/sqrt, error
/// (3/8)ε².
inline Quaternion renormalised(const Quaternion& r) {
  return Quaternion(r.coeffs() * (1.5 - 0.5 * r.squaredNorm()));
}
/// The same.
inline LaneQuaternion renormalised(const LaneQuaternion& r) {
  const double factor = 1.5 - 0.5 * (r.w * r.w + dot(r.u, r.u));
  return {factor * r.w, lanes(factor) * r.u};
}

}  // namespace haptic
