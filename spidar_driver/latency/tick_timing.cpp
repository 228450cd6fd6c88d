#include "spidar_driver/latency/tick_timing.h"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "spidar_driver/transport/serial_port.h"

namespace haptic {
namespace {

constexpr double kExchangeShare = 0.8;   // of the period; the rest computes the tick
constexpr double kMarginalShare = 1e-3;  // of the ticks may be missed or stale
constexpr double kSchedulingUs = 200;  // lateness that a real-time thread on a healthy machine does not reach

std::string firstLine(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

int lastCpu() {
  cpu_set_t set;
  if (::sched_getaffinity(0, sizeof set, &set) != 0) return 0;
  int cpu = CPU_SETSIZE - 1;
  while (cpu > 0 && !CPU_ISSET(cpu, &set)) --cpu;
  return cpu;
}

/// How to leave the loop a processor of its own, by the number that it has on this machine.
std::string cpuAdvice(int last_cpu) {
  if (last_cpu == 0) return "ticks start late on the only processor open to this program: stop what else runs there";
  const std::string cpu = std::to_string(last_cpu);
  return "ticks start late: stop what else runs, or keep a processor for the loop (boot with isolcpus=" + cpu + " nohz_full=" + cpu +
         ", set the bridge's parameter ~cpu to " + cpu + ", measure with taskset -c " + cpu + ")";
}

}  // namespace

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const auto last = static_cast<double>(values.size() - 1);
  return values[static_cast<std::size_t>(std::lround(std::clamp(share, 0.0, 1.0) * last))];
}

Verdict verdictOf(const TickTiming& timing) {
  const long bad = timing.missed + timing.stale;
  if (timing.ticks == 0 || static_cast<double>(bad) > kMarginalShare * static_cast<double>(timing.ticks))
    return Verdict::kNo;
  const double period_us = 1e6 / timing.rate_hz;
  const bool in_time = percentile(timing.round_trip_us, 0.999) <= kExchangeShare * period_us;
  return bad == 0 && in_time ? Verdict::kGood : Verdict::kMarginal;
}

const char* toString(Verdict verdict) {
  switch (verdict) {
    case Verdict::kGood:
      return "good";
    case Verdict::kMarginal:
      return "marginal";
    case Verdict::kNo:
      return "no";
  }
  return "no";
}

TimingSetup examineMachine(const std::string& port) {
  TimingSetup setup;
  setup.realtime_kernel = firstLine("/sys/kernel/realtime") == "1";
  setup.isolated_cpus = !firstLine("/sys/devices/system/cpu/isolated").empty();
  setup.last_cpu = lastCpu();
  setup.powersave = firstLine("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor") == "powersave";
  setup.latency_timer_ms = port.empty() ? -1 : latencyTimerMs(port);
  return setup;
}

std::vector<std::string> advice(const TimingSetup& setup, const std::vector<TickTiming>& runs) {
  std::vector<std::string> lines;
  bool all_good = true, late = false;
  for (const TickTiming& run : runs) {
    all_good = all_good && verdictOf(run) == Verdict::kGood;
    late = late || percentile(run.lateness_us, 0.999) > kSchedulingUs;
  }
  if (setup.latency_timer_ms > 1)
    lines.push_back("the adapter's latency timer is " + std::to_string(setup.latency_timer_ms) +
                    " ms: set 1 ms, install spidar_driver/udev/60-spidar.rules");
  if (all_good) return lines;
  if (!setup.realtime_priority)
    lines.push_back(
        "no real-time priority: add '@dialout - rtprio 80' to /etc/security/limits.d/haptic.conf, log in "
        "again");
  if (!setup.memory_locked)
    lines.push_back(
        "memory is not locked: add '@dialout - memlock unlimited' to /etc/security/limits.d/haptic.conf");
  if (setup.powersave) lines.push_back("the processor saves power: cpupower frequency-set -g performance");
  if (late && !setup.isolated_cpus) lines.push_back(cpuAdvice(setup.last_cpu));
  if (late && !setup.realtime_kernel)
    lines.push_back(
        "ticks start late: a PREEMPT_RT kernel (Debian: linux-image-rt-amd64) bounds the lateness");
  if (lines.empty()) lines.push_back("choose the highest rate marked good");
  return lines;
}

}  // namespace haptic
