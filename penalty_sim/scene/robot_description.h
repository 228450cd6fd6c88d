/// The URDF of a scene's robot as others read it: rviz's RobotModel, MoveIt, robot_state_publisher.
#pragma once
#include <string>

namespace haptic {

/// `text` with `prefix` before the names of links and joints, as the scene has them. The text itself where the prefix is empty.
std::string robotDescription(const std::string& text, const std::string& prefix);

}  // namespace haptic
