/// What the device did, as topics: drains the port's records in a thread of its own.
#pragma once
#include <ros/node_handle.h>
#include <std_msgs/Header.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "haptic_core/loop/ports.h"
#include "spidar_driver/conversions.h"
#include "spidar_driver/device_diagnostics.h"
#include "spidar_driver/device_markers.h"
#include "spidar_driver/driver_parameters.h"

namespace haptic {

/// pose, twist, wrench (pose_rate), joint_states (joint_state_rate), tf base → grip and markers (frame_rate), joy
/// (on change), state (latched; on change and at 1 Hz), /diagnostics (1 Hz). Messages are made only when somebody subscribes; no pose
/// leaves before calibration.
class DeviceTopics {
 public:
  /// Adds what only the driver knows: claims, refusals, transport; `well`: the message only says that all is.
  using CompleteState = std::function<void(haptic_msgs::DeviceState&, bool well)>;

  /// Sees every record, in the topics' thread.
  using SeeRecord = std::function<void(const DeviceRecord&)>;

  DeviceTopics(ros::NodeHandle& nh, const DriverParameters& parameters, DevicePort& port, CompleteState complete,
               SeeRecord see);
  ~DeviceTopics();

 private:
  void run();
  void handle(const DeviceRecord& record);
  void publishMotion(const DeviceRecord& record, const std_msgs::Header& header);
  void publishJointStates(const DeviceRecord& record, const std_msgs::Header& header);
  void publishFrames(const DeviceRecord& record);
  void publishJoy(const DeviceRecord& record);
  void publishState(const DeviceRecord& record);
  bool motionWanted() const;

  DriverParameters parameters_;
  DevicePort& port_;
  DeviceDef def_;  ///< as it was at the start; the device's own may be replaced by a calibration
  CompleteState complete_;
  SeeRecord see_;
  std::string base_frame_, grip_frame_;
  ros::Publisher pose_, twist_, wrench_, joint_states_, joy_, state_;
  DeviceDiagnostics diagnostics_;
  DeviceMarkers markers_;
  tf2_ros::TransformBroadcaster broadcaster_;
  tf2_ros::StaticTransformBroadcaster static_broadcaster_;
  DeviceRecord last_;
  StringVector last_length_;
  std::int64_t next_pose_ns_ = 0, next_joints_ns_ = 0, next_frames_ns_ = 0, next_state_ns_ = 0, last_joints_ns_ = 0;
  haptic_msgs::DeviceState last_state_;
  std::uint32_t lost_exchanges_ = 0;
  unsigned last_buttons_ = 0;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace haptic
