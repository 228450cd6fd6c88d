/// Poses, twists and wrenches: the vocabulary of every other folder.
///
/// Notation (monogram, as in Drake): X_AB is the pose of frame B in frame A, R_AB and p_AB its rotation and
/// origin; V_AB_C the twist of B relative to A, expressed in C; F_BC_W the wrench on body B at point C,
/// expressed in W. SI units throughout. Angular parts come first.
#pragma once
#include "haptic_core/base/eigen.h"

namespace haptic {

using Vector2 = Eigen::Vector2d;              ///< column of two
using Vector3 = Eigen::Vector3d;              ///< column of three: a point, a vector or an axis
using Vector6 = Eigen::Matrix<double, 6, 1>;  ///< column of six: angular or torque first
using Matrix2 = Eigen::Matrix2d;              ///< two by two
using Matrix3 = Eigen::Matrix3d;              ///< three by three
using Matrix6 = Eigen::Matrix<double, 6, 6>;  ///< six by six: rows and columns angular first
using Quaternion = Eigen::Quaterniond;        ///< w, x, y, z; of unit length where it stands for a rotation

/// Pose X_AB of a frame B in a frame A.
struct Pose {
  Matrix3 R = Matrix3::Identity();  ///< R_AB, right-handed and orthonormal
  Vector3 p = Vector3::Zero();      ///< p_AB [m], origin of B in A

  Pose() = default;
  Pose(const Matrix3& rotation, const Vector3& origin) : R(rotation), p(origin) {}  ///< R_AB and p_AB
  /// From a unit quaternion.
  Pose(const Quaternion& rotation, const Vector3& origin) : R(rotation.toRotationMatrix()), p(origin) {}
  explicit Pose(const Vector3& origin) : p(origin) {}  ///< axes parallel to A's

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
  Vector3 angular = Vector3::Zero();  ///< ω [rad/s]
  Vector3 linear = Vector3::Zero();   ///< velocity of the point [m/s]

  /// The same motion seen at a point displaced by `r` [m] (same axes).
  Twist shifted(const Vector3& r) const { return {angular, linear + angular.cross(r)}; }
  /// At one point, in one frame.
  Twist operator-(const Twist& o) const { return {angular - o.angular, linear - o.linear}; }
  /// At one point, in one frame.
  Twist operator+(const Twist& o) const { return {angular + o.angular, linear + o.linear}; }
  /// V_A from V_B, with R = R_AB.
  Twist rotated(const Matrix3& R) const { return {R * angular, R * linear}; }
  Twist operator*(double s) const { return {s * angular, s * linear}; }         ///< scaled
  Vector6 vector() const { return (Vector6() << angular, linear).finished(); }  ///< angular, then linear
};

/// Wrench about a point: torque [N·m] and force [N].
struct Wrench {
  Vector3 torque = Vector3::Zero();  ///< [N·m]
  Vector3 force = Vector3::Zero();   ///< [N]

  /// The same wrench about a point displaced by `r` [m] (same axes).
  Wrench shifted(const Vector3& r) const { return {torque - r.cross(force), force}; }
  Wrench operator-() const { return {-torque, -force}; }  ///< the reaction
  /// About one point, in one frame.
  Wrench operator+(const Wrench& o) const { return {torque + o.torque, force + o.force}; }
  /// About one point, in one frame.
  Wrench operator-(const Wrench& o) const { return {torque - o.torque, force - o.force}; }
  Wrench operator*(double s) const { return {s * torque, s * force}; }  ///< scaled
  Wrench& operator+=(const Wrench& o) { return *this = *this + o; }  ///< about one point, in one frame
  Wrench rotated(const Matrix3& R) const { return {R * torque, R * force}; }  ///< F_A from F_B, with R = R_AB
  bool allFinite() const { return torque.allFinite() && force.allFinite(); }  ///< no NaN and no infinity
  Vector6 vector() const { return (Vector6() << torque, force).finished(); }  ///< torque, then force
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
Quaternion rotationFromVector(const Vector3& theta) noexcept;

/// Rotation vector [rad], |theta| ≤ π, of a unit quaternion.
Vector3 vectorFromRotation(const Quaternion& q) noexcept;

/// Rotation by `angle` [rad] about the unit vector `axis`.
Matrix3 rotationAbout(const Vector3& axis, double angle) noexcept;

/// The shortest turn of the unit vector `a` onto the unit vector `b`, to 2e-15; of opposite ones about any axis across. Eigen's
/// FromTwoVectors brings a singular value decomposition into every file, 7 to 9 s of a compiler's time.
Quaternion shortestTurn(const Vector3& a, const Vector3& b) noexcept;

/// Rotation by roll, pitch and yaw [rad], as URDF has them: about the fixed axes x, y and z, in this order.
Matrix3 rotationFromRpy(const Vector3& rpy) noexcept;

}  // namespace haptic
