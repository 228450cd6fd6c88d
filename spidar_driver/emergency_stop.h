/// STOP of a device by every way that there is: `~stop`, a socket that needs no master, SIGUSR1.
#pragma once
#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>

#include <memory>
#include <string>

#include "haptic_core/loop/ports.h"
#include "haptic_core/loop/stop_channel.h"

namespace haptic {

/// Whoever says STOP is heard, from wherever: it only takes current away. The answer says so once every
/// board has answered a drive without current.
class EmergencyStop {
 public:
  EmergencyStop(ros::NodeHandle& priv, const std::string& device, DevicePort& port, PortOffer& offer);

  /// Path of the socket; empty: there is none, which was logged.
  std::string socket() const { return listener_ ? listener_->path() : std::string(); }

 private:
  StopAnswer stop();
  bool answered();
  bool onStop(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  std::string device_;
  DevicePort& port_;
  PortOffer& offer_;
  std::unique_ptr<StopListener> listener_;
  ros::ServiceServer service_;
};

}  // namespace haptic
