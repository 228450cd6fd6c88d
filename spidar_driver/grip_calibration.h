/// Calibration over ROS: the grip held at home or in a jig, and a wave of the grip.
///
///   ~calibrate       the grip is held at ~jig_pose (home when it is not set): string lengths follow
///   ~calibrate_wave  after ~calibrate: records ~wave_seconds of the hand waving the grip through its workspace, then
///                    refines exits and lengths from the redundant strings (spidar/calibration.h) and adopts them
///
/// Both keep the result in ~calibration_file when that is set, with its time and residual. At the next start the file's
/// exits hold; its lengths only with ~restore_calibration, which is for boards that kept their counters.
#pragma once
#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "haptic_core/loop/ports.h"
#include "spidar_driver/driver_parameters.h"

namespace haptic {

class GripCalibration {
 public:
  /// Port and offer must outlive it. `def` is the device as its file gives it.
  GripCalibration(ros::NodeHandle& priv, const DriverParameters& parameters, const DeviceDef& def, DevicePort& port,
                  PortOffer& offer);
  ~GripCalibration();

  /// Collects samples of a wave; called for every record by one thread.
  void see(const DeviceRecord& record);
  /// What is going on, or came out last: one line, empty when nothing happened yet.
  std::string note() const;

 private:
  bool onCalibrate(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool onWave(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  std::string whyNotNow() const;
  void solveWave();
  void keep(Calibration calibration);
  void setNote(const std::string& note);

  DriverParameters parameters_;
  DeviceDef def_;
  DevicePort& port_;
  PortOffer& offer_;
  enum class Wave : int { kIdle, kRecording, kSolving };
  std::atomic<Wave> wave_{Wave::kIdle};
  std::vector<CalibrationSample> samples_;  ///< written while recording, read while solving
  std::size_t wanted_samples_ = 0;
  std::int64_t next_sample_ns_ = 0;
  StringVector start_zero_;
  std::thread solver_;
  mutable std::mutex note_mutex_;
  std::string note_;
  ros::ServiceServer calibrate_, calibrate_wave_;
};

/// `def` with what ~calibration_file says about its exits; `zero_length` is filled when its lengths hold as well.
/// Without a file, `def` itself. Throws SetupError when the file is for another device.
DeviceDef withSavedCalibration(const DriverParameters& parameters, const DeviceDef& def, StringVector& zero_length);

}  // namespace haptic
