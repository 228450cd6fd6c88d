/// The device as rviz shows it: frame, strings coloured by tension, grip, force asked and achieved.
#pragma once
#include <ros/node_handle.h>
#include <visualization_msgs/MarkerArray.h>

#include <string>

#include "haptic_core/loop/ports.h"

namespace haptic {

/// Topic `markers`, in the base's frame. Namespaces: frame, strings, grip, force, force_asked.
class DeviceMarkers {
 public:
  DeviceMarkers(ros::NodeHandle& nh, const DeviceDef& def, const std::string& base_frame);
  bool wanted() const { return publisher_.getNumSubscribers() > 0; }
  void publish(const DeviceRecord& record, const ros::Time& stamp);

 private:
  visualization_msgs::Marker marker(const char* ns, int type, const ros::Time& stamp) const;
  void addFrame(visualization_msgs::MarkerArray& array, const ros::Time& stamp) const;
  void addStrings(visualization_msgs::MarkerArray& array, const DeviceRecord& record, const ros::Time& stamp) const;
  void addGrip(visualization_msgs::MarkerArray& array, const DeviceRecord& record, const ros::Time& stamp) const;
  void addForces(visualization_msgs::MarkerArray& array, const DeviceRecord& record, const ros::Time& stamp) const;

  DeviceDef def_;
  std::string base_frame_;
  ros::Publisher publisher_;
};

}  // namespace haptic
