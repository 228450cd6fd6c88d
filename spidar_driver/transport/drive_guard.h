/// A second process that turns the motors off when this one no longer can.
///
/// The boards have no watchdog: they hold the last current until somebody sends another one. A crash,
/// SIGKILL, a debugger's stop or a hung thread would leave the strings pulling. The guard is a child that
/// holds the same port, watches a heartbeat in shared memory and the life of its parent, and sends zero
/// currents when either ends. It uses async-signal-safe calls only and survives Ctrl-C and a kill of the
/// process group.
#pragma once
#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <vector>

namespace haptic {

class DriveGuard {
 public:
  /// `descriptor`: the open port; `zero_drive`: bytes that turn all motors off. Throws SetupError when the
  /// system has no process or memory left.
  DriveGuard(int descriptor, const std::vector<std::uint8_t>& zero_drive);
  ~DriveGuard();  ///< ends the guard, which sends zero currents once more, and waits for it (some ms)
  DriveGuard(const DriveGuard&) = delete;
  DriveGuard& operator=(const DriveGuard&) = delete;

  /// (in realtime) This process lives; `armed`: currents other than zero are on.
  void beat(bool armed) noexcept {
    shared_->armed.store(armed, std::memory_order_relaxed);
    shared_->beats.fetch_add(1, std::memory_order_relaxed);
  }
  std::uint64_t stalls() const noexcept { return shared_->stalls.load(std::memory_order_relaxed); }

  static constexpr int kPollMs = 10;   ///< how often the guard looks
  static constexpr int kStallMs = 50;  ///< a heartbeat older than this is a stalled loop: 50 ticks at 1 kHz

 private:
  struct Shared {
    std::atomic<std::uint64_t> beats, stalls;
    std::atomic<bool> armed;
  };
  [[noreturn]] static void watch(Shared& shared, const std::uint8_t* bytes, std::size_t size);

  Shared* shared_ = nullptr;
  int life_ = -1;  ///< write end of a pipe that closes with this process
  pid_t pid_ = -1;
};

}  // namespace haptic
