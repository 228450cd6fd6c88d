/// A whole device without hardware: hand, twin, emulated boards, line, driver and device state, on one clock; and what a
/// fault does to pose, force and hand, measured on the twin's truth.
#pragma once
#include <array>
#include <deque>
#include <memory>
#include <string>

#include "haptic_core/spidar/spidar.h"
#include "spidar_driver/emulator/fault_script.h"
#include "spidar_driver/emulator/memory_link.h"
#include "spidar_driver/emulator/twin_plant.h"
#include "spidar_driver/transport/uart_boards.h"

namespace haptic::bench {

/// Since `startMeasuring`.
struct FaultEffect {
  double pose_error = 0;    ///< of poses that were shown, against the truth at their own stamps [m]
  double force_error = 0;   ///< of the strings' true force against the one that was presented on purpose [N]; while boards take
                            ///< over one after the other, against what each of them was told
  double stale_force = 0;   ///< longest time for which a string pulled on counts without successors, beyond 0 [s]
  double energy = 0;        ///< most that the force's error has put into the grip [J]
  bool wrong_stamp = false; ///< a pose was stamped later than its counts can be
};

class FaultRig {
 public:
  explicit FaultRig(const DeviceDef& device);

  void tick();  ///< 1 ms: exchange, sense, actuate
  void run(int ticks);
  /// This program stands still [s]: hand and boards go on, and the ticks that were due are lost.
  void stall(double seconds) { start_ns_ += static_cast<std::int64_t>(1e9 * seconds); }
  void setHand(const HandPath& path) { plant.setHand(path); }
  /// Hand at home, calibrate, recover, enable. True when the device is enabled and its pose is right to 1 mm.
  bool bringUp();
  /// Does an order of the board emulator's script; `unplug` and `plug` as well.
  void order(const std::string& text);

  /// Something is said about this tick: by the sample, the device's state or flags, or the line's report.
  bool alarmed() const { return alarmed_; }
  /// An alarm that a user sees: the state, or a flag that stands for a fault.
  bool seriouslyAlarmed() const;
  bool enabled() const { return spidar.state() == DeviceState::kEnabled; }
  double poseError() const;             ///< of the last pose against the truth at its stamp [m]
  double countError(int string) const;  ///< of what the driver believes, as a length [m]
  std::uint64_t outOfBounds() const { return out_of_bounds_; }
  void startMeasuring();
  const FaultEffect& effect() const { return effect_; }

  static constexpr double kPeriod = 1e-3;  ///< [s]
  Wrench command;                          ///< asked of the device, as a simulation would
  double command_age = 0;                  ///< [s]
  bool boards_may_misread = false;         ///< a fault disturbs what the boards are told: their currents are not the driver's

  int power_cycles = 0;                    ///< times that only switching the boards off and on helped

  DeviceDef device;
  TwinPlant plant;
  BoardBusEmulator bus;
  MemoryLine line;
  std::unique_ptr<UartBoards> driver;
  Spidar spidar;
  DeviceSample sample;

 private:
  struct Truth {
    std::int64_t at_ns;
    Vector3 p;
  };
  bool tryBringUp();
  void checkBounds();
  void measure();
  void tell();
  Vector3 forceError() const;
  bool pulls() const;
  Vector3 truthAt(std::int64_t at_ns) const;

  std::int64_t start_ns_ = 0, ticks_ = 0;
  std::uint64_t out_of_bounds_ = 0, disturbances_ = 0;
  bool alarmed_ = false;
  std::deque<Truth> truth_;
  /// What the strings of every board were told to do to the grip [N], of this tick, the one before, and so on.
  std::array<std::array<Vector3, kMaxBoards>, 3> told_{};
  double work_ = 0;
  FaultEffect effect_;
};

}  // namespace haptic::bench
