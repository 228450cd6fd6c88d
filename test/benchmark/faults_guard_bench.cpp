// How long motors stay on after their driver has gone: a process that drives emulated boards over a
// pseudo-terminal at 1 kHz is killed, crashes or is stopped; the boards say when their last current became
// zero. The time counts from the instant at which the signal was sent. Figure: the longest over kRounds of
// every kind, and the kinds one by one. By construction: 12 ms without a heartbeat, looked at every 2 ms, then 0.8 ms of the wire.
// What goes beyond 15 ms is the machine that wakes the guard late: a witness thread of the same priority tells by how much.
#include <cstdlib>
#include <random>
#include <vector>

#include "figure.h"
#include "watched_boards.h"

namespace haptic::bench {
namespace {

constexpr int kRounds = 100;
struct Kind {
  const char* name;
  int signal;
  bool group;
};
constexpr Kind kKinds[] = {{"kill", SIGKILL, false},
                           {"kill_group", SIGKILL, true},
                           {"crash", SIGSEGV, false},
                           {"stop", SIGSTOP, false},
                           {"stop_group", SIGSTOP, true}};

/// Milliseconds from the signal to no current; -1: the current stayed on.
double zeroTime(Boards& boards, const Kind& kind, int wait_us, Witness& witness) {
  const pid_t child = startDriver(boards);
  ::usleep(static_cast<useconds_t>(20000 + wait_us));
  witness.begin();
  const std::int64_t sent = now();
  ::kill(kind.group ? -child : child, kind.signal);
  while (boards.powered() && now() - sent < kPatienceNs) ::usleep(500);
  std::int64_t off = 0;
  boards.thread.with([&] { off = boards.plant.powered ? 0 : boards.plant.off_ns; });
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  return off == 0 ? -1 : std::max(0.0, 1e-6 * static_cast<double>(off - sent));
}

int measure(int rounds) {
  double longest = 0, witness_late = 0;
  int left_on = 0;
  schedule(SCHED_FIFO, 85);  // before the boards' thread starts
  Boards boards;
  Witness witness;
  std::mt19937 random(1);
  for (const Kind& kind : kKinds) {
    std::vector<double> times;
    double late = 0;
    for (int k = 0; k < rounds; ++k) {
      const double ms = zeroTime(boards, kind, static_cast<int>(random() % 2000), witness);
      left_on += ms < 0;
      times.push_back(ms);
      if (ms > kPromisedMs) std::printf("# %s: %.1f ms; a witness woke up to %.1f ms late\n", kind.name, ms, witness.lateMs());
      late = std::max(late, witness.lateMs());
    }
    witness_late = std::max(witness_late, late);
    std::sort(times.begin(), times.end());
    const auto over = std::count_if(times.begin(), times.end(), [](double ms) { return ms > kPromisedMs; });
    std::printf("# %-12s %d times: median %.1f ms, 95 %% %.1f ms, longest %.1f ms; %d over %.0f ms; witness up to %.1f ms late\n",
                kind.name, rounds,
                times[times.size() / 2], times[times.size() * 95 / 100], times.back(), static_cast<int>(over), kPromisedMs, late);
    figure((std::string("guard.zero_ms_max_") + kind.name).c_str(), times.back(), "ms");
    longest = std::max(longest, times.back());
  }
  figure("guard.zero_ms_max", longest, "ms");
  figure("guard.witness_late_ms_max", witness_late, "ms");
  figure("guard.left_on", left_on, "1");
  return left_on == 0 ? 0 : 1;
}

}  // namespace
}  // namespace haptic::bench

int main(int argc, char** argv) {
  return haptic::bench::measure(argc > 1 ? std::max(1, std::atoi(argv[1])) : haptic::bench::kRounds);
}
