#include "spidar_driver/driver_parameters.h"

#include <haptic_msgs/parameter_reader.h>
#include <ros/console.h>
#include <ros/names.h>
#include <ros/package.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "spidar_driver/authority/commanders.h"

namespace haptic {
namespace {

bool exists(const std::string& path) { return std::ifstream(path).good(); }

/// Where a jig holds the grip.
GripPose readJigPose(const ros::NodeHandle& priv) {
  if (!priv.hasParam("jig_pose")) return {};
  std::vector<double> v;
  const bool read = priv.getParam("jig_pose", v) && v.size() == 6;
  if (!read || !std::all_of(v.begin(), v.end(), [](double x) { return std::fabs(x) < 10; })) {
    throw SetupError(priv.resolveName("jig_pose"), "is no pose", "give [x, y, z, roll, pitch, yaw] in m and rad");
  }
  return {Pose(rotationFromRpy(Vector3(v[3], v[4], v[5])), Vector3(v[0], v[1], v[2])), 0};
}

/// The parameter server is open to everyone who reaches it, so it gives nobody permission.
void refuseAddresses(const ros::NodeHandle& priv) {
  if (!priv.hasParam("allowed_addresses")) return;
  ROS_WARN_STREAM(priv.resolveName("allowed_addresses") << " is not heard: write the addresses into " << Commanders::kFile
                                                        << ", one a line");
}

DeadManParameters readDeadMan(const ParameterReader& read) {
  using Switch = DeadManParameters::Switch;
  DeadManParameters p;
  const std::string word = read.word("dead_man", "none", {"none", "joy", "grip"});
  p.kind = word == "joy" ? Switch::kJoy : word == "grip" ? Switch::kGrip : Switch::kNone;
  p.button = read.whole("dead_man_button", 0, 0, 31, "(index of the button)");
  p.age_limit = read.number("dead_man_age_limit", 0.2, 0.05, 1, "s");
  return p;
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
  const ParameterReader read(priv);
  p.device_file = findDevice(read.text("device", "spidar_g6x3r"));
  const std::string space = ns.getNamespace();
  p.name = space.substr(space.find_last_of('/') + 1);
  if (p.name.empty()) p.name = "spidar";
  p.twin = read.word("transport", "twin", {"twin", "file"}) == "twin";
  p.port = read.text("port", "");
  p.usb_unit = read.whole("usb_unit", -1, -1, 15, "(rotary switch; -1: any)");
  p.rate = read.number("rate", 1000, 100, 20000, "Hz");
  p.alone = read.flag("alone", true);
  const std::string hand = read.word("hand", "script", {"script", "marker", "none"});
  p.hand = hand == "script"   ? DriverParameters::Hand::kScript
           : hand == "marker" ? DriverParameters::Hand::kMarker
                              : DriverParameters::Hand::kNone;
  p.script = read.word("script", "scene", {"scene", "rest", "press", "touch_cube", "wave"});
  p.calibrate_at_start = read.flag("calibrate_at_start", p.twin);
  p.jig_pose = readJigPose(priv);
  p.calibration_file = read.text("calibration_file", "");
  p.restore_calibration = read.flag("restore_calibration", false);
  p.wave_seconds = read.number("wave_seconds", 20, 1, 600, "s");
  p.enable_force = read.flag("enable_force_at_start", p.twin);
  p.command_age_limit = read.number("command_age_limit", 0.03, 0.02, 0.05, "s");
  p.pose_rate = read.number("pose_rate", 500, 1, 10000, "Hz");
  p.joint_state_rate = read.number("joint_state_rate", 100, 1, 1000, "Hz");
  p.frame_rate = read.number("frame_rate", 30, 1, 100, "Hz");
  p.world_frame = read.text("world_frame", "world");
  p.place_base = read.flag("place_base", false);
  refuseAddresses(priv);
  p.dead_man = readDeadMan(read);
  p.end_with_parent = read.flag("end_with_parent", false);
  p.realtime = read.realtime(60);
  return p;
}

}  // namespace haptic
