/// Steps the world in the simulation's own thread while nobody of higher rank holds its port.
#pragma once
#include <haptic_msgs/heard_frames.h>
#include <ros/node_handle.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "haptic_core/loop/ports.h"
#include "penalty_sim/pointer_input.h"
#include "penalty_sim/simulation_parameters.h"

namespace haptic {

class WorldThread {
 public:
  WorldThread(ros::NodeHandle& nh, const SimulationParameters& parameters, const std::vector<HandPlacement>& hands);
  ~WorldThread();

 private:
  void run();
  void runWorld(PortLease<WorldPort>& lease);
  void publishWrenches(const World& world);

  SimulationParameters parameters_;
  std::vector<HandPlacement> hands_;
  HeardFrames frames_;
  std::vector<std::unique_ptr<PointerInput>> inputs_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace haptic
