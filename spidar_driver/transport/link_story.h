/// What a line has to say about itself, to other threads: counters, delays and one sentence with advice.
#pragma once
#include <array>
#include <atomic>
#include <mutex>
#include <string>

#include "haptic_core/spidar/device_diagnosis.h"
#include "spidar_driver/transport/bus_restart.h"
#include "spidar_driver/transport/link_report.h"

namespace haptic {

class LinkStory {
 public:
  enum Counter {
    kCycles,
    kStale,
    kLost,
    kLate,
    kDoubled,
    kForeign,
    kRefused,
    kRestarts,
    kRetaught,
    kReconnects,
    kOverRate,
    kBadCommands,
    kClamped,
    kStalls,
    kUnguarded,
    kCounters
  };

  // (in realtime) From the exchange's thread.
  void count(Counter c, std::uint64_t n = 1) noexcept {
    counters_[c].fetch_add(n, std::memory_order_relaxed);
  }
  void setDelay(std::int64_t ns) noexcept {
    delay_us_.store(static_cast<std::uint32_t>(ns / 1000), std::memory_order_relaxed);
  }
  void setJitter(std::int64_t ns) noexcept {
    jitter_us_.store(static_cast<std::uint32_t>(ns / 1000), std::memory_order_relaxed);
  }
  void setGuardStalls(std::uint64_t stalls) noexcept {
    guard_stalls_.store(stalls, std::memory_order_relaxed);
  }
  void setSilentBoards(std::uint32_t ids) noexcept {
    silent_boards_.store(ids, std::memory_order_relaxed);
  }  ///< bit per id
  void setStall(std::int64_t ns) noexcept {
    stall_ms_.store(static_cast<std::uint32_t>(ns / 1000000), std::memory_order_relaxed);
  }
  /// All boards answer, and those that can show that they take in what they are told have shown it.
  void setProven(bool proven) noexcept { proven_.store(proven, std::memory_order_relaxed); }
  /// Why the boards are being brought back into step.
  void setCause(WireFinding cause) noexcept { cause_.store(static_cast<int>(cause), std::memory_order_relaxed); }
  WireFinding cause() const noexcept { return static_cast<WireFinding>(cause_.load(std::memory_order_relaxed)); }
  void blame(int id) noexcept {
    cause_board_.store(id, std::memory_order_relaxed);
  }  ///< the board that the cause is about
  int blamed() const noexcept { return cause_board_.load(std::memory_order_relaxed); }
  void setTrouble(BusRestart::Trouble trouble, int id) noexcept {
    trouble_.store(static_cast<int>(trouble), std::memory_order_relaxed);
    trouble_board_.store(id, std::memory_order_relaxed);
  }

  void say(const std::string& text);  ///< from the thread that opens lines; empty: nothing is wrong there

  // From any thread.
  LinkReport report() const noexcept;
  std::string trouble() const;
  std::uint32_t delayUs() const noexcept { return delay_us_.load(std::memory_order_relaxed); }
  std::uint32_t jitterUs() const noexcept { return jitter_us_.load(std::memory_order_relaxed); }

 private:
  std::array<std::atomic<std::uint64_t>, kCounters> counters_{};
  std::atomic<std::uint64_t> guard_stalls_{0};
  std::atomic<std::uint32_t> silent_boards_{0}, delay_us_{0}, jitter_us_{0}, stall_ms_{0};
  std::atomic<bool> proven_{false};
  std::atomic<int> cause_{0}, cause_board_{-1}, trouble_{0}, trouble_board_{-1};
  mutable std::mutex said_mutex_;
  std::string said_;
};

}  // namespace haptic
