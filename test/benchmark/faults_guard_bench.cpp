// How long motors stay on after their driver has gone: a process that drives emulated boards over a
// pseudo-terminal at 1 kHz is killed, crashes or is stopped; the boards say when their last current became
// zero. The time counts from the instant at which the signal was sent. Figure: the longest over kRounds of
// every kind, and the kinds one by one. By construction: 12 ms without a heartbeat, looked at every 2 ms, then 0.8 ms of the wire.
// What goes beyond 15 ms is the machine that wakes the guard late: a witness thread of the same priority tells by how much.
#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "emulated_device.h"
#include "figure.h"
#include "spidar_driver/emulator/pty_line.h"
#include "spidar_driver/transport/open_transport.h"

namespace haptic::bench {
namespace {

constexpr int kRounds = 100;
constexpr std::int64_t kPatienceNs = 2000000000;
constexpr double kPromisedMs = 20;

std::int64_t now() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<std::int64_t>(t.tv_sec) * 1000000000 + t.tv_nsec;
}

/// Remembers when the last of its motors lost its current.
struct WatchedPlant : PlacedPlant {
  void drive(int channel, std::int16_t digit) override {
    PlacedPlant::drive(channel, digit);
    const bool on = std::any_of(digits.begin(), digits.end(), [](std::int16_t d) { return d != 0; });
    if (powered && !on) off_ns = now();
    powered = on;
  }
  bool powered = false;
  std::int64_t off_ns = 0;
};

struct Boards {
  Boards() : bus(plant), line((bus.addBoard("B5M", 1), bus), "", false), thread(line) {}
  bool powered() {
    bool on = false;
    thread.with([&] { on = plant.powered; });
    return on;
  }
  WatchedPlant plant;
  BoardBusEmulator bus;
  PtyLine line;
  PtyThread thread;
};

/// The boards are hardware: what else the machine does must not delay them. Best effort.
void schedule(int policy, int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  if (::sched_setscheduler(0, policy, &parameters) != 0)
    std::printf("# no right to real-time priorities: what the machine does besides is in the times\n");
}

/// Wakes every 2 ms at the guard's priority, as the guard does, and has nothing to do: how late it wakes is the machine's part.
class Witness {
 public:
  Witness() : thread_([this] { run(); }) {}
  ~Witness() {
    stop_ = true;
    thread_.join();
  }
  void begin() { late_ns_ = 0; }
  double lateMs() const { return 1e-6 * static_cast<double>(late_ns_.load()); }

 private:
  void run() {
    sched_param parameters{};
    parameters.sched_priority = 80;
    ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters);
    constexpr std::int64_t kPeriodNs = 2000000;
    while (!stop_) {
      const std::int64_t due = now() + kPeriodNs;
      ::usleep(kPeriodNs / 1000);
      late_ns_ = std::max(late_ns_.load(), now() - due);
    }
  }
  std::atomic<bool> stop_{false};
  std::atomic<std::int64_t> late_ns_{0};
  std::thread thread_;
};

/// What the child does: 1 kHz with current, in a process group of its own, under the name that users kill by.
[[noreturn]] void drive(const std::string& port) {
  ::setpgid(0, 0);
  schedule(SCHED_OTHER, 0);
  ::prctl(PR_SET_NAME, "nodelet");
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // an interrupted benchmark leaves nothing behind
  TransportSettings settings;
  settings.port = port;
  settings.reply_wait_s = 0.2;
  try {
    auto transport = openTransport(plainDevice({"B5M"}, 8), settings);
    DriveCommand command;
    for (int i = 0; i < 8; ++i) command.voltage[i] = i % 2 ? -0.2 : 0.2;
    for (;;) {
      transport->exchange(command);
      ::usleep(500);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    ::_exit(1);
  }
}

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

/// Until the guard of the driver before has let go of the port, and the boards' last answers are gone.
void waitForPort(const std::string& path) {
  for (bool free = false; !free; ::usleep(20000)) {
    const int port = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    free = port >= 0 && ::flock(port, LOCK_EX | LOCK_NB) == 0;
    if (port >= 0) ::close(port);
  }
  ::usleep(50000);
}

/// A driver with current on.
pid_t startDriver(Boards& boards) {
  for (;;) {
    waitForPort(boards.line.path());
    const pid_t child = ::fork();
    if (child == 0) drive(boards.line.path());
    ::setpgid(child, child);
    for (const std::int64_t start = now(); now() - start < kPatienceNs; ::usleep(1000))
      if (boards.powered()) return child;
    std::printf("# a driver did not start; once more\n");
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
  }
}

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
