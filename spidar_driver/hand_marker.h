/// An interactive marker in rviz that moves the twin's hand.
#pragma once
#include <interactive_markers/interactive_marker_server.h>
#include <ros/node_handle.h>

#include <functional>
#include <string>

#include "haptic_core/base/spatial.h"

namespace haptic {

class HandMarker {
 public:
  using Move = std::function<void(const Pose& X_BG)>;

  /// Server `hand` in the driver's namespace; the marker starts at home in `base_frame`.
  HandMarker(ros::NodeHandle& nh, const std::string& base_frame, double radius, Move move);

 private:
  void onFeedback(const visualization_msgs::InteractiveMarkerFeedback::ConstPtr& feedback);

  std::string base_frame_;
  Move move_;
  interactive_markers::InteractiveMarkerServer server_;
};

}  // namespace haptic
