#include "spidar_driver/emergency_stop.h"

#include <ros/console.h>

#include "haptic_core/base/error.h"
#include "spidar_driver/authority/process_door.h"

namespace haptic {
namespace {

// Ten ticks of the slowest rate. A loop that takes nothing for so long has lost its current to the motor guard by then.
constexpr std::chrono::milliseconds kStopPatience{100};
// A line that is being brought into step takes 0.2 s until its boards answer.
constexpr std::chrono::milliseconds kAnswerPatience{500};

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
  if (!offer_.send(port_, Tell{&command}, kStopPatience)) return {false, device_ + ": its loop stands still: cut the power of its motors"};
  if (!answered())
    return {false, device_ + ": the motors are told to be off, but not every board has answered: cut the power of its motors"};
  ROS_WARN_STREAM(device_ << ": STOP, the motors are off");
  return {true, device_ + ": STOP, the motors are off; recover gives tension, enable_force gives force"};
}

/// Every board has answered a drive without current. Without a runner there is none to answer: who ran it last told zero.
bool EmergencyStop::answered() {
  const auto deadline = std::chrono::steady_clock::now() + kAnswerPatience;
  DeviceCopy now;
  while (std::chrono::steady_clock::now() < deadline) {
    if (!offer_.send(port_, DevicePort::Copy{&now}, kStopPatience)) return false;
    if (now.record.currentless || offer_.holder().empty()) return true;
  }
  return false;
}

bool EmergencyStop::onStop(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  const StopAnswer answer = stop();
  response.success = answer.off;
  response.message = answer.message;
  return true;
}

}  // namespace haptic
