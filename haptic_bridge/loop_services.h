/// What a user may change while the loop runs: the clutch, and the parameters of cfg/Loop.cfg.
#pragma once
#include <dynamic_reconfigure/server.h>
#include <haptic_bridge/LoopConfig.h>
#include <haptic_msgs/Clutch.h>
#include <ros/node_handle.h>

#include <boost/thread/recursive_mutex.hpp>
#include <string>
#include <vector>

#include "haptic_bridge/realtime_thread.h"

namespace haptic {

/// Services run in the nodelet's callback threads; what they change is changed between two ticks.
class LoopServices {
 public:
  LoopServices(ros::NodeHandle& priv, const std::string& name, const BridgeParameters& parameters, RealtimeThread& loop);
  ~LoopServices();
  void reapply();  ///< another start of the loop: what the user had set holds on

 private:
  bool onClutch(haptic_msgs::Clutch::Request& request, haptic_msgs::Clutch::Response& response);
  void onParameters(haptic_bridge::LoopConfig& config, std::uint32_t level);
  bool apply(const haptic_bridge::LoopConfig& config);
  static std::vector<LoopCommand> commandsFor(const haptic_bridge::LoopConfig& config, const LoopSession::View& view);

  std::string name_;
  RealtimeThread& loop_;
  haptic_bridge::LoopConfig applied_;
  bool started_ = false;               ///< the server's first call is no wish of a user
  boost::recursive_mutex mutex_;       ///< the server's
  dynamic_reconfigure::Server<haptic_bridge::LoopConfig> server_;
  ros::ServiceServer clutch_;
};

}  // namespace haptic
