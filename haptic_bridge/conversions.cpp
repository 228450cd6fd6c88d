#include "haptic_bridge/conversions.h"

namespace haptic {
namespace {

geometry_msgs::Vector3 vectorMessage(const Vector3& v) {
  geometry_msgs::Vector3 m;
  m.x = v.x();
  m.y = v.y();
  m.z = v.z();
  return m;
}

geometry_msgs::Wrench wrenchMessage(const Wrench& F) {
  geometry_msgs::Wrench m;
  m.force = vectorMessage(F.force);
  m.torque = vectorMessage(F.torque);
  return m;
}

geometry_msgs::Pose poseMessage(const Pose& X) {
  const Quaternion q = Quaternion(X.R).normalized();
  geometry_msgs::Pose m;
  m.position.x = X.p.x();
  m.position.y = X.p.y();
  m.position.z = X.p.z();
  m.orientation.w = q.w();
  m.orientation.x = q.x();
  m.orientation.y = q.y();
  m.orientation.z = q.z();
  return m;
}

}  // namespace

haptic_msgs::EnergyLedger ledgerMessage(const EnergyLedger& energy) {
  haptic_msgs::EnergyLedger m;
  m.kinetic = energy.kinetic;
  m.potential = energy.potential;
  m.elastic = energy.elastic;
  m.damping = energy.damping;
  m.friction = energy.friction;
  m.external = energy.external;
  return m;
}

haptic_msgs::HandReport handMessage(const HandReport& report, const std::string& device, const std::string& pointer) {
  haptic_msgs::HandReport m;
  m.device = device;
  m.pointer = pointer;
  m.pose = poseMessage(report.X_BG);
  m.twist.linear = vectorMessage(report.V_BG.linear);
  m.twist.angular = vectorMessage(report.V_BG.angular);
  m.opening = report.opening;
  m.asked = wrenchMessage(report.F_asked_B);
  m.achieved = wrenchMessage(report.F_achieved_B);
  m.tension.assign(report.tension.data(), report.tension.data() + report.tension.size());
  m.pose_residual = report.pose_residual;
  m.port_energy = report.port_energy;
  m.flags = report.device_flags;
  return m;
}

}  // namespace haptic
