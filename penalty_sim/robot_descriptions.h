/// The scene's robots on the parameter server, where rviz and MoveIt look for them.
#pragma once
#include <ros/node_handle.h>

#include <string>
#include <vector>

namespace haptic {

struct SceneDef;

/// Parameters `PREFIXrobot_description`, one for each model of the scene, until this is destroyed. A parameter that someone else has set
/// stays as it is.
class RobotDescriptions {
 public:
  RobotDescriptions(const ros::NodeHandle& node, const SceneDef& scene);
  ~RobotDescriptions();
  RobotDescriptions(const RobotDescriptions&) = delete;
  RobotDescriptions& operator=(const RobotDescriptions&) = delete;

 private:
  ros::NodeHandle node_;
  std::vector<std::string> names_;  ///< that were set here
};

}  // namespace haptic
