/// What hands can bear of the scene that they feel: computed at each start of the loop and when bodies come or go, in a thread of its own.
#pragma once
#include <ros/node_handle.h>

#include <atomic>
#include <functional>
#include <map>
#include <string>
#include <thread>

#include "haptic_bridge/realtime_thread.h"

namespace haptic {

/// Latched topic `hand_limits` (haptic_msgs/HandLimits), by haptic_core/analysis/hand_certificate.h. A second of work per
/// scene, outside the loop.
class HandLimits {
 public:
  /// `restarted` is called after each start of the loop but the first: another scene, or the same once more.
  HandLimits(ros::NodeHandle& nh, const std::string& world_frame, RealtimeThread& loop, std::function<void()> restarted);
  ~HandLimits();

 private:
  void run();
  void publish(const RealtimeThread::Felt& felt);

  std::string world_frame_;
  RealtimeThread& loop_;
  std::function<void()> restarted_;
  std::map<std::string, std::string> said_;  ///< by device, its last line about changes that the loop makes to the scene
  ros::Publisher publisher_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace haptic
