/// A hand on a switch, without which no force is on: a button of the grip, or one of a joystick or pedal (sensor_msgs/Joy).
#pragma once
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <sensor_msgs/Joy.h>

#include <memory>

#include "haptic_core/loop/ports.h"
#include "spidar_driver/authority/judged_subscription.h"

namespace haptic {

/// ~dead_man, ~dead_man_button, ~dead_man_age_limit.
struct DeadManParameters {
  enum class Switch { kNone, kGrip, kJoy } kind = Switch::kNone;
  int button = 0;          ///< of the grip, or index in Joy.buttons
  double age_limit = 0.2;  ///< [s] an older message holds nothing: its sender died or hangs
};

/// Listens to topic `dead_man` in a thread of its own, so that no service that is under way keeps a release waiting.
class DeadManSwitch {
 public:
  /// Set-up, before the port is offered. Machines that may not command are not heard.
  DeadManSwitch(ros::NodeHandle& nh, const DeadManParameters& parameters, DevicePort& port);

 private:
  void receive(const sensor_msgs::Joy::ConstPtr& message);

  const DeadManParameters parameters_;
  DevicePort& port_;
  ros::CallbackQueue queue_;
  std::unique_ptr<JudgedSubscription> subscription_;
  std::unique_ptr<ros::AsyncSpinner> spinner_;  // last: no message may arrive before the rest exists, or after it is gone
};

}  // namespace haptic
