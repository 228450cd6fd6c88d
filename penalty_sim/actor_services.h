/// Services that act on bodies from outside: ~apply_wrench, ~set_body_pose, ~set_joint_positions, ~set_gravity.
#pragma once
#include <haptic_msgs/ApplyWrench.h>
#include <haptic_msgs/SetBodyPose.h>
#include <haptic_msgs/SetGravity.h>
#include <haptic_msgs/SetJointPositions.h>
#include <ros/node_handle.h>

#include <vector>

#include "haptic_core/loop/command.h"

namespace haptic {

class PortOffer;
class WorldPort;
struct SceneDef;

/// What is asked becomes a command to the thread that steps, carried out between two ticks and recorded. What cannot be done changes
/// nothing and is answered by one line that says why.
class ActorServices {
 public:
  /// Scene, port and offer must outlive it.
  ActorServices(ros::NodeHandle& priv, const SceneDef& scene, WorldPort& port, PortOffer& offer);

 private:
  bool onWrench(haptic_msgs::ApplyWrench::Request& request, haptic_msgs::ApplyWrench::Response& response);
  bool onPose(haptic_msgs::SetBodyPose::Request& request, haptic_msgs::SetBodyPose::Response& response);
  bool onJoints(haptic_msgs::SetJointPositions::Request& request, haptic_msgs::SetJointPositions::Response& response);
  bool onGravity(haptic_msgs::SetGravity::Request& request, haptic_msgs::SetGravity::Response& response);
  /// Answers with what `make` makes of the request, told to the world's runner.
  template <class Response, class Make>
  bool answer(Response& response, Make&& make);

  const SceneDef& scene_;
  WorldPort& port_;
  PortOffer& offer_;
  std::vector<ros::ServiceServer> services_;
};

}  // namespace haptic
