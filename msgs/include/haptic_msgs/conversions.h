/// Between the core's types and ROS messages: the one place, for all wrappers. SI on both sides; frames are the caller's.
#pragma once
#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Transform.h>
#include <geometry_msgs/Twist.h>
#include <geometry_msgs/Wrench.h>
#include <haptic_msgs/EnergyLedger.h>
#include <ros/time.h>

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "haptic_core/base/spatial.h"
#include "haptic_core/loop/realtime.h"
#include "haptic_core/world/report.h"

namespace haptic {

/// A point [m].
inline geometry_msgs::Point toPoint(const Vector3& p) {
  geometry_msgs::Point m;
  m.x = p.x();
  m.y = p.y();
  m.z = p.z();
  return m;
}

/// A vector.
inline geometry_msgs::Vector3 toVector(const Vector3& v) {
  geometry_msgs::Vector3 m;
  m.x = v.x();
  m.y = v.y();
  m.z = v.z();
  return m;
}

/// A rotation; the result has unit length.
inline geometry_msgs::Quaternion toQuaternion(const Matrix3& R) {
  const Quaternion q = Quaternion(R).normalized();
  geometry_msgs::Quaternion m;
  m.w = q.w();
  m.x = q.x();
  m.y = q.y();
  m.z = q.z();
  return m;
}

/// X_AB as position and orientation of B in A.
inline geometry_msgs::Pose toPose(const Pose& X) {
  geometry_msgs::Pose m;
  m.position = toPoint(X.p);
  m.orientation = toQuaternion(X.R);
  return m;
}

/// X_AB as the transform that tf2 calls A → B.
inline geometry_msgs::Transform toTransform(const Pose& X) {
  geometry_msgs::Transform m;
  m.translation = toVector(X.p);
  m.rotation = toQuaternion(X.R);
  return m;
}

/// [rad/s], [m/s].
inline geometry_msgs::Twist toTwist(const Twist& V) {
  geometry_msgs::Twist m;
  m.linear = toVector(V.linear);
  m.angular = toVector(V.angular);
  return m;
}

/// [N·m], [N].
inline geometry_msgs::Wrench toWrench(const Wrench& F) {
  geometry_msgs::Wrench m;
  m.force = toVector(F.force);
  m.torque = toVector(F.torque);
  return m;
}

inline Vector3 fromVector(const geometry_msgs::Vector3& v) { return {v.x, v.y, v.z}; }  ///< a vector

/// Normalised; NaN stays NaN.
inline Quaternion fromQuaternion(const geometry_msgs::Quaternion& q) {
  return Quaternion(q.w, q.x, q.y, q.z).normalized();
}

/// X_AB from position and orientation of B in A; the orientation is normalised.
inline Pose fromPose(const geometry_msgs::Pose& pose) {
  return {fromQuaternion(pose.orientation), Vector3(pose.position.x, pose.position.y, pose.position.z)};
}

/// X_AB from tf2's A → B; the rotation is normalised.
inline Pose fromTransform(const geometry_msgs::Transform& transform) {
  return {fromQuaternion(transform.rotation), fromVector(transform.translation)};
}

/// [N·m], [N].
inline Wrench fromWrench(const geometry_msgs::Wrench& wrench) {
  return {fromVector(wrench.torque), fromVector(wrench.force)};
}

inline bool finite(const Pose& X) { return X.p.allFinite() && X.R.allFinite(); }  ///< no NaN and no infinity

/// ROS time of an instant on the steady clock [ns], the same whoever asks and when. With a simulated clock: its present time.
inline ros::Time toStamp(std::int64_t steady_ns) {
  // The two clocks differ by a constant until someone sets one. Two readings around the other clock's bound it, however long this
  // thread is kept from its core between them: with one, stamps of the same step differed by milliseconds on a busy machine.
  static std::atomic<std::int64_t> difference_ns{0};
  const std::int64_t before_ns = steadyNow();
  const ros::Time now = ros::Time::now();
  const std::int64_t after_ns = steadyNow();
  if (ros::Time::isSimTime()) return now;
  const auto now_ns = static_cast<std::int64_t>(now.toNSec());
  const std::int64_t known_ns = difference_ns.load(std::memory_order_relaxed);
  const std::int64_t bounded_ns = std::clamp(known_ns, now_ns - after_ns, now_ns - before_ns);
  if (bounded_ns != known_ns) difference_ns.store(bounded_ns, std::memory_order_relaxed);
  // Of an instant before the epoch, which ros::Time refuses, early in a wrong clock.
  return steady_ns + bounded_ns > 0 ? ros::Time().fromNSec(static_cast<std::uint64_t>(steady_ns + bounded_ns)) : now;
}

/// [J]; the message has the six sums that loops report.
inline haptic_msgs::EnergyLedger toLedger(const EnergyLedger& energy) {
  haptic_msgs::EnergyLedger m;
  m.kinetic = energy.kinetic;
  m.potential = energy.potential;
  m.elastic = energy.elastic;
  m.damping = energy.damping;
  m.friction = energy.friction;
  m.external = energy.external;
  return m;
}

}  // namespace haptic
