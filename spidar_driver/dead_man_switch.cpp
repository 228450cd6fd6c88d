#include "spidar_driver/dead_man_switch.h"

#include "haptic_core/loop/realtime.h"

namespace haptic {

DeadManSwitch::DeadManSwitch(ros::NodeHandle& nh, const DeadManParameters& parameters, DevicePort& port)
    : parameters_(parameters), port_(port) {
  using Switch = DeadManParameters::Switch;
  port.dead_man.used = parameters.kind != Switch::kNone;
  if (parameters.kind == Switch::kGrip) port.dead_man.button = parameters.button;
  if (parameters.kind != Switch::kJoy) return;
  ros::NodeHandle own(nh);
  own.setCallbackQueue(&queue_);
  subscription_ = subscribeJudged(own, "dead_man", 1, &DeadManSwitch::receive, this);
  spinner_ = std::make_unique<ros::AsyncSpinner>(1, &queue_);
  spinner_->start();
}

void DeadManSwitch::receive(const sensor_msgs::Joy::ConstPtr& message) {
  const auto button = static_cast<std::size_t>(parameters_.button);
  const bool held = button < message->buttons.size() && message->buttons[button] != 0;
  // By the steady clock from the receipt: the stamps of another machine say nothing about whether a hand is there now.
  const auto age_limit = static_cast<std::int64_t>(1e9 * parameters_.age_limit);
  port_.dead_man.held_until_ns.store(held ? steadyNow() + age_limit : 0, std::memory_order_relaxed);
}

}  // namespace haptic
