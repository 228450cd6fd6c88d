/// Poses, twists and wrenches: the vocabulary of every other folder.
///
/// Notation (monogram, as in Drake): X_AB is the pose of frame B in frame A, R_AB and p_AB its rotation and
/// origin; V_AB_C the twist of B relative to A, expressed in C; F_BC_W the wrench on body B at point C,
/// expressed in W. SI units throughout. Angular parts come first.
#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace haptic {

using Vector2 = Eigen::Vector2d;
using Vector3 = Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix2 = Eigen::Matrix2d;
using Matrix3 = Eigen::Matrix3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Quaternion = Eigen::Quaterniond;

/// Pose X_AB of a frame B in a frame A.
struct Pose {
  Matrix3 R = Matrix3::Identity();  ///< R_AB, right-handed and orthonormal
  Vector3 p = Vector3::Zero();      ///< p_AB [m], origin of B in A

  Pose() = default;
  Pose(const Matrix3& rotation, const Vector3& origin) : R(rotation), p(origin) {}
  Pose(const Quaternion& rotation, const Vector3& origin) : R(rotation.toRotationMatrix()), p(origin) {}
  explicit Pose(const Vector3& origin) : p(origin) {}

  Pose inverse() const { return {R.transpose(), -(R.transpose() * p)}; }       ///< X_BA
  Pose operator*(const Pose& X_BC) const { return {R * X_BC.R, p + R * X_BC.p}; }  ///< X_AC
  Vector3 operator*(const Vector3& p_B) const { return p + R * p_B; }          ///< a point of B, in A
};

/// X_AB from X_WA and X_WB. The difference of the origins is taken before anything is rotated, so that the
/// rounding of poses far from W's origin enters once only, through their own representation.
inline Pose relativePose(const Pose& X_WA, const Pose& X_WB) {
  return {X_WA.R.transpose() * X_WB.R, X_WA.R.transpose() * (X_WB.p - X_WA.p)};
}

/// Twist of a body at a point: angular [rad/s] and linear [m/s].
struct Twist {
  Vector3 angular = Vector3::Zero();
  Vector3 linear = Vector3::Zero();

  /// The same motion seen at a point displaced by `r` [m] (same axes).
  Twist shifted(const Vector3& r) const { return {angular, linear + angular.cross(r)}; }
  Twist operator-(const Twist& o) const { return {angular - o.angular, linear - o.linear}; }
  Twist operator+(const Twist& o) const { return {angular + o.angular, linear + o.linear}; }
  Twist rotated(const Matrix3& R) const { return {R * angular, R * linear}; }
  Vector6 vector() const { return (Vector6() << angular, linear).finished(); }
};

/// Wrench about a point: torque [N·m] and force [N].
struct Wrench {
  Vector3 torque = Vector3::Zero();
  Vector3 force = Vector3::Zero();

  /// The same wrench about a point displaced by `r` [m] (same axes).
  Wrench shifted(const Vector3& r) const { return {torque - r.cross(force), force}; }
  Wrench operator-() const { return {-torque, -force}; }
  Wrench operator+(const Wrench& o) const { return {torque + o.torque, force + o.force}; }
  Wrench operator-(const Wrench& o) const { return {torque - o.torque, force - o.force}; }
  Wrench operator*(double s) const { return {s * torque, s * force}; }
  Wrench& operator+=(const Wrench& o) { return *this = *this + o; }
  Wrench rotated(const Matrix3& R) const { return {R * torque, R * force}; }
  bool allFinite() const { return torque.allFinite() && force.allFinite(); }
  Vector6 vector() const { return (Vector6() << torque, force).finished(); }
};

/// Power of a wrench on a motion at the same point [W].
inline double power(const Wrench& F, const Twist& V) { return F.torque.dot(V.angular) + F.force.dot(V.linear); }

/// [a]× with [a]× b = a × b.
inline Matrix3 crossMatrix(const Vector3& a) {
  Matrix3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

/// Unit quaternion of the rotation vector `theta` [rad]; exact to rounding also for theta → 0.
inline Quaternion rotationFromVector(const Vector3& theta) {
  const double half = 0.5 * theta.norm();
  // sin(x)/x loses nothing above 1e-4; below, its series to x² is exact to 1e-18.
  const double s = half > 1e-4 ? std::sin(half) / half : 1.0 - half * half / 6.0;
  const Vector3 v = 0.5 * s * theta;
  return Quaternion(std::cos(half), v.x(), v.y(), v.z());
}

/// Rotation vector [rad], |theta| ≤ π, of a unit quaternion.
inline Vector3 vectorFromRotation(const Quaternion& q) {
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  const double n = q.vec().norm();
  const double factor = n > 1e-12 ? 2.0 * std::atan2(n, sign * q.w()) / n : 2.0;
  return sign * factor * q.vec();
}

}  // namespace haptic
