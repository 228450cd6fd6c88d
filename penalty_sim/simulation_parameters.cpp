#include "penalty_sim/simulation_parameters.h"

#include <haptic_msgs/parameter_reader.h>

namespace haptic {

SimulationParameters readSimulationParameters(const std::string& node, const ros::NodeHandle& priv) {
  SimulationParameters p;
  const ParameterReader read(priv);
  p.scene = read.text("scene", "touch_cube");
  p.name = node.substr(node.find_last_of('/') + 1);
  p.rate = read.number("rate", 0, 0, 20000, "Hz (0: the scene's step)");
  p.alone = read.flag("alone", true);
  p.world_frame = read.text("world_frame", "world");
  p.frame_rate = read.number("frame_rate", 30, 1, 100, "Hz");
  p.joint_rate = read.number("joint_rate", 100, 1, 1000, "Hz");
  p.pose_age_limit = read.number("pose_age_limit", 0.1, 0.005, 1, "s");
  p.wrench_rate = read.number("wrench_rate", 500, 1, 10000, "Hz");
  p.default_density = read.number("default_density", 0, 0, 30000, "kg/m³");
  p.missing_meshes = read.text("missing_meshes", "stop");
  p.xacro = read.text("xacro", "");
  p.realtime = read.realtime(50);
  return p;
}

}  // namespace haptic
