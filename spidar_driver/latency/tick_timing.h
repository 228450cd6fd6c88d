/// What a loop's timing allows: percentiles of round trip and lateness, and a verdict for a rate.
#pragma once
#include <string>
#include <vector>

namespace haptic {

/// One run at one rate.
struct TickTiming {
  double rate_hz = 0;
  long ticks = 0;
  long missed = 0;                    ///< ticks that started more than one period late
  long stale = 0;                     ///< exchanges without a fresh answer in their wait
  std::vector<double> round_trip_us;  ///< of each exchange
  std::vector<double> lateness_us;    ///< start of each tick behind its deadline
};

enum class Verdict : unsigned char { kGood, kMarginal, kNo };

/// `share` in 0..1 of the sorted values; NaN when there are none.
double percentile(std::vector<double> values, double share);

/// Good: nothing missed or stale, and 99.9 % of the exchanges leave a fifth of the period to the tick.
/// Marginal: at most one tick in a thousand missed or stale. No: worse.
Verdict verdictOf(const TickTiming& timing);
const char* toString(Verdict verdict);

/// What the machine and the adapter look like: the causes that can be changed.
struct TimingSetup {
  bool realtime_priority = false;  ///< SCHED_FIFO was granted
  bool memory_locked = false;
  bool realtime_kernel = false;  ///< PREEMPT_RT
  bool isolated_cpus = false;
  int last_cpu = 0;           ///< the highest that this process may run on; 0: the only one
  bool powersave = false;     ///< frequency governor
  int latency_timer_ms = -1;  ///< of the USB adapter; -1: none
};

TimingSetup examineMachine(const std::string& port);

/// One line per thing to change, the most effective first; empty when nothing is left to do.
std::vector<std::string> advice(const TimingSetup& setup, const std::vector<TickTiming>& runs);

}  // namespace haptic
