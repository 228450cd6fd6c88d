/// The driver as a node of its own process.
#include <nodelet/loader.h>
#include <ros/ros.h>

#include <cstdlib>

#include "haptic_core/base/program_version.h"

int main(int argc, char** argv) {
  if (haptic::toldVersion(argc, argv, "spidar_driver_node")) return 0;
  // Loopback, unless the user has chosen a network; launch files say the same for nodelet managers.
  if (!std::getenv("ROS_HOSTNAME")) ::setenv("ROS_IP", "127.0.0.1", 0);
  ros::init(argc, argv, "driver");
  nodelet::Loader loader(false);
  try {
    if (!loader.load(ros::this_node::getName(), "spidar_driver/DriverNodelet", ros::names::getRemappings(), {})) return 1;
  } catch (const std::exception&) {
    return 1;  // the nodelet has said why
  }
  ros::spin();
  return 0;
}
