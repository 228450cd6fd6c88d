/// What monitors see of a device: /diagnostics at 1 Hz, the wire's numbers included.
#pragma once
#include <ros/node_handle.h>

#include <string>

#include "haptic_core/spidar/device_record.h"
#include "haptic_core/spidar/transport.h"

namespace haptic {

class DeviceDiagnostics {
 public:
  DeviceDiagnostics(ros::NodeHandle& nh, const std::string& name, const Transport& transport);
  /// `message`: what the device is and what to do now; `well`: nothing is to be done.
  void publish(const DeviceRecord& record, const std::string& message, bool well) const;

 private:
  ros::Publisher publisher_;
  std::string name_;
  const Transport& transport_;
};

}  // namespace haptic
