#include "haptic_bridge/conversions.h"

namespace haptic {

haptic_msgs::HandReport toHandReport(const HandReport& report, const std::string& device, const std::string& pointer) {
  haptic_msgs::HandReport m;
  m.device = device;
  m.pointer = pointer;
  m.pose = toPose(report.X_BG);
  m.twist = toTwist(report.V_BG);
  m.opening = report.opening;
  m.asked = toWrench(report.F_asked_B);
  m.achieved = toWrench(report.F_achieved_B);
  m.tension.assign(report.tension.data(), report.tension.data() + report.tension.size());
  m.pose_residual = report.pose_residual;
  m.port_energy = report.port_energy;
  m.flags = report.device_flags;
  m.dissipated = report.dissipated;
  m.fade = report.fade;
  m.stiffness = report.stiffness;
  m.stiffness_share = report.stiffness_share;
  m.softened = report.stiffness_share < 1;
  m.in_contact = report.in_contact;
  m.clutched = report.clutched;
  return m;
}

}  // namespace haptic
