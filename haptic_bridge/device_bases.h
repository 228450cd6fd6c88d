/// Where the devices stand in the world: from tf when somebody places them, from the scene otherwise.
#pragma once
#include <haptic_msgs/heard_frames.h>
#include <ros/node_handle.h>

#include <map>
#include <string>
#include <vector>

#include "haptic_bridge/realtime_thread.h"

namespace haptic {

/// A transform to `DEVICE_base` from another node, static or slowly changing, wins over the scene file; its parent may be
/// the world or any frame that hangs on it. It is taken up between two ticks, and the pointer glides to the grip's new
/// place. Where nobody does, the scene's pose is published on /tf_static, and no longer once somebody does: two publishers
/// of one frame would leave it to chance which of them a listener sees. A frame that falls silent is said, and the base stays; clocks that
/// are set change nothing (HeardFrames).
///
/// Runs in the nodelet's callbacks, which come one at a time.
class DeviceBases {
 public:
  DeviceBases(ros::NodeHandle& nh, const std::string& name, const std::string& world_frame, RealtimeThread& loop);
  ~DeviceBases();

 private:
  struct Base {
    std::string device;
    Pose scene, X_WB;     ///< as the scene gives it, and as the loop has it
    ros::SteadyTime since;  ///< when the loop got it
  };
  void update();
  bool meetHands();
  Pose wanted(const Base& base);
  void apply(Base& base, const Pose& X_WB);
  void publishOthers();

  std::string name_, world_frame_;
  RealtimeThread& loop_;
  HeardFrames frames_;
  std::vector<Base> bases_;
  unsigned session_ = 0;                         ///< of the loop, that `bases_` are from
  bool carried_ = false;                         ///< a base hangs on a frame that is not known from others
  std::vector<std::string> published_;           ///< bases in our last message
  std::map<std::string, std::string> told_;      ///< base → what was last complained about
  std::map<std::string, SilenceWatch> silences_; ///< by base
  ros::SteadyTime listening_since_;
  ros::Publisher publisher_;
  ros::SteadyTimer timer_;                       ///< others stop for as long as the system's clock was set back
};

}  // namespace haptic
