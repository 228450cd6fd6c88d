/// CPU time of a thread: what its own work takes, whatever else runs on the machine.
#pragma once
#include <time.h>

namespace haptic {

/// Of the calling thread since its start [s]; a call takes about half a microsecond.
inline double cpuSeconds() noexcept {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace haptic
