#include "haptic_bridge/bridge_parameters.h"

#include <cstdlib>
#include <sstream>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

// A run of fixed length answers within this time when a port does not appear; loading a scene takes less [s].
constexpr double kTimedRunPatience = 4;

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

PassivityMode passivityMode(const ros::NodeHandle& nh) {
  const std::string word = nh.param<std::string>("passivity", "observe");
  if (word == "off") return PassivityMode::kOff;
  if (word == "observe") return PassivityMode::kObserve;
  if (word == "act") return PassivityMode::kAct;
  throw SetupError(nh.resolveName("passivity"), "is '" + word + "'", "give one of: off, observe, act");
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
  p.rate = number(priv, "rate", 1000, 100, 20000, "Hz");
  p.seconds = number(priv, "seconds", 0, 0, 86400, "s");
  p.figures = priv.param<std::string>("figures", "");
  p.world = priv.param<std::string>("world", "");
  if (priv.hasParam("devices") && !priv.getParam("devices", p.devices)) {
    throw SetupError(priv.resolveName("devices"), "is no list of names", "give e.g. [left, right]");
  }
  p.port_timeout = number(priv, "port_timeout", p.seconds > 0 ? kTimedRunPatience : 0, 0, 3600, "s");
  p.soft_start = number(priv, "soft_start", 0.5, 0, 10, "s");
  p.passivity = passivityMode(priv);
  p.clutch_button = static_cast<int>(number(priv, "clutch_button", -1, -1, 31, "(grip button; -1: none)"));
  p.grab_button = static_cast<int>(number(priv, "grab_button", -1, -1, 31, "(grip button; -1: none)"));
  p.record = priv.param("record", false);
  p.flight_folder = priv.param<std::string>("flight_folder", defaultFlightFolder());
  p.world_frame = priv.param<std::string>("world_frame", "world");
  p.realtime.priority = static_cast<int>(number(priv, "priority", 60, 0, 98, "(SCHED_FIFO; 0: none)"));
  p.realtime.cpu = static_cast<int>(number(priv, "cpu", -1, -1, 1023, "(core; -1: any)"));
  p.realtime.lock_memory = priv.param("lock_memory", true);
  return p;
}

}  // namespace haptic
