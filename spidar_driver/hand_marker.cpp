#include "spidar_driver/hand_marker.h"

#include <ros/console.h>

#include "spidar_driver/conversions.h"

namespace haptic {
namespace {

visualization_msgs::InteractiveMarkerControl control(const char* name, const Vector3& axis, int mode) {
  visualization_msgs::InteractiveMarkerControl c;
  c.name = name;
  c.interaction_mode = static_cast<std::uint8_t>(mode);
  // rviz takes the control's x axis as the one to move along or turn about.
  const Quaternion q = shortestTurn(Vector3::UnitX(), axis);
  c.orientation = toQuaternion(q.toRotationMatrix());
  return c;
}

}  // namespace

HandMarker::HandMarker(ros::NodeHandle& nh, const std::string& base_frame, double radius, Move move)
    : base_frame_(base_frame), move_(std::move(move)), server_(nh.resolveName("hand")) {
  using Control = visualization_msgs::InteractiveMarkerControl;
  visualization_msgs::InteractiveMarker marker;
  marker.header.frame_id = base_frame_;
  marker.name = "hand";
  marker.description = "hand of the simulated device";
  marker.pose.orientation.w = 1;
  marker.scale = static_cast<float>(4 * radius);
  visualization_msgs::Marker ball;
  ball.type = visualization_msgs::Marker::SPHERE;
  ball.scale.x = ball.scale.y = ball.scale.z = 2.2 * radius;
  ball.color.g = ball.color.b = 0.6f;
  ball.color.a = 0.5f;
  Control grab = control("move", Vector3::UnitX(), Control::MOVE_3D);
  grab.always_visible = true;
  grab.markers.push_back(ball);
  marker.controls.push_back(grab);
  const struct {
    const char *along, *about;
    Vector3 axis;
  } axes[] = {{"x", "roll", Vector3::UnitX()}, {"y", "pitch", Vector3::UnitY()}, {"z", "yaw", Vector3::UnitZ()}};
  for (const auto& a : axes) {
    marker.controls.push_back(control(a.along, a.axis, Control::MOVE_AXIS));
    marker.controls.push_back(control(a.about, a.axis, Control::ROTATE_AXIS));
  }
  server_.insert(marker, [this](const auto& feedback) { onFeedback(feedback); });
  server_.applyChanges();
}

void HandMarker::onFeedback(const visualization_msgs::InteractiveMarkerFeedback::ConstPtr& feedback) {
  if (feedback->event_type != feedback->POSE_UPDATE) return;
  if (feedback->header.frame_id != base_frame_) {
    ROS_WARN_STREAM_THROTTLE(1.0, "hand marker: feedback in frame '" << feedback->header.frame_id << "' instead of '"
                                                                     << base_frame_ << "' was ignored");
    return;
  }
  const Pose X_BG = fromPose(feedback->pose);
  if (X_BG.p.allFinite() && X_BG.R.allFinite()) move_(X_BG);
}

}  // namespace haptic
