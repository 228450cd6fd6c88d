/// The driver: loads a device, offers it to the bridge, or runs it over topics.
#pragma once
#include <nodelet/nodelet.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <memory>

#include "spidar_driver/authority/process_door.h"
#include "spidar_driver/dead_man_switch.h"
#include "spidar_driver/device_thread.h"
#include "spidar_driver/device_topics.h"
#include "spidar_driver/emergency_stop.h"
#include "spidar_driver/grip_calibration.h"
#include "spidar_driver/hand_marker.h"
#include "spidar_driver/master_watch.h"
#include "spidar_driver/parent_watch.h"
#include "spidar_driver/wrench_input.h"

namespace haptic {

class DriverNodelet : public nodelet::Nodelet {
 public:
  ~DriverNodelet() override;

 private:
  /// What a lease gives away: destroyed after the port has come back, or not at all.
  struct Device {
    Device(const DeviceDef& def, const SpidarSettings& settings, std::unique_ptr<Transport> wire, double rate);
    Spidar spidar;
    std::unique_ptr<Transport> transport;
    DevicePort port;
  };

  void onInit() override;
  void start();
  std::unique_ptr<Transport> openWire(DeviceDef def) const;
  std::string whyNoCommand() const;
  void completeState(haptic_msgs::DeviceState& state, bool well) const;
  void stopAtParentsEnd();
  bool onRecover(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool onEnableForce(ros::ServiceEvent<std_srvs::SetBool::Request, std_srvs::SetBool::Response>& event);

  DriverParameters parameters_;
  std::unique_ptr<Device> device_;
  PortOffer offer_;
  std::unique_ptr<DeadManSwitch> dead_man_;
  std::unique_ptr<EmergencyStop> stop_;
  std::unique_ptr<ParentWatch> parent_;
  std::unique_ptr<MasterWatch> master_;
  std::unique_ptr<GripCalibration> calibration_;
  std::unique_ptr<WrenchInput> input_;
  std::unique_ptr<DeviceTopics> topics_;
  std::unique_ptr<DeviceThread> thread_;
  std::unique_ptr<HandMarker> hand_;
  ros::ServiceServer recover_, enable_force_;
};

}  // namespace haptic
