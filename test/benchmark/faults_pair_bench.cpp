// Driver and motor guard watch each other: one is killed, the other, both one after the other in either order, the driver's group
// and its session. The boards say when the last current became zero; the time counts from the first signal.
// The gap between two kills counts from the end of the first process, which on a busy machine comes later than its signal.
// Two kills within kAtOnceMs are one: neither has had time to see the other's end. They are counted under their own name, since
// the boards hold their last current for ever (`check` says so of each device).
#include <dirent.h>
#include <poll.h>
#include <sys/syscall.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>
#include <vector>

#include "figure.h"
#include "watched_boards.h"

namespace haptic::bench {
namespace {

constexpr int kRounds = 25;
constexpr int kAtOnceMs = 2;
constexpr int kNever = -1;

/// The motor guard that holds the port; 0: none.
pid_t guardOf(const std::string& port) {
  pid_t found = 0;
  DIR* processes = ::opendir("/proc");
  while (const dirent* entry = processes ? ::readdir(processes) : nullptr) {
    const std::string folder = std::string("/proc/") + entry->d_name;
    std::string name;
    std::getline(std::ifstream(folder + "/comm"), name);
    char path[256] = {};
    if (name == "motor_guard" && ::readlink((folder + "/fd/3").c_str(), path, sizeof path - 1) > 0 && port == path)
      found = std::atoi(entry->d_name);
  }
  if (processes) ::closedir(processes);
  return found;
}

enum class Whom { kGuard, kDriver, kGroup, kSession, kGuardsGroup };

struct Kind {
  const char* name;
  Whom first, second;
  int gap_ms;  ///< between the two; kNever: the first alone
};
constexpr Kind kKinds[] = {
    {"guard", Whom::kGuard, Whom::kDriver, kNever},
    {"guards_group", Whom::kGuardsGroup, Whom::kDriver, kNever},
    {"driver", Whom::kDriver, Whom::kGuard, kNever},
    {"group", Whom::kGroup, Whom::kGuard, kNever},
    {"session", Whom::kSession, Whom::kGuard, kNever},
    {"guard_driver_5ms", Whom::kGuard, Whom::kDriver, 5},
    {"guard_driver_30ms", Whom::kGuard, Whom::kDriver, 30},
    {"guard_group_5ms", Whom::kGuard, Whom::kGroup, 5},
    {"guard_session_5ms", Whom::kGuard, Whom::kSession, 5},
    {"driver_guard_5ms", Whom::kDriver, Whom::kGuard, 5},
    {"driver_guard_30ms", Whom::kDriver, Whom::kGuard, 30},
    {"group_guard_5ms", Whom::kGroup, Whom::kGuard, 5},
    {"session_guard_5ms", Whom::kSession, Whom::kGuard, 5},
    {"guard_driver_at_once", Whom::kGuard, Whom::kDriver, 0},
    {"driver_guard_at_once", Whom::kDriver, Whom::kGuard, 0},
    {"guard_driver_2ms", Whom::kGuard, Whom::kDriver, kAtOnceMs},
    {"driver_guard_2ms", Whom::kDriver, Whom::kGuard, kAtOnceMs},
};

void killWhom(Whom whom, pid_t driver, pid_t guard) {
  switch (whom) {
    case Whom::kGuard:
      ::kill(guard, SIGKILL);
      break;
    case Whom::kGuardsGroup:
      ::kill(-::getpgid(guard), SIGKILL);
      break;
    case Whom::kDriver:
      ::kill(driver, SIGKILL);
      break;
    case Whom::kGroup:
    case Whom::kSession:  // the driver leads both; whoever has left its group has left its session
      ::kill(-driver, SIGKILL);
      break;
  }
}

void waitForEnd(pid_t process) {
  const int descriptor = static_cast<int>(::syscall(SYS_pidfd_open, process, 0));
  pollfd end{descriptor, POLLIN, 0};
  if (descriptor >= 0) ::poll(&end, 1, static_cast<int>(kPatienceNs / 1000000));
  ::close(descriptor);
}

/// Milliseconds from the first signal to no current; -1: the current stayed on.
double zeroTime(Boards& boards, const Kind& kind, int wait_us) {
  const pid_t driver = startDriver(boards), guard = guardOf(boards.line.path());
  if (guard == 0) return std::printf("# a driver had no guard\n"), -1;
  ::usleep(static_cast<useconds_t>(20000 + wait_us));
  boards.thread.with([&] { boards.plant.first_off_ns = 0; });
  const std::int64_t sent = now();
  killWhom(kind.first, driver, guard);
  const bool guard_first = kind.first == Whom::kGuard || kind.first == Whom::kGuardsGroup;
  if (kind.gap_ms > kAtOnceMs) waitForEnd(guard_first ? guard : driver);
  if (kind.gap_ms > 0) ::usleep(static_cast<useconds_t>(1000 * kind.gap_ms));
  if (kind.gap_ms != kNever) killWhom(kind.second, driver, guard);
  std::int64_t off = 0;
  for (; off == 0 && now() - sent < kPatienceNs / 4; ::usleep(500)) boards.thread.with([&] { off = boards.plant.first_off_ns; });
  ::kill(driver, SIGKILL);
  ::waitpid(driver, nullptr, 0);
  if (off == 0) boards.thread.with([&] { boards.plant.powered = false; });  // somebody switches the boards off and on
  return off == 0 ? -1 : std::max(0.0, 1e-6 * static_cast<double>(off - sent));
}

int measure(int rounds) {
  schedule(SCHED_FIFO, 85);  // before the boards' thread starts
  Boards boards;
  Witness witness;
  std::mt19937 random(1);
  double longest = 0, late = 0;
  int left_on = 0, at_once = 0, at_once_left_on = 0;
  for (const Kind& kind : kKinds) {
    std::vector<double> times;
    int on = 0;
    witness.begin();
    for (int k = 0; k < rounds; ++k) {
      const double ms = zeroTime(boards, kind, static_cast<int>(random() % 2000));
      on += ms < 0;
      if (ms >= 0) times.push_back(ms);
    }
    std::sort(times.begin(), times.end());
    const bool together = kind.gap_ms != kNever && kind.gap_ms <= kAtOnceMs;
    std::printf("# %-22s %d times: median %.1f ms, longest %.1f ms, left on %d; a witness woke up to %.1f ms late\n", kind.name,
                rounds, times.empty() ? NAN : times[times.size() / 2], times.empty() ? NAN : times.back(), on, witness.lateMs());
    late = std::max(late, witness.lateMs());
    if (together) {
      at_once += rounds;
      at_once_left_on += on;
      continue;
    }
    left_on += on;
    if (!times.empty()) longest = std::max(longest, times.back());
  }
  figure("guard.pair_zero_ms_max", left_on > 0 ? INFINITY : longest, "ms");
  figure("guard.pair_left_on", left_on, "1");
  figure("guard.pair_witness_late_ms_max", late, "ms");
  figure("guard.at_once", at_once, "1");
  figure("guard.at_once_left_on", at_once_left_on, "1");
  return left_on == 0 ? 0 : 1;
}

}  // namespace
}  // namespace haptic::bench

int main(int argc, char** argv) {
  return haptic::bench::measure(argc > 1 ? std::max(1, std::atoi(argv[1])) : haptic::bench::kRounds);
}
