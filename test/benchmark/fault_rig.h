/// A whole device without hardware: hand, twin, emulated boards, line, driver and device state, on one clock.
#pragma once
#include <memory>
#include <string>

#include "haptic_core/spidar/spidar.h"
#include "spidar_driver/emulator/memory_link.h"
#include "spidar_driver/emulator/twin_plant.h"
#include "spidar_driver/transport/uart_boards.h"

namespace haptic::bench {

class FaultRig {
 public:
  explicit FaultRig(const DeviceDef& device);

  void tick();  ///< 1 ms: exchange, sense, actuate
  void run(int ticks);
  void setHand(const char* name) { plant.setHand(handPath(name)); }
  /// Hand at home, calibrate, recover, enable. True when the device is enabled and its pose is right to 1 mm.
  bool bringUp();

  /// Something is said about this tick: by the sample, the device's state or flags, or the line's report.
  bool alarmed() const { return alarmed_; }
  bool enabled() const { return spidar.state() == DeviceState::kEnabled; }
  double poseError() const;             ///< against the twin's truth [m]
  double countError(int string) const;  ///< of what the driver believes, as a length [m]
  std::uint64_t outOfBounds() const { return out_of_bounds_; }

  static constexpr double kPeriod = 1e-3;  ///< [s]
  Wrench command;                          ///< asked of the device, as a simulation would
  double command_age = 0;                  ///< [s]

  DeviceDef device;
  TwinPlant plant;
  BoardBusEmulator bus;
  MemoryLine line;
  std::unique_ptr<UartBoards> driver;
  Spidar spidar;
  DeviceSample sample;

 private:
  void checkBounds();

  std::int64_t start_ns_ = 0, ticks_ = 0;
  std::uint64_t out_of_bounds_ = 0, disturbances_ = 0;
  bool alarmed_ = false;
};

}  // namespace haptic::bench
