/// Ticks of a thread at a fixed rate: absolute deadlines, and the privileges that the operating system grants.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace haptic {

std::int64_t steadyNow() noexcept;  ///< (in realtime) CLOCK_MONOTONIC [ns]: stands still while the machine sleeps
std::int64_t bootNow() noexcept;    ///< (in realtime) CLOCK_BOOTTIME [ns]: the same, but goes on while the machine sleeps

/// Wakes a thread at a fixed rate.
/// Wakes at start + n/rate. After an overrun the deadlines move: no burst makes up for lost ticks.
class PeriodicWake {
 public:
  explicit PeriodicWake(double rate_hz);  ///< throws SetupError unless 1 Hz ≤ rate ≤ 20 kHz

  void start() noexcept;                  ///< the first deadline is one period from now

  /// One wake-up.
  struct Wake {
    std::int64_t start_ns = 0;            ///< steady clock when the thread ran again
    std::int64_t lateness_ns = 0;         ///< start after its deadline, ≥ 0
    int lost_periods = 0;                 ///< whole periods that passed, asleep or not; > 0: the tick counts as missed
    bool asleep = false;                  ///< the machine slept during a part of them
  };
  Wake wait() noexcept;                   ///< (in realtime) sleeps until the next deadline, if that lies ahead
  /// (in realtime) The wake-up at these readings of both clocks [ns]; `boot_ns` was read first. For `wait` and for tests.
  Wake wokenAt(std::int64_t boot_ns, std::int64_t steady_ns) noexcept;

  double period() const { return 1e-9 * static_cast<double>(period_ns_); }  ///< [s]

 private:
  std::int64_t period_ns_, deadline_ns_ = 0;
  std::int64_t slept_ns_ = 0;             ///< CLOCK_BOOTTIME less CLOCK_MONOTONIC, as far as it has been seen
};

/// Priority, memory and core that a ticking thread asks for.
struct RealtimeSettings {
  int priority = 60;         ///< SCHED_FIFO 1…98, above interrupts' 50; 0: leave the scheduler alone
  bool lock_memory = true;   ///< keep pages of the process resident once touched
  int cpu = -1;              ///< core to stay on; -1: any
};

/// Privileges that the operating system granted. `advice`: one line per refusal or setting that costs lateness, with the
/// remedy.
struct RealtimeReport {
  /// SCHED_FIFO, memory and core were granted.
  bool fifo = false, memory_locked = false, pinned = false;
  /// For the user, one sentence each.
  std::vector<std::string> advice;
};

/// Makes the calling thread real-time as far as the system lets it. Never fails: a refusal is advice.
RealtimeReport enterRealtime(const RealtimeSettings& settings);

}  // namespace haptic
