/// `~joint_command`: positions, velocities or efforts for the joints' drives.
#pragma once
#include <ros/node_handle.h>
#include <sensor_msgs/JointState.h>

#include <string>

namespace haptic {

class PortOffer;
class World;
class WorldPort;

/// Takes sensor_msgs/JointState: `name`, and of `position`, `velocity`, `effort` each empty or as long. With
/// positions the drive holds them (velocity and effort feed forward); with velocities alone it holds those;
/// with efforts alone it gives those; within the joint's limits. Joints that are not named keep what they
/// were told. A message is taken as a whole or, with one warning that says why, not at all: a joint that does
/// not exist or has no drive, lengths that differ, a number that is not finite.
class JointCommands {
 public:
  /// Port and offer must outlive it.
  JointCommands(ros::NodeHandle& priv, WorldPort& port, PortOffer& offer);

 private:
  void receive(const sensor_msgs::JointState::ConstPtr& message);
  std::string problemOf(const sensor_msgs::JointState& message) const;

  WorldPort& port_;
  World& world_;
  PortOffer& offer_;
  ros::Subscriber subscriber_;
};

}  // namespace haptic
