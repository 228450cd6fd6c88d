/// Motor boards on a pseudo-terminal that say when their last current became zero, and a driver of them in a process of its own.
#pragma once
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
#include <ctime>
#include <string>
#include <thread>

#include "emulated_device.h"
#include "spidar_driver/emulator/pty_line.h"
#include "spidar_driver/transport/open_transport.h"

namespace haptic::bench {

constexpr std::int64_t kPatienceNs = 2000000000;
constexpr double kPromisedMs = 20;

inline std::int64_t now() {
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
    if (powered && !on && first_off_ns == 0) first_off_ns = off_ns;
    powered = on;
  }
  bool powered = false;
  std::int64_t off_ns = 0, first_off_ns = 0;  ///< the last time; the first time since it was set to 0
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
inline void schedule(int policy, int priority) {
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

/// What the child does: 1 kHz with current, in a session and process group of its own, under the name that users kill by.
[[noreturn]] inline void drive(const std::string& port) {
  ::setsid();
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

/// Until the guard of the driver before has let go of the port, and the boards' last answers are gone.
inline void waitForPort(const std::string& path) {
  for (bool free = false; !free; ::usleep(20000)) {
    const int port = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    free = port >= 0 && ::flock(port, LOCK_EX | LOCK_NB) == 0;
    if (port >= 0) ::close(port);
  }
  ::usleep(50000);
}

/// A driver with current on.
inline pid_t startDriver(Boards& boards) {
  for (;;) {
    waitForPort(boards.line.path());
    const pid_t child = ::fork();
    if (child == 0) drive(boards.line.path());
    for (const std::int64_t start = now(); now() - start < kPatienceNs; ::usleep(1000))
      if (boards.powered()) return child;
    std::printf("# a driver did not start; once more\n");
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
  }
}

}  // namespace haptic::bench
