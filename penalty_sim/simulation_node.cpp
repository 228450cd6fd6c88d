/// The simulation as a node of its own process.
#include <nodelet/loader.h>
#include <ros/ros.h>

#include "haptic_core/base/program_version.h"

int main(int argc, char** argv) {
  if (haptic::toldVersion(argc, argv, "penalty_sim_node")) return 0;
  ros::init(argc, argv, "simulation");
  nodelet::Loader loader(false);
  try {
    if (!loader.load(ros::this_node::getName(), "penalty_sim/SimulationNodelet", ros::names::getRemappings(), {})) return 1;
  } catch (const std::exception&) {
    return 1;  // the nodelet has said why
  }
  ros::spin();
  return 0;
}
