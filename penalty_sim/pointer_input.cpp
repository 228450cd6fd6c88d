#include "penalty_sim/pointer_input.h"

#include <geometry_msgs/WrenchStamped.h>
#include <ros/console.h>

#include <boost/make_shared.hpp>

#include "haptic_core/loop/realtime.h"
#include "haptic_core/world/world.h"
#include "penalty_sim/conversions.h"

namespace haptic {

PointerInput::PointerInput(ros::NodeHandle& nh, const HandPlacement& hand, const std::string& world_frame,
                           double age_limit, const HeardFrames& frames)
    : hand_(hand),
      base_frame_(hand.device + "_base"),
      world_frame_(world_frame),
      age_limit_ns_(static_cast<std::int64_t>(1e9 * age_limit)),
      frames_(frames),
      wrench_(nh.advertise<geometry_msgs::WrenchStamped>(hand.device + "/wrench_command", 1)) {
  subscriber_ = nh.subscribe(hand.device + "/pose", 1, &PointerInput::receive, this, ros::TransportHints().tcpNoDelay());
}

void PointerInput::receive(const geometry_msgs::PoseStamped::ConstPtr& message) {
  Pose X = fromPose(message->pose);
  if (!finite(X)) {
    ROS_WARN_STREAM_THROTTLE(1.0, subscriber_.getTopic() << ": a pose that is not finite was ignored");
    return;
  }
  Target target;
  target.is_grip = message->header.frame_id == base_frame_;
  if (target.is_grip) {
    const WorkspaceSettings& map = hand_.settings.workspace;
    target.X_WP = Pose(map.X_WB.R * X.R, map.X_WB * Vector3(map.scale * X.p));
  } else {
    std::string problem;
    const auto place = frames_.find(world_frame_, message->header.frame_id, &problem);
    if (!place) {
      ROS_WARN_STREAM_THROTTLE(1.0, subscriber_.getTopic() << ": pose ignored, no transform: " << problem);
      return;
    }
    target.X_WP = place->X_WF * X;
  }
  target.received_ns = steadyNow();
  target.given = true;
  // The sender's stamps, not the times of arrival, tell how fast the hand moves.
  const std::int64_t at = clock_.own(static_cast<std::int64_t>(message->header.stamp.toNSec()), target.received_ns);
  const double dt = 1e-9 * static_cast<double>(at - previous_at_);
  const double limit = 1e-9 * static_cast<double>(age_limit_ns_);
  if (previous_.given && previous_.is_grip == target.is_grip && dt > 0 && dt < limit) {
    target.V_WP.linear = (target.X_WP.p - previous_.X_WP.p) / dt;
    target.V_WP.angular = vectorFromRotation(Quaternion(target.X_WP.R * previous_.X_WP.R.transpose())) / dt;
  }
  previous_at_ = at;
  previous_ = target;
  slot_.write(target);
}

bool PointerInput::fresh(std::int64_t now_ns) const noexcept {
  return current_.given && now_ns - current_.received_ns <= age_limit_ns_;
}

void PointerInput::follow(World& world, std::int64_t now_ns) noexcept {
  slot_.read(current_);
  if (!current_.given) return;
  world.setPointerTarget(hand_.pointer, current_.X_WP, fresh(now_ns) ? current_.V_WP : Twist{});
}

void PointerInput::publishWrench(const Wrench& F_W, const ros::Time& stamp) const {
  const auto m = boost::make_shared<geometry_msgs::WrenchStamped>();
  m->header.stamp = stamp;
  m->header.frame_id = current_.is_grip ? base_frame_ : world_frame_;
  const Matrix3 R = current_.is_grip ? Matrix3(hand_.settings.workspace.X_WB.R.transpose()) : Matrix3::Identity();
  m->wrench = toWrench(F_W.rotated(R) * hand_.settings.force_scale);
  wrench_.publish(boost::shared_ptr<const geometry_msgs::WrenchStamped>(m));
}

}  // namespace haptic
