/// Bodies that are led from outside: by a topic, or by a frame of tf.
#pragma once
#include <geometry_msgs/PoseStamped.h>
#include <haptic_msgs/heard_frames.h>
#include <ros/node_handle.h>

#include <memory>
#include <string>
#include <vector>

#include "haptic_core/base/spatial.h"

namespace haptic {

class PortOffer;
class WorldPort;
struct SceneDef;

/// Each pose that comes becomes a command (LeadBody): the body goes there at the speed that two poses in a row tell, and arrives after
/// as long as lies between them. So it follows by one period, smoothly, and slows down to rest when poses stop. A pose that comes after
/// half a second or more is gone to from rest, within 0.1 s. What lies between two poses is told by their stamps, and when they came by the
/// steady clock (SenderClock): clocks that are set, here or at the sender, change nothing. Poses that jump are approached at 0.5 m/s.
/// A frame that falls silent is said.
class MotionInputs {
 public:
  /// Scene, port and offer must outlive it. `world_frame`: of poses whose header names none; those of others go through tf.
  MotionInputs(ros::NodeHandle& nh, const SceneDef& scene, const std::string& world_frame, WorldPort& port, PortOffer& offer);

 private:
  /// A body, where its poses come from, and the last one.
  struct Input {
    int motion = -1;
    std::string name, frame;   ///< for messages; of tf, empty: a topic
    Pose X_FL, X_WL;
    std::int64_t at = 0;       ///< when X_WL was measured, by the steady clock [ns]; 0: none has come
    SenderClock clock;         ///< of a topic
    SilenceWatch silence;      ///< of a frame
    ros::Subscriber subscriber;
  };
  void receive(Input& input, const geometry_msgs::PoseStamped::ConstPtr& message);
  void look();
  void take(Input& input, const Pose& X_WF, std::int64_t at);

  std::string world_frame_;
  WorldPort& port_;
  PortOffer& offer_;
  std::unique_ptr<HeardFrames> frames_;  ///< null: nothing needs tf
  std::vector<std::unique_ptr<Input>> inputs_;
  ros::SteadyTimer timer_;               ///< others stop for as long as the system's clock was set back
};

}  // namespace haptic
