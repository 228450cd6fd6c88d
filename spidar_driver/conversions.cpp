#include "spidar_driver/conversions.h"

namespace haptic {

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
      m.state = m.FAULT;
      break;
  }
  if (record.link_lost) m.state = m.DISCONNECTED;
  m.message = standing(record, def.name);
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
  m.wire_delay = record.delay;
  m.counts_age = record.counts_age;
  m.lost_share = record.lost_share;
  m.stable_stiffness = record.stable_stiffness;
  return m;
}

}  // namespace haptic
