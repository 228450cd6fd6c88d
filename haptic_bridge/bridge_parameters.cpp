#include "haptic_bridge/bridge_parameters.h"

#include <haptic_msgs/parameter_reader.h>

#include <cstdlib>

namespace haptic {
namespace {

// A run of fixed length answers within this time when a port does not appear; loading a scene takes less [s].
constexpr double kTimedRunPatience = 4;

/// A word; or the number that dynamic_reconfigure has left there when the nodelet is loaded again (cfg/Loop.cfg).
PassivityMode passivityMode(const ros::NodeHandle& priv, const ParameterReader& read) {
  int number = 0;
  if (priv.getParam("passivity", number)) return static_cast<PassivityMode>(read.whole("passivity", number, 0, 2, "(off, observe, act)"));
  const std::string word = read.word("passivity", "observe", {"off", "observe", "act"});
  return word == "off" ? PassivityMode::kOff : word == "act" ? PassivityMode::kAct : PassivityMode::kObserve;
}

/// Where ROS keeps its logs: what else a fault leaves is there too.
std::string defaultFlightFolder() {
  const char *ros_home = std::getenv("ROS_HOME"), *home = std::getenv("HOME");
  if (ros_home) return std::string(ros_home) + "/flight";
  return home ? std::string(home) + "/.ros/flight" : std::string();
}

}  // namespace

BridgeParameters readBridgeParameters(const ros::NodeHandle& priv) {
  BridgeParameters p;
  const ParameterReader read(priv);
  p.rate = read.number("rate", 1000, 100, 20000, "Hz");
  p.seconds = read.number("seconds", 0, 0, 86400, "s");
  p.figures = read.text("figures", "");
  p.world = read.text("world", "");
  p.devices = read.list<std::string>("devices", "give e.g. [left, right]");
  p.port_timeout = read.number("port_timeout", p.seconds > 0 ? kTimedRunPatience : 0, 0, 3600, "s");
  p.deadline_share = read.number("deadline_share", 0, 0, 1, "of a tick (0: no budget)");
  p.soft_start = read.number("soft_start", 0.5, 0, 10, "s");
  p.passivity = passivityMode(priv, read);
  p.clutch_button = read.whole("clutch_button", -1, -1, 31, "(grip button; -1: none)");
  p.grab_button = read.whole("grab_button", -1, -1, 31, "(grip button; -1: none)");
  p.record = read.flag("record", false);
  p.flight_folder = read.text("flight_folder", defaultFlightFolder());
  p.world_frame = read.text("world_frame", "world");
  p.realtime = read.realtime(60);
  return p;
}

}  // namespace haptic
