#include "spidar_driver/conversions.h"

#include "haptic_core/loop/realtime.h"

namespace haptic {

geometry_msgs::Point toPoint(const Vector3& p) {
  geometry_msgs::Point m;
  m.x = p.x();
  m.y = p.y();
  m.z = p.z();
  return m;
}

geometry_msgs::Vector3 toVector(const Vector3& v) {
  geometry_msgs::Vector3 m;
  m.x = v.x();
  m.y = v.y();
  m.z = v.z();
  return m;
}

geometry_msgs::Quaternion toQuaternion(const Matrix3& R) {
  const Quaternion q = Quaternion(R).normalized();
  geometry_msgs::Quaternion m;
  m.w = q.w();
  m.x = q.x();
  m.y = q.y();
  m.z = q.z();
  return m;
}

geometry_msgs::Pose toPose(const Pose& X) {
  geometry_msgs::Pose m;
  m.position = toPoint(X.p);
  m.orientation = toQuaternion(X.R);
  return m;
}

geometry_msgs::Transform toTransform(const Pose& X) {
  geometry_msgs::Transform m;
  m.translation = toVector(X.p);
  m.rotation = toQuaternion(X.R);
  return m;
}

geometry_msgs::Wrench toWrench(const Wrench& F) {
  geometry_msgs::Wrench m;
  m.force = toVector(F.force);
  m.torque = toVector(F.torque);
  return m;
}

namespace {

Quaternion fromQuaternion(const geometry_msgs::Quaternion& q) { return Quaternion(q.w, q.x, q.y, q.z).normalized(); }

}  // namespace

Pose fromPose(const geometry_msgs::Pose& pose) {
  return {fromQuaternion(pose.orientation), Vector3(pose.position.x, pose.position.y, pose.position.z)};
}

Pose fromTransform(const geometry_msgs::Transform& transform) {
  const auto& p = transform.translation;
  return {fromQuaternion(transform.rotation), Vector3(p.x, p.y, p.z)};
}

Wrench fromWrench(const geometry_msgs::Wrench& wrench) {
  return {Vector3(wrench.torque.x, wrench.torque.y, wrench.torque.z),
          Vector3(wrench.force.x, wrench.force.y, wrench.force.z)};
}

ros::Time toStamp(std::int64_t steady_ns) {
  const ros::Time now = ros::Time::now();
  if (ros::Time::isSimTime()) return now;
  return now - ros::Duration().fromNSec(steadyNow() - steady_ns);
}

haptic_msgs::DeviceState toState(const DeviceRecord& record, const DeviceDef& def) {
  haptic_msgs::DeviceState m;
  switch (record.state) {
    case DeviceState::kUncalibrated:
      m.state = m.UNCALIBRATED;
      break;
    case DeviceState::kReady:
      m.state = m.READY;
      break;
    case DeviceState::kEnabled:
      m.state = m.ENABLED;
      break;
    case DeviceState::kReduced:
      m.state = m.REDUCED;
      break;
    case DeviceState::kFault:
      m.state = (record.flags & kLinkLost) ? m.DISCONNECTED : m.FAULT;
      break;
  }
  m.message = advice(record, def.name);
  m.model = def.name;
  m.handedness = static_cast<std::uint8_t>(def.handedness);
  m.dof = static_cast<std::uint8_t>(def.dof);
  m.strings = static_cast<std::uint8_t>(def.strings.size());
  m.force_enabled = record.state == DeviceState::kEnabled || record.state == DeviceState::kReduced;
  m.max_force = def.max_force;
  m.max_torque = def.max_torque;
  m.pose_residual = record.pose_residual;
  m.flags = record.flags;
  m.suspect_string = record.suspect_string;
  return m;
}

}  // namespace haptic
