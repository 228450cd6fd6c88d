#include "spidar_driver/transport/drive_guard.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <new>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

constexpr int kPort = 3, kLife = 4;  // descriptors of the child; all others are closed

[[noreturn]] void fail(const char* what) {
  throw SetupError("drive guard", std::string(what) + ": " + std::strerror(errno),
                   "free memory or processes (ulimit -u); without the guard a crash leaves the motors on");
}

/// Moves the two descriptors that the child needs to fixed places and closes everything else.
void keepOnly(int port, int life) {
  const int port_copy = ::fcntl(port, F_DUPFD, kLife + 1);
  const int life_copy = ::fcntl(life, F_DUPFD, kLife + 1);
  ::dup2(port_copy, kPort);
  ::dup2(life_copy, kLife);
  ::close_range(0, kPort - 1, 0);
  ::close_range(kLife + 1, ~0U, 0);
}

}  // namespace

DriveGuard::DriveGuard(int descriptor, const std::vector<std::uint8_t>& zero_drive) {
  void* memory = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) fail("no shared memory");
  shared_ = new (memory) Shared{};
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) {
    ::munmap(memory, sizeof(Shared));
    fail("no pipe");
  }
  // Blocked over the fork, so that no handler of the parent's runs in the child.
  sigset_t all, before;
  sigfillset(&all);
  ::pthread_sigmask(SIG_BLOCK, &all, &before);
  pid_ = ::fork();
  if (pid_ == 0) {
    ::setsid();
    keepOnly(descriptor, ends[0]);
    watch(*shared_, zero_drive.data(), zero_drive.size());
  }
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  ::close(ends[0]);
  life_ = ends[1];
  if (pid_ < 0) {
    ::close(life_);
    ::munmap(memory, sizeof(Shared));
    fail("no process");
  }
}

DriveGuard::~DriveGuard() {
  ::close(life_);
  while (::waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
  ::munmap(shared_, sizeof(Shared));
}

void DriveGuard::watch(Shared& shared, const std::uint8_t* bytes, std::size_t size) {
  std::uint64_t seen = 0;
  int still_ms = 0;
  for (;;) {
    pollfd life{kLife, 0, 0};
    const int ready = ::poll(&life, 1, kPollMs);
    const std::uint64_t beats = shared.beats.load(std::memory_order_relaxed);
    still_ms = beats == seen ? still_ms + kPollMs : 0;
    seen = beats;
    const bool stalled = still_ms >= kStallMs && shared.armed.load(std::memory_order_relaxed);
    // A hung-up port fails the write; there is nothing left to turn off then.
    if ((ready > 0 || stalled) && ::write(kPort, bytes, size) < 0 && ready > 0) ::_exit(1);
    if (ready > 0) ::_exit(0);
    if (stalled && still_ms == kStallMs) shared.stalls.fetch_add(1, std::memory_order_relaxed);
  }
}

}  // namespace haptic
