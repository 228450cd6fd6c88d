#include "spidar_driver/driver_parameters.h"

#include <ros/names.h>
#include <ros/package.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

std::string inWords(double value) {
  std::string text = std::to_string(value);
  return text.erase(std::min(text.size(), text.find_last_not_of('0') + 2));
}

/// A number within bounds; roscpp reads integers as doubles too.
double number(const ros::NodeHandle& nh, const std::string& key, double fallback, double low, double high,
              const char* unit) {
  double value = fallback;
  const bool there = nh.hasParam(key);
  if (there && !nh.getParam(key, value)) throw SetupError(nh.resolveName(key), "is not a number", std::string("give it in ") + unit);
  if (!(value >= low && value <= high)) {
    throw SetupError(nh.resolveName(key), "is " + inWords(value),
                     "give " + inWords(low) + " to " + inWords(high) + " " + unit);
  }
  return value;
}

std::string word(const ros::NodeHandle& nh, const std::string& key, const std::string& fallback,
                 const std::vector<std::string>& choices) {
  const std::string value = nh.param<std::string>(key, fallback);
  if (choices.empty() || std::find(choices.begin(), choices.end(), value) != choices.end()) return value;
  std::string known;
  for (const auto& choice : choices) known += (known.empty() ? "" : ", ") + choice;
  throw SetupError(nh.resolveName(key), "is '" + value + "'", "give one of: " + known);
}

bool exists(const std::string& path) { return std::ifstream(path).good(); }

/// Where a jig holds the grip.
GripPose readJigPose(const ros::NodeHandle& priv) {
  if (!priv.hasParam("jig_pose")) return {};
  std::vector<double> v;
  const bool read = priv.getParam("jig_pose", v) && v.size() == 6;
  if (!read || !std::all_of(v.begin(), v.end(), [](double x) { return std::fabs(x) < 10; })) {
    throw SetupError(priv.resolveName("jig_pose"), "is no pose", "give [x, y, z, roll, pitch, yaw] in m and rad");
  }
  const Matrix3 R = (Eigen::AngleAxisd(v[5], Vector3::UnitZ()) * Eigen::AngleAxisd(v[4], Vector3::UnitY()) *
                     Eigen::AngleAxisd(v[3], Vector3::UnitX())).toRotationMatrix();
  return {Pose(R, Vector3(v[0], v[1], v[2])), 0};
}

/// A path as it is; a name among the descriptions that are installed.
std::string findDevice(const std::string& given) {
  if (given.find('/') != std::string::npos || exists(given)) return given;
  const std::string folder = ros::package::getPath("haptic_description") + "/devices/";
  const std::string file = folder + given + (given.find('.') == std::string::npos ? ".yaml" : "");
  if (!exists(file)) throw SetupError("device '" + given + "'", "there is no " + file, "give a path, or a name from " + folder);
  return file;
}

}  // namespace

DriverParameters readParameters(const ros::NodeHandle& ns, const ros::NodeHandle& priv) {
  DriverParameters p;
  p.device_file = findDevice(priv.param<std::string>("device", "spidar_g6x3r"));
  const std::string space = ns.getNamespace();
  p.name = space.substr(space.find_last_of('/') + 1);
  if (p.name.empty()) p.name = "spidar";
  p.twin = word(priv, "transport", "twin", {"twin", "file"}) == "twin";
  p.port = priv.param<std::string>("port", "");
  p.usb_unit = static_cast<int>(number(priv, "usb_unit", -1, -1, 15, "(rotary switch; -1: any)"));
  p.rate = number(priv, "rate", 1000, 100, 20000, "Hz");
  p.alone = priv.param("alone", true);
  const std::string hand = word(priv, "hand", "script", {"script", "marker", "none"});
  p.hand = hand == "script"   ? DriverParameters::Hand::kScript
           : hand == "marker" ? DriverParameters::Hand::kMarker
                              : DriverParameters::Hand::kNone;
  p.script = word(priv, "script", "scene", {"scene", "rest", "press", "touch_cube", "wave"});
  p.calibrate_at_start = priv.param("calibrate_at_start", p.twin);
  p.jig_pose = readJigPose(priv);
  p.calibration_file = priv.param<std::string>("calibration_file", "");
  p.restore_calibration = priv.param("restore_calibration", false);
  p.wave_seconds = number(priv, "wave_seconds", 20, 1, 600, "s");
  p.enable_force = priv.param("enable_force_at_start", p.twin);
  p.command_age_limit = number(priv, "command_age_limit", 0.03, 0.02, 0.05, "s");
  p.pose_rate = number(priv, "pose_rate", 500, 1, 10000, "Hz");
  p.joint_state_rate = number(priv, "joint_state_rate", 100, 1, 1000, "Hz");
  p.frame_rate = number(priv, "frame_rate", 30, 1, 100, "Hz");
  p.world_frame = priv.param<std::string>("world_frame", "world");
  p.place_base = priv.param("place_base", false);
  p.realtime.priority = static_cast<int>(number(priv, "priority", 60, 0, 98, "(SCHED_FIFO; 0: none)"));
  p.realtime.cpu = static_cast<int>(number(priv, "cpu", -1, -1, 1023, "(core; -1: any)"));
  p.realtime.lock_memory = priv.param("lock_memory", true);
  return p;
}

}  // namespace haptic
