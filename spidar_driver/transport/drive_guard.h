/// A second process that turns the motors off when this one no longer can; and this one does when the second cannot.
///
/// The boards have no watchdog: they hold the last current until somebody sends another one. A crash,
/// SIGKILL, a debugger's stop or a hung thread would leave the strings pulling. The guard is a program of its
/// own, `motor_guard` (motor_guard.cpp), that holds the same port, watches a heartbeat in shared memory and
/// the life of the driver, and sends zero currents when either ends. It has its own name, command line,
/// session and process group, and is no child of the driver: what kills the driver by name, by command line,
/// by group, by session or by parent does not reach it. The driver looks in every exchange whether its guard lives (`watches`),
/// and sends zero currents until another one does. What ends every process of a machine or container
/// ends both; spidar_driver/README.md says what hardware can do.
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
  /// (in realtime: one system call) The guard lives, and has looked at the beats within kBlindSeconds; `now_ns` of the steady
  /// clock. Once it has ended, a new one is needed.
  bool watches(std::int64_t now_ns) noexcept;
  bool ended() const noexcept { return ended_; }  ///< (in realtime) as `watches` saw it
  int port() const noexcept { return port_; }     ///< descriptor of the line that it guards
  /// (in realtime) Takes the place of one that has ended, and goes on with its count.
  void follow(const DriveGuard& before) noexcept { memory_->stalls.fetch_add(before.stalls(), std::memory_order_relaxed); }
  /// (in realtime) How often the loop stood still for so long that the guard turned the motors off.
  std::uint64_t stalls() const noexcept { return memory_->stalls.load(std::memory_order_relaxed); }

  /// Least age of a heartbeat that is a stall [s]. Together with kGuardPollMs and the wire (1 ms) it stays
  /// below the 20 ms that the driver promises. A driver that is kept from its core for so long loses its
  /// force for some ticks.
  static constexpr double kStallSeconds = 0.012;
  /// A guard that has not looked for so long stands still [s]. A hundred of its looks: a busy machine that keeps a process of
  /// normal priority from its core for longer keeps the driver from it as well.
  static constexpr double kBlindSeconds = 0.2;

 private:
  void start();
  void waitUntilReady();
  void release() noexcept;

  const int port_;
  GuardMemory* memory_ = nullptr;
  int memory_descriptor_ = -1;
  int life_ = -1;  ///< one end of a pair of sockets: each hangs up when the other's process has ended
  bool ended_ = false;
  std::uint64_t looks_ = 0;
  std::int64_t asked_ns_ = 0, blind_ns_ = 0;  ///< of `watches`: when it was called last, and for how long no look was seen
};

}  // namespace haptic
