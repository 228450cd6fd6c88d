/// The driver as a node of its own process.
#include <nodelet/loader.h>
#include <ros/ros.h>

#include "spidar_driver/command_gate.h"

int main(int argc, char** argv) {
  haptic::listenOnLoopbackByDefault();
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
