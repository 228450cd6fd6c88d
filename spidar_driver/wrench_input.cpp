#include "spidar_driver/wrench_input.h"

#include <ros/console.h>

#include <cmath>

#include "haptic_core/loop/realtime.h"
#include "spidar_driver/conversions.h"

namespace haptic {

WrenchInput::WrenchInput(ros::NodeHandle& nh, const std::string& base_frame, bool takes_grasp, Gate gate)
    : base_frame_(base_frame),
      wrench_topic_(nh.resolveName("wrench_command")),
      grasp_topic_(nh.resolveName("grasp_command")),
      gate_(std::move(gate)),
      frames_(nh, true) {
  taken_ = nh.advertise<geometry_msgs::WrenchStamped>("recorded/wrench_command", 10);
  wrench_command_ = subscribeJudged(nh, "wrench_command", 1, &WrenchInput::receive, this);
  if (takes_grasp) grasp_command_ = subscribeJudged(nh, "grasp_command", 1, &WrenchInput::receiveGrasp, this);
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
  std::string problem;
  const auto place = frames_.find(base_frame_, frame, &problem);
  if (place) R_BF = place->X_WF.R;
  if (!place) why = "no transform: " + problem;
  return place.has_value();
}

void WrenchInput::refuse(const std::string& topic, const std::string& why) {
  ++refused_;
  ROS_WARN_STREAM_THROTTLE(1.0, topic << " refused: " << why);
}

void WrenchInput::receiveGrasp(const std_msgs::Float64::ConstPtr& message) {
  std::string why = gate_();
  if (why.empty() && !std::isfinite(message->data)) why = "it is not finite";
  if (!why.empty()) return refuse(grasp_topic_, why);
  grasp_slot_.write({message->data, steadyNow()});
}

void WrenchInput::receive(const geometry_msgs::WrenchStamped::ConstPtr& message) {
  std::string why = gate_();
  Matrix3 R_BF;
  const Wrench F_G_F = fromWrench(message->wrench);
  if (why.empty() && !F_G_F.allFinite()) why = "a component is not finite";
  if (!why.empty() || !rotationToBase(message->header.frame_id, R_BF, why)) return refuse(wrench_topic_, why);
  slot_.write({F_G_F.rotated(R_BF), steadyNow(), true});
  if (taken_.getNumSubscribers() > 0) taken_.publish(message);
}

}  // namespace haptic
