/// What a user may change while the loop runs: the clutch, and the parameters of cfg/Loop.cfg.
#pragma once
#include <haptic_msgs/Clutch.h>
#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "haptic_bridge/loop_parameters.h"
#include "haptic_bridge/realtime_thread.h"

namespace haptic {

/// Services run in the nodelet's callback threads; what they change is changed between two ticks.
class LoopServices {
 public:
  LoopServices(ros::NodeHandle& priv, const std::string& name, const BridgeParameters& parameters, RealtimeThread& loop);
  ~LoopServices();
  void reapply() { parameters_.reapply(); }  ///< another start of the loop: what the user had set holds on

 private:
  bool onClutch(haptic_msgs::Clutch::Request& request, haptic_msgs::Clutch::Response& response);
  bool apply(const haptic_bridge::LoopConfig& config);
  static std::vector<LoopCommand> commandsFor(const haptic_bridge::LoopConfig& config, const LoopSession::View& view);

  RealtimeThread& loop_;
  LoopParameters parameters_;
  ros::ServiceServer clutch_;
};

}  // namespace haptic
