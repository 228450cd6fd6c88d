/// A second process that turns the motors off when this one no longer can.
///
/// The boards have no watchdog: they hold the last current until somebody sends another one. A crash,
/// SIGKILL, a debugger's stop or a hung thread would leave the strings pulling. The guard is a program of its
/// own, `motor_guard` (motor_guard.cpp), that holds the same port, watches a heartbeat in shared memory and
/// the life of the driver, and sends zero currents when either ends. It has its own name, command line,
/// session and process group, and is no child of the driver: what kills the driver by name, by command line,
/// by group, by session or by parent does not reach it. What ends every process of a machine or container
/// ends it too; spidar_driver/README.md says what hardware can do.
#pragma once
#include <atomic>
#include <cstdint>
#include <vector>

#include "spidar_driver/transport/guard_memory.h"

namespace haptic {

class DriveGuard {
 public:
  /// Starts the guard and waits until it watches (some ms). `descriptor`: the open port; `zero_drive`: bytes
  /// that turn all motors off, `zero_any` those that do it whatever state the boards are in; `rate_hz`: at which `beat` will be
  /// called. Throws SetupError when the program
  /// is not there, or the system has no process or memory left.
  DriveGuard(int descriptor, const std::vector<std::uint8_t>& zero_drive, const std::vector<std::uint8_t>& zero_any,
             double rate_hz = 1000);
  ~DriveGuard();  ///< ends the guard, which sends zero currents once more, and waits for it (some ms)
  DriveGuard(const DriveGuard&) = delete;
  DriveGuard& operator=(const DriveGuard&) = delete;

  /// (in realtime) Currents are about to be sent. Called before, and a beat too: a driver that is stopped between sending
  /// and `beat` has begun a stall of its own, whatever the guard thought of it until then.
  void arm() noexcept { beat(true); }
  /// (in realtime) This process lives; `armed`: currents other than zero are on.
  void beat(bool armed) noexcept {
    memory_->armed.store(armed, std::memory_order_relaxed);
    memory_->beats.fetch_add(1, std::memory_order_relaxed);
  }
  /// (in realtime) How often the loop stood still for so long that the guard turned the motors off.
  std::uint64_t stalls() const noexcept { return memory_->stalls.load(std::memory_order_relaxed); }

  /// Least age of a heartbeat that is a stall [s]. Together with kGuardPollMs and the wire (1 ms) it stays
  /// below the 20 ms that the driver promises. A driver that is kept from its core for so long loses its
  /// force for some ticks.
  static constexpr double kStallSeconds = 0.012;

 private:
  void start(int descriptor);
  void waitUntilReady();
  void release() noexcept;

  GuardMemory* memory_ = nullptr;
  int memory_descriptor_ = -1;
  int life_ = -1;  ///< write end of a pipe that closes with this process
  int done_ = -1;  ///< read end of a pipe that closes with the guard
};

}  // namespace haptic
