#include "haptic_core/loop/realtime.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1000000000;

std::int64_t read(clockid_t clock) noexcept {
  timespec now;
  clock_gettime(clock, &now);
  return now.tv_sec * kNanosecondsPerSecond + now.tv_nsec;
}

/// Lost periods are counted so far [1]: 15 hours at 20 kHz, and a weekend asleep does not overflow.
constexpr std::int64_t kMostLostPeriods = 1 << 30;
/// Two clocks that part by less than this have not slept, they were read apart [ns]. No machine sleeps and wakes in 5 ms.
constexpr std::int64_t kLeastSleepNs = 5000000;
constexpr double kLowestRateHz = 1, kHighestRateHz = 20000;  // above, a wake-up alone takes the period
// The kernel may delay a sleeper of the normal scheduler by 50 µs to save power; 1 ns asks it not to.
constexpr unsigned long kTimerSlackNs = 1;

std::string firstLine(const char* path) {
  std::string line;
  std::ifstream file(path);
  std::getline(file, line);
  return line;
}

/// Whether `cpu` is in a list of the kernel's, such as "1,4-7".
bool listed(const std::string& list, int cpu) {
  std::istringstream parts(list);
  for (std::string part; std::getline(parts, part, ',');) {
    int first = -1, last = -1;
    const int numbers = std::sscanf(part.c_str(), "%d-%d", &first, &last);
    if (numbers > 0 && cpu >= first && cpu <= (numbers == 2 ? last : first)) return true;
  }
  return false;
}

/// Settings of the machine that cost lateness; reading them needs no rights.
void checkMachine(const RealtimeSettings& settings, RealtimeReport& report) {
  std::vector<std::string>& advice = report.advice;
  const std::string governor = firstLine("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  if (!governor.empty() && governor != "performance") {
    advice.push_back("the CPU governor is '" + governor + "': cpupower frequency-set -g performance");
  }
  const std::string preempt = firstLine("/sys/kernel/realtime");
  if (preempt != "1") advice.push_back("the kernel is not PREEMPT_RT: lateness has no bound (package linux-image-rt-amd64)");
  // Of one processor nothing can be kept free.
  if (report.pinned && ::sysconf(_SC_NPROCESSORS_ONLN) > 1 && !listed(firstLine("/sys/devices/system/cpu/isolated"), settings.cpu)) {
    advice.push_back("core " + std::to_string(settings.cpu) + " is shared: boot with isolcpus=" +
                     std::to_string(settings.cpu));
  }
  const std::string throttle = firstLine("/proc/sys/kernel/sched_rt_runtime_us");
  if (throttle == "0") advice.push_back("real-time scheduling is off: sysctl kernel.sched_rt_runtime_us=950000");
}

}  // namespace

std::int64_t steadyNow() noexcept { return read(CLOCK_MONOTONIC); }
std::int64_t bootNow() noexcept { return read(CLOCK_BOOTTIME); }

PeriodicWake::PeriodicWake(double rate_hz) {
  if (!(rate_hz >= kLowestRateHz && rate_hz <= kHighestRateHz)) {
    throw SetupError("rate", "is " + std::to_string(rate_hz) + " Hz", "give 1 to 20000 Hz");
  }
  period_ns_ = std::llround(kNanosecondsPerSecond / rate_hz);
}

void PeriodicWake::start() noexcept {
  const std::int64_t boot_ns = bootNow(), now_ns = steadyNow();
  deadline_ns_ = now_ns + period_ns_;
  slept_ns_ = boot_ns - now_ns;
}

PeriodicWake::Wake PeriodicWake::wait() noexcept {
  const timespec until{deadline_ns_ / kNanosecondsPerSecond, deadline_ns_ % kNanosecondsPerSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
  const std::int64_t boot_ns = bootNow();  // first: a thread that loses its core between the two readings has not slept
  return wokenAt(boot_ns, steadyNow());
}

PeriodicWake::Wake PeriodicWake::wokenAt(std::int64_t boot_ns, std::int64_t steady_ns) noexcept {
  Wake wake;
  wake.start_ns = steady_ns;
  wake.lateness_ns = wake.start_ns - deadline_ns_;
  const std::int64_t slept_ns = boot_ns - steady_ns - slept_ns_;
  wake.asleep = slept_ns > kLeastSleepNs;
  slept_ns_ += std::max<std::int64_t>(0, slept_ns);
  const std::int64_t lost_ns = wake.lateness_ns + (wake.asleep ? slept_ns : 0);
  wake.lost_periods = static_cast<int>(std::min(kMostLostPeriods, lost_ns / period_ns_));
  deadline_ns_ += period_ns_;
  if (wake.lost_periods > 0) deadline_ns_ = wake.start_ns + period_ns_;
  return wake;
}

RealtimeReport enterRealtime(const RealtimeSettings& settings) {
  RealtimeReport report;
  prctl(PR_SET_TIMERSLACK, kTimerSlackNs);
  if (settings.priority > 0) {
    sched_param parameter{};
    parameter.sched_priority = settings.priority;
    const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter);
    report.fifo = error == 0;
    if (error != 0) {
      report.advice.push_back("SCHED_FIFO " + std::to_string(settings.priority) + " was refused (" +
                              std::strerror(error) + "): allow rtprio in /etc/security/limits.d, or run as root");
    }
  }
  if (settings.lock_memory) {
    // MCL_ONFAULT: locks the pages in use, not the 8 MB of address space that each thread's stack reserves.
    report.memory_locked = mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0;
    if (!report.memory_locked) {
      report.advice.push_back(std::string("memory could not be locked (") + std::strerror(errno) +
                              "): allow memlock in /etc/security/limits.d, or run as root");
    }
  }
  if (settings.cpu >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(settings.cpu, &set);
    report.pinned = pthread_setaffinity_np(pthread_self(), sizeof(set), &set) == 0;
    if (!report.pinned) report.advice.push_back("there is no core " + std::to_string(settings.cpu) + " to stay on");
  }
  checkMachine(settings, report);
  return report;
}

}  // namespace haptic
