#include "penalty_sim/joint_commands.h"

#include <ros/console.h>

#include <cmath>
#include <vector>

#include "haptic_core/loop/ports.h"

namespace haptic {
namespace {

JointCommand commandAt(const sensor_msgs::JointState& m, std::size_t i) {
  JointCommand command;
  command.drive = !m.position.empty()   ? JointDef::Drive::kPosition
                  : !m.velocity.empty() ? JointDef::Drive::kVelocity
                                        : JointDef::Drive::kEffort;
  if (!m.position.empty()) command.position = m.position[i];
  if (!m.velocity.empty()) command.velocity = m.velocity[i];
  if (!m.effort.empty()) command.effort = m.effort[i];
  return command;
}

}  // namespace

JointCommands::JointCommands(ros::NodeHandle& priv, WorldPort& port, PortOffer& offer)
    : port_(port), world_(port.world), offer_(offer) {
  subscriber_ = priv.subscribe("joint_command", 1, &JointCommands::receive, this, ros::TransportHints().tcpNoDelay());
}

std::string JointCommands::problemOf(const sensor_msgs::JointState& m) const {
  const std::size_t n = m.name.size();
  if (n == 0) return "it names no joint";
  for (const auto* numbers : {&m.position, &m.velocity, &m.effort}) {
    if (!numbers->empty() && numbers->size() != n)
      return "position, velocity and effort must be empty or as long as name";
  }
  if (m.position.empty() && m.velocity.empty() && m.effort.empty())
    return "it has no position, velocity or effort";
  for (std::size_t i = 0; i < n; ++i) {
    const int joint = world_.jointIndex(m.name[i]);
    if (joint < 0) return "there is no joint '" + m.name[i] + "'";
    if (!world_.obeysCommands(joint))
      return "joint '" + m.name[i] + "' has no drive: give it an effort limit or gains";
    for (const auto* numbers : {&m.position, &m.velocity, &m.effort}) {
      if (!numbers->empty() && !std::isfinite((*numbers)[i]))
        return "a number for joint '" + m.name[i] + "' is not finite";
    }
  }
  return {};
}

void JointCommands::receive(const sensor_msgs::JointState::ConstPtr& message) {
  const std::string problem = problemOf(*message);
  if (!problem.empty()) {
    ROS_WARN_STREAM_THROTTLE(1.0, subscriber_.getTopic() << ": ignored: " << problem);
    return;
  }
  std::vector<LoopCommand> commands;
  for (std::size_t i = 0; i < message->name.size(); ++i) {
    commands.push_back({DriveJoint{world_.jointIndex(message->name[i]), commandAt(*message, i)}});
  }
  const bool taken = offer_.send(port_, WorldPort::Change{{commands.data(), commands.size()}, nullptr});
  if (!taken) ROS_WARN_STREAM_THROTTLE(1.0, subscriber_.getTopic() << ": nobody steps the world; ignored");
}

}  // namespace haptic
