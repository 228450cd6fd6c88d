// The program motor_guard: started by DriveGuard (drive_guard.h), never by hand. It needs no library but the
// system's.
#include <poll.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "spidar_driver/transport/guard_memory.h"

namespace {

using namespace haptic;

constexpr int kPollMs = 2;   // how often the heartbeat is looked at; half a per cent of a core
constexpr int kRepeats = 3;  // zero currents are sent so often: a byte may be lost on the wire
constexpr int kRepeatMs = 3;
constexpr int kLongRepeatMs = 10;  // while the driver stands still; longer than the wire takes for the bytes
constexpr int kWriteWaitMs = 2;
// A driver of normal priority may be kept from its core in the middle of a write, with the terminal's lock. Whoever spins for
// the lock at the guard's priority keeps it there: the guard sleeps instead, so long, at most so often.
constexpr long kLockWaitNs = 100000;
constexpr int kLockTries = 30;
constexpr int kPriority =
    80;  // above the driver's thread: a driver that spins must not keep its guard from looking

std::int64_t now() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<std::int64_t>(t.tv_sec) * 1000000000 + t.tv_nsec;
}

/// False: the port is gone, and with it what there is to turn off.
bool sendZero(const GuardMemory& memory, std::size_t bytes) {
  const std::uint8_t* at = memory.zero_drive;
  int tries = 0;
  for (std::size_t left = bytes; left > 0;) {
    const ssize_t sent = ::write(kGuardPort, at, left);
    if (sent > 0) {
      at += sent;
      left -= static_cast<std::size_t>(sent);
    } else if (sent < 0 && errno == EAGAIN) {
      pollfd port{kGuardPort, POLLOUT, 0};
      // A full line, or a lock that nobody gives back: the next repeat tries again.
      if (::poll(&port, 1, kWriteWaitMs) <= 0 || ++tries > kLockTries) return true;
      const timespec pause{0, kLockWaitNs};
      ::nanosleep(&pause, nullptr);
    } else {
      return false;
    }
  }
  return true;
}

void pauseMs(int ms) {
  ::poll(nullptr, 0, ms);
}

/// For who reads the driver's log: it may be a crash that nobody else tells of. Never waits for a reader.
void say(const char* text) {
  pollfd words{kGuardWords, POLLOUT, 0};
  if (::poll(&words, 1, 0) > 0 && (words.revents & POLLOUT) && ::write(kGuardWords, text, std::strlen(text)) < 0) return;
}

/// Best effort: a guard without these rights still works, only less promptly on a busy machine.
void becomePrompt() {
  sched_param priority{};
  priority.sched_priority = kPriority;
  if (::sched_setscheduler(0, SCHED_FIFO, &priority) != 0) ::setpriority(PRIO_PROCESS, 0, -20);
  ::mlockall(MCL_CURRENT | MCL_FUTURE);
}

[[noreturn]] void watch(GuardMemory& memory) {
  std::uint64_t seen = memory.beats.load(std::memory_order_relaxed);
  std::int64_t changed = now(), next_zero = 0;
  int sent = 0;  // in this stall
  for (;;) {
    memory.looks.fetch_add(1, std::memory_order_relaxed);
    pollfd life{kGuardLife, POLLIN, 0};  // the driver sends nothing: readable is the end of it, in whatever way
    if (::poll(&life, 1, kPollMs) > 0) {
      const bool armed = memory.armed.load(std::memory_order_relaxed);
      for (int i = 0; i < kRepeats && sendZero(memory, memory.zero_any_bytes); ++i) pauseMs(kRepeatMs);
      if (armed) say("motor_guard: the driver ended with its motors on; they are off now\n");
      ::_exit(0);
    }
    const std::int64_t instant = now();
    const std::uint64_t beats = memory.beats.load(std::memory_order_relaxed);
    if (beats != seen || !memory.armed.load(std::memory_order_relaxed)) {
      seen = beats;
      changed = instant;
      sent = 0;
      continue;
    }
    if (instant - changed < memory.stall_ns || (sent > 0 && instant < next_zero)) continue;
    if (sent == 0) memory.stalls.fetch_add(1, std::memory_order_relaxed);
    sendZero(memory, sent < kRepeats ? memory.zero_drive_bytes : memory.zero_any_bytes);
    next_zero = instant + 1000000LL * (++sent < kRepeats ? kRepeatMs : kLongRepeatMs);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--version") == 0) {
    std::puts("motor_guard, haptic_core " MOTOR_GUARD_VERSION ", alone");
    return 0;
  }
  void* memory = ::mmap(nullptr, sizeof(GuardMemory), PROT_READ | PROT_WRITE, MAP_SHARED, kGuardMemory, 0);
  if (memory == MAP_FAILED) {
    std::fprintf(stderr,
                 "motor_guard: the driver of motor boards starts this program; it is of no use alone\n");
    return 2;
  }
  struct stat size {};
  if (::fstat(kGuardMemory, &size) != 0 || size.st_size != static_cast<off_t>(sizeof(GuardMemory))) {
    std::fprintf(stderr, "motor_guard: the driver is of another version: build and install both together\n");
    return 2;  // the driver does not start without its guard
  }
  ::close(kGuardMemory);
  becomePrompt();
  if (::send(kGuardLife, &kGuardReady, 1, MSG_NOSIGNAL) != 1) return 1;
  watch(*static_cast<GuardMemory*>(memory));
}
