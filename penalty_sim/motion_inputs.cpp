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
  frames_ = std::make_unique<HeardFrames>(nh, true);
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
  if (looks) timer_ = nh.createSteadyTimer(ros::WallDuration(kLookAtFrames), [this](const ros::SteadyTimerEvent&) { look(); });
}

void MotionInputs::receive(Input& input, const geometry_msgs::PoseStamped::ConstPtr& message) {
  Pose X_WF = fromPose(message->pose);
  const std::string& frame = message->header.frame_id;
  if (!finite(X_WF)) {
    ROS_WARN_STREAM_THROTTLE(1.0, input.subscriber.getTopic() << ": a pose that is not finite was ignored");
    return;
  }
  if (!frame.empty() && frame != world_frame_) {
    std::string problem;
    const auto place = frames_->find(world_frame_, frame, &problem);
    if (!place) {
      ROS_WARN_STREAM_THROTTLE(1.0, input.subscriber.getTopic() << ": pose ignored, no transform: " << problem);
      return;
    }
    X_WF = place->X_WF * X_WF;
  }
  take(input, X_WF, input.clock.own(static_cast<std::int64_t>(message->header.stamp.toNSec()), steadyNow()));
}

void MotionInputs::look() {
  std::string problem;
  for (const auto& input : inputs_) {
    if (input->frame.empty()) continue;
    const std::string line = input->silence.look(*frames_, world_frame_, input->frame);
    if (!line.empty()) ROS_WARN_STREAM("motion of " << input->name << ": " << line);
    // Where there is none it has not come yet: the body stands.
    if (const auto place = frames_->find(world_frame_, input->frame, &problem)) take(*input, place->X_WF, place->at);
  }
}

void MotionInputs::take(Input& input, const Pose& X_WF, std::int64_t at) {
  const Pose X_WL = X_WF * input.X_FL;
  const double since = 1e-9 * static_cast<double>(at - input.at);
  if (since < port_.world.settings().step) return;  // the latest again; and two poses within a step tell no speed
  LeadBody lead;
  lead.motion = input.motion;
  lead.to.p_WL = X_WL.p;
  lead.to.q_WL = Quaternion(X_WL.R).normalized();
  lead.seconds = kFirstWay;
  if (input.at != 0 && since < kLongestGap) {
    lead.to.V_WL.linear = (X_WL.p - input.X_WL.p) / since;
    lead.to.V_WL.angular = vectorFromRotation(Quaternion(Matrix3(X_WL.R * input.X_WL.R.transpose())).normalized()) / since;
    lead.seconds = since;
  }
  input.X_WL = X_WL;
  input.at = at;
  const LoopCommand command{lead};
  try {
    if (offer_.send(port_, WorldPort::Change{{&command}, nullptr})) return;
    ROS_WARN_STREAM_THROTTLE(1.0, "motion of " << input.name << ": nobody steps the world; ignored");
  } catch (const SetupError& error) {
    ROS_WARN_STREAM_THROTTLE(1.0, "motion of " << input.name << ": ignored: " << error.what());
  }
}

}  // namespace haptic
