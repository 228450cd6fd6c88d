#include "spidar_driver/emergency_stop.h"

#include <ros/console.h>

#include "haptic_core/base/error.h"
#include "spidar_driver/authority/process_door.h"

namespace haptic {
namespace {

// Ten ticks of the slowest rate. A loop that takes nothing for so long has lost its current to the motor guard by then.
constexpr std::chrono::milliseconds kStopPatience{100};

}  // namespace

EmergencyStop::EmergencyStop(ros::NodeHandle& priv, const std::string& device, DevicePort& port, PortOffer& offer)
    : device_(device), port_(port), offer_(offer) {
  try {
    listener_ = std::make_unique<StopListener>(device, [this] { return stop(); });
  } catch (const SetupError& error) {
    ROS_ERROR_STREAM(device << ": STOP works through the master alone: " << error.what());
  }
  ProcessDoor::ofProcess().openToAll(priv.resolveName("stop"));
  service_ = priv.advertiseService("stop", &EmergencyStop::onStop, this);
}

StopAnswer EmergencyStop::stop() {
  const LoopCommand command{StopDevice{}};
  DeviceCopy after;
  // The copy is made after the exchange that follows the command: with it the boards were told zero.
  const bool done = offer_.send(port_, Tell{&command}, kStopPatience) && offer_.send(port_, DevicePort::Copy{&after}, kStopPatience);
  if (!done) return {false, device_ + ": its loop stands still: cut the power of its motors"};
  ROS_WARN_STREAM(device_ << ": STOP, the motors are off");
  return {true, device_ + ": STOP, the motors are off; recover gives tension, enable_force gives force"};
}

bool EmergencyStop::onStop(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  const StopAnswer answer = stop();
  response.success = answer.off;
  response.message = answer.message;
  return true;
}

}  // namespace haptic
