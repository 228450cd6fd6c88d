/// Where the devices stand in the world: from tf when somebody places them, from the scene otherwise.
#pragma once
#include <ros/node_handle.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <map>
#include <string>
#include <vector>

#include "haptic_bridge/realtime_thread.h"

namespace haptic {

/// A transform to `DEVICE_base` from another node, static or slowly changing, wins over the scene file; its parent may be
/// the world or any frame that hangs on it. It is taken up between two ticks, and the pointer glides to the grip's new
/// place. Where nobody does, the scene's pose is published on /tf_static, and no longer once somebody does: two publishers
/// of one frame would leave it to chance which of them a listener sees.
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
  };
  using Event = ros::MessageEvent<const tf2_msgs::TFMessage>;
  void receive(const Event& event, bool is_static);
  void update();
  bool meetHands();
  Pose wanted(const Base& base);
  void apply(Base& base, const Pose& X_WB);
  void publishOthers();

  std::string name_, world_frame_;
  RealtimeThread& loop_;
  tf2::BufferCore buffer_;
  std::vector<Base> bases_;
  unsigned session_ = 0;                         ///< of the loop, that `bases_` are from
  std::map<std::string, std::string> placed_;    ///< frames that others place → parent frame
  bool carried_ = false;                         ///< a base hangs on a frame that is not known from others
  std::vector<std::string> published_;           ///< bases in our last message
  std::map<std::string, std::string> told_;      ///< base → what was last complained about
  ros::WallTime listening_since_;
  ros::Publisher publisher_;
  ros::Subscriber moving_, static_;
  ros::WallTimer timer_;
};

}  // namespace haptic
