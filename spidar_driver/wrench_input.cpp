#include "spidar_driver/wrench_input.h"

#include <ros/console.h>

#include "haptic_core/loop/realtime.h"
#include "spidar_driver/conversions.h"

namespace haptic {

WrenchInput::WrenchInput(ros::NodeHandle& nh, const std::string& base_frame, Gate gate)
    : base_frame_(base_frame), gate_(std::move(gate)), listener_(buffer_, nh) {
  subscriber_ = nh.subscribe("wrench_command", 1, &WrenchInput::receive, this, ros::TransportHints().tcpNoDelay());
}

bool WrenchInput::rotationToBase(const std::string& frame, Matrix3& R_BF, std::string& why) const {
  if (frame.empty()) {
    why = "header.frame_id is empty: name the frame of the wrench's axes, e.g. " + base_frame_;
    return false;
  }
  if (frame == base_frame_ || frame == "/" + base_frame_) {
    R_BF.setIdentity();
    return true;
  }
  try {
    R_BF = fromTransform(buffer_.lookupTransform(base_frame_, frame, ros::Time(0)).transform).R;
  } catch (const tf2::TransformException& error) {
    why = std::string("no transform: ") + error.what();
    return false;
  }
  return true;
}

void WrenchInput::refuse(const std::string& why) {
  ++refused_;
  ROS_WARN_STREAM_THROTTLE(1.0, subscriber_.getTopic() << " refused: " << why);
}

void WrenchInput::receive(const geometry_msgs::WrenchStamped::ConstPtr& message) {
  std::string why = gate_();
  Matrix3 R_BF;
  const Wrench F_G_F = fromWrench(message->wrench);
  if (why.empty() && !F_G_F.allFinite()) why = "a component is not finite";
  if (!why.empty() || !rotationToBase(message->header.frame_id, R_BF, why)) return refuse(why);
  slot_.write({F_G_F.rotated(R_BF), steadyNow(), true});
}

}  // namespace haptic
