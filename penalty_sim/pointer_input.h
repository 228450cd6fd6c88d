/// A pointer that follows a pose topic: from a driver elsewhere, a bag or an rviz marker.
#pragma once
#include <geometry_msgs/PoseStamped.h>
#include <haptic_msgs/heard_frames.h>
#include <ros/node_handle.h>

#include <string>

#include "haptic_core/base/latest_value.h"
#include "haptic_core/loop/ports.h"

namespace haptic {

/// Takes `DEVICE/pose`: in frame DEVICE_base it is a grip's pose and goes through the scene's workspace map; in any
/// other frame, transformed by tf2, it is the pointer's own. Gives back `DEVICE/wrench_command`: the world's wrench
/// on the hand, in the frame the poses came in (grip) or the world (pointer).
class PointerInput {
 public:
  PointerInput(ros::NodeHandle& nh, const HandPlacement& hand, const std::string& world_frame, double age_limit,
               const HeardFrames& frames);

  /// (in realtime) Sets the pointer's target for the next step; without fresh poses the pointer stands where it is.
  void follow(World& world, std::int64_t now_ns) noexcept;
  bool fresh(std::int64_t now_ns) const noexcept;

  bool wanted() const { return wrench_.getNumSubscribers() > 0; }
  void publishWrench(const Wrench& F_W, const ros::Time& stamp) const;

 private:
  struct Target {
    Pose X_WP;
    Twist V_WP;
    std::int64_t received_ns = 0;
    bool is_grip = true;
    bool given = false;
  };
  void receive(const geometry_msgs::PoseStamped::ConstPtr& message);

  HandPlacement hand_;
  std::string base_frame_, world_frame_;
  std::int64_t age_limit_ns_;
  const HeardFrames& frames_;
  Target previous_;                 ///< of the callback
  SenderClock clock_;
  std::int64_t previous_at_ = 0;    ///< when `previous_` was measured [ns]
  LatestValue<Target> slot_;
  Target current_;                  ///< of the world's thread
  ros::Publisher wrench_;
  ros::Subscriber subscriber_;      // last: no message may arrive before the rest exists, or after it is gone
};

}  // namespace haptic
