#include "haptic_core/base/spatial.h"

#include <cmath>

#include "haptic_core/base/elementary.h"

namespace haptic {

Quaternion rotationFromVector(const Vector3& theta) noexcept {
  const double half = 0.5 * theta.norm();
  const auto [sine, cosine] = elementary::sinCos(half);
  // sin(x)/x loses nothing above 1e-4; below, its series to x² is exact to 1e-18.
  const double s = half > 1e-4 ? sine / half : 1.0 - half * half / 6.0;
  const Vector3 v = 0.5 * s * theta;
  return Quaternion(cosine, v.x(), v.y(), v.z());
}

Vector3 vectorFromRotation(const Quaternion& q) noexcept {
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  const double n = q.vec().norm();
  const double factor = n > 1e-12 ? 2.0 * elementary::atan2(n, sign * q.w()) / n : 2.0;
  return sign * factor * q.vec();
}

Matrix3 rotationAbout(const Vector3& axis, double angle) noexcept {
  const auto [sine, cosine] = elementary::sinCos(angle);
  return cosine * Matrix3::Identity() + sine * crossMatrix(axis) + (1 - cosine) * axis * axis.transpose();
}

Quaternion shortestTurn(const Vector3& a, const Vector3& b) noexcept {
  // Half of the angle θ: |a + b| = 2 cos(θ/2), |a - b| = 2 sin(θ/2), and each sum is exact where it is small.
  constexpr double kOpposite = 1e-15;  // |a + b| of rounding alone: it has no direction
  const Vector3 sum = a + b, difference = a - b;
  const double length = sum.norm();
  const Vector3 v = length > kOpposite ? Vector3(difference.cross(sum) / (2 * length)) : a.unitOrthogonal();
  return Quaternion(0.5 * length, v.x(), v.y(), v.z()).normalized();
}

Matrix3 rotationFromRpy(const Vector3& rpy) noexcept {
  const auto [sx, cx] = elementary::sinCos(rpy.x());
  const auto [sy, cy] = elementary::sinCos(rpy.y());
  const auto [sz, cz] = elementary::sinCos(rpy.z());
  Matrix3 R;
  R << cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx,  //
      sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx,   //
      -sy, cy * sx, cy * cx;
  return R;
}

}  // namespace haptic
