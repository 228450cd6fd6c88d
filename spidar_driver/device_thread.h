/// Runs the device in the driver's own thread while nobody of higher rank holds its port.
#pragma once
#include <atomic>
#include <string>
#include <thread>

#include "haptic_core/loop/ports.h"
#include "haptic_core/loop/realtime.h"
#include "spidar_driver/wrench_input.h"

namespace haptic {

class DeviceThread {
 public:
  DeviceThread(const std::string& port, double rate_hz, const RealtimeSettings& realtime, WrenchInput& input);
  ~DeviceThread();  ///< stops at the next tick, with zero drive

 private:
  void run();
  void runDevice(PortLease<DevicePort>& lease);

  std::string port_;
  double rate_hz_;
  RealtimeSettings realtime_;
  WrenchInput& input_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace haptic
