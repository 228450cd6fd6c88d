#include "penalty_sim/simulation_parameters.h"

#include <sstream>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

/// A number within bounds; roscpp reads integers as doubles too.
double number(const ros::NodeHandle& nh, const std::string& key, double fallback, double low, double high,
              const char* unit) {
  double value = fallback;
  std::ostringstream bounds;
  bounds << "give " << low << " to " << high << " " << unit;
  if (nh.hasParam(key) && !nh.getParam(key, value)) throw SetupError(nh.resolveName(key), "is not a number", bounds.str());
  if (!(value >= low && value <= high)) {
    std::ostringstream is;
    is << "is " << value;
    throw SetupError(nh.resolveName(key), is.str(), bounds.str());
  }
  return value;
}

}  // namespace

SimulationParameters readSimulationParameters(const std::string& node, const ros::NodeHandle& priv) {
  SimulationParameters p;
  p.scene = priv.param<std::string>("scene", "touch_cube");
  p.name = node.substr(node.find_last_of('/') + 1);
  p.rate = number(priv, "rate", 0, 0, 20000, "Hz (0: the scene's step)");
  p.alone = priv.param("alone", true);
  p.world_frame = priv.param<std::string>("world_frame", "world");
  p.frame_rate = number(priv, "frame_rate", 30, 1, 100, "Hz");
  p.joint_rate = number(priv, "joint_rate", 100, 1, 1000, "Hz");
  p.pose_age_limit = number(priv, "pose_age_limit", 0.1, 0.005, 1, "s");
  p.wrench_rate = number(priv, "wrench_rate", 500, 1, 10000, "Hz");
  p.default_density = number(priv, "default_density", 0, 0, 30000, "kg/m³");
  p.realtime.priority = static_cast<int>(number(priv, "priority", 50, 0, 98, "(SCHED_FIFO; 0: none)"));
  p.realtime.cpu = static_cast<int>(number(priv, "cpu", -1, -1, 1023, "(core; -1: any)"));
  p.realtime.lock_memory = priv.param("lock_memory", true);
  return p;
}

}  // namespace haptic
