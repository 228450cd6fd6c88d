#include "penalty_sim/robot_descriptions.h"

#include "scene/robot_description.h"
#include "scene/scene_file.h"

namespace haptic {

RobotDescriptions::RobotDescriptions(const ros::NodeHandle& node, const SceneDef& scene) : node_(node) {
  for (const auto& [prefix, text] : scene.descriptions) {
    const std::string name = prefix + "robot_description";
    if (node_.hasParam(name)) continue;
    node_.setParam(name, robotDescription(text, prefix));
    names_.push_back(name);
  }
}

RobotDescriptions::~RobotDescriptions() {
  for (const std::string& name : names_) node_.deleteParam(name);
}

}  // namespace haptic
