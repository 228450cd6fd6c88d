#include "penalty_sim/motion_inputs.h"

#include <haptic_msgs/conversions.h>
#include <ros/console.h>

#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/ports.h"
#include "scene/scene_file.h"

namespace haptic {
namespace {

/// How often tf is looked at [s]: a frame that moves faster than this is followed by every look.
constexpr double kLookAtFrames = 0.01;
/// Poses farther apart are no motion; the first one, and the next after a pause, is gone to in kFirstWay [s].
constexpr double kLongestGap = 0.5, kFirstWay = 0.1;

}  // namespace

MotionInputs::MotionInputs(ros::NodeHandle& nh, const SceneDef& scene, const std::string& world_frame, WorldPort& port, PortOffer& offer)
    : world_frame_(world_frame), port_(port), offer_(offer) {
  if (scene.told_motions.empty()) return;
  listener_ = std::make_unique<tf2_ros::TransformListener>(buffer_, nh);
  bool looks = false;
  for (const ToldMotion& told : scene.told_motions) {
    inputs_.push_back(std::make_unique<Input>());
    Input* input = inputs_.back().get();
    input->motion = told.motion;
    input->name = scene.world.motions[static_cast<std::size_t>(told.motion)].name;
    input->frame = told.frame;
    input->X_FL = told.X_FL;
    looks |= !told.frame.empty();
    if (told.topic.empty()) continue;
    input->subscriber = nh.subscribe<geometry_msgs::PoseStamped>(
        told.topic, 1, [this, input](const geometry_msgs::PoseStamped::ConstPtr& message) { receive(*input, message); },
        ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  }
  if (looks) timer_ = nh.createTimer(ros::Duration(kLookAtFrames), [this](const ros::TimerEvent&) { look(); });
}

void MotionInputs::receive(Input& input, const geometry_msgs::PoseStamped::ConstPtr& message) {
  Pose X_WF = fromPose(message->pose);
  const std::string& frame = message->header.frame_id;
  if (!finite(X_WF)) {
    ROS_WARN_STREAM_THROTTLE(1.0, input.subscriber.getTopic() << ": a pose that is not finite was ignored");
    return;
  }
  if (!frame.empty() && frame != world_frame_) {
    try {
      X_WF = fromTransform(buffer_.lookupTransform(world_frame_, frame, ros::Time(0)).transform) * X_WF;
    } catch (const tf2::TransformException& error) {
      ROS_WARN_STREAM_THROTTLE(1.0, input.subscriber.getTopic() << ": pose ignored, no transform: " << error.what());
      return;
    }
  }
  take(input, X_WF, message->header.stamp.isZero() ? ros::Time::now() : message->header.stamp);
}

void MotionInputs::look() {
  for (const auto& input : inputs_) {
    if (input->frame.empty()) continue;
    try {
      const auto transform = buffer_.lookupTransform(world_frame_, input->frame, ros::Time(0));
      take(*input, fromTransform(transform.transform), transform.header.stamp);
    } catch (const tf2::TransformException&) {
      continue;  // it has not come yet, or comes no more: the body stands
    }
  }
}

void MotionInputs::take(Input& input, const Pose& X_WF, const ros::Time& stamp) {
  const Pose X_WL = X_WF * input.X_FL;
  if (stamp == input.stamp) return;  // tf's latest again
  // Not as a ros::Duration, which throws beyond 68 years. A stamp that goes back begins anew: time was reset, or a bag starts again.
  const double gone = 1e-9 * (static_cast<double>(stamp.toNSec()) - static_cast<double>(input.stamp.toNSec()));
  const double since = input.stamp.isZero() || gone < 0 ? kLongestGap : gone;
  if (since < port_.world.settings().step) return;  // two poses within a step tell no speed
  LeadBody lead;
  lead.motion = input.motion;
  lead.to.p_WL = X_WL.p;
  lead.to.q_WL = Quaternion(X_WL.R).normalized();
  lead.seconds = kFirstWay;
  if (since < kLongestGap) {
    lead.to.V_WL.linear = (X_WL.p - input.X_WL.p) / since;
    lead.to.V_WL.angular = vectorFromRotation(Quaternion(Matrix3(X_WL.R * input.X_WL.R.transpose())).normalized()) / since;
    lead.seconds = since;
  }
  input.X_WL = X_WL;
  input.stamp = stamp;
  const LoopCommand command{lead};
  try {
    if (offer_.send(port_, WorldPort::Change{{&command}, nullptr})) return;
    ROS_WARN_STREAM_THROTTLE(1.0, "motion of " << input.name << ": nobody steps the world; ignored");
  } catch (const SetupError& error) {
    ROS_WARN_STREAM_THROTTLE(1.0, "motion of " << input.name << ": ignored: " << error.what());
  }
}

}  // namespace haptic
