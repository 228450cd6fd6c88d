#include "spidar_driver/transport/drive_guard.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstring>
#include <new>
#include <string>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

constexpr char kName[] = "motor_guard";
constexpr int kStartPatienceMs =
    5000;  // a busy machine may take long to start a process; the motors are off meanwhile
constexpr int kEndPatienceMs = 1000;
constexpr auto kBlindNs = static_cast<std::int64_t>(1e9 * DriveGuard::kBlindSeconds);
// Counted of the time between two exchanges at most [ns]: a driver that stood still itself has not seen the guard stand still.
constexpr std::int64_t kSeenNs = 20000000;
// At low rates the heartbeat itself is slow: a stall is this many periods. 1.6 of the lowest rate's 10 ms
// stay below 20 ms.
constexpr double kStallPeriods = 1.6;

[[noreturn]] void fail(const std::string& what) {
  throw SetupError("motor guard", what,
                   "without the guard a crash leaves the motors on: build and install the program "
                   "motor_guard beside the driver's, and leave room for one more process (ulimit -u)");
}
[[noreturn]] void fail(const char* what, int error) {
  fail(std::string(what) + ": " + std::strerror(error));
}

/// The guard's program: beside the code that asks for it, where each build and install puts it (lib/ beside
/// lib/spidar_driver/), or where this build made it.
std::string findProgram() {
  Dl_info here{};
  char path[PATH_MAX];
  std::string folder;
  if (::dladdr(reinterpret_cast<void*>(&findProgram), &here) != 0 && here.dli_fname &&
      ::realpath(here.dli_fname, path))
    folder = std::string(path, std::strrchr(path, '/') + 1);
  // A program that was started by a bare name gives that name only; the kernel knows its file.
  const ssize_t size = ::readlink("/proc/self/exe", path, sizeof path - 1);
  const std::string program(path, size > 0 ? static_cast<std::size_t>(size) : 0);
  const std::string own = program.substr(0, program.find_last_of('/') + 1);
  for (const std::string& candidate :
       {folder + kName, folder + "spidar_driver/" + kName, own + kName, own + "../spidar_driver/" + kName,
        std::string(MOTOR_GUARD_OF_THIS_BUILD)})
    if (candidate.front() == '/' && ::access(candidate.c_str(), X_OK) == 0) return candidate;
  fail("its program is not there: looked for " + folder + "spidar_driver/" + kName);
}

constexpr int kGuardFiles = 4;

/// Moves the descriptors that the guard needs to fixed places and closes everything else.
void keepOnly(const int (&wanted)[kGuardFiles]) {
  constexpr int first = kGuardWords, past = first + kGuardFiles;
  int copies[kGuardFiles];
  for (int i = 0; i < kGuardFiles; ++i) copies[i] = ::fcntl(wanted[i], F_DUPFD, past);
  for (int i = 0; i < kGuardFiles; ++i) ::dup2(copies[i], first + i);  // one that is not open stays closed
  ::close_range(0, first - 1, 0);
  ::close_range(past, ~0U, 0);
}

/// In a fresh child; async-signal-safe calls only. The second fork leaves the guard without a parent to be
/// found by.
[[noreturn]] void becomeGuard(const char* program, const int (&descriptors)[kGuardFiles]) {
  ::setsid();
  if (const pid_t grandchild = ::fork(); grandchild != 0) ::_exit(grandchild < 0 ? 1 : 0);
  if (::chdir("/") != 0) {
    // A folder that cannot be unmounted is the only harm.
  }
  keepOnly(descriptors);
  char name[sizeof kName];
  std::memcpy(name, kName, sizeof kName);
  char* const arguments[] = {name, nullptr};
  char* const environment[] = {nullptr};
  ::execve(program, arguments, environment);
  const char error = static_cast<char>(errno);
  if (::write(kGuardLife, &error, 1) < 0) ::_exit(1);
  ::_exit(1);
}

}  // namespace

DriveGuard::DriveGuard(int descriptor, const std::vector<std::uint8_t>& zero_drive,
                       const std::vector<std::uint8_t>& zero_any, double rate_hz)
    : port_(descriptor) {
  if (zero_drive.size() + zero_any.size() > kMaxZeroDrive)
    fail("the boards need " + std::to_string(zero_drive.size() + zero_any.size()) + " bytes to be turned off");
  try {
    memory_descriptor_ = ::memfd_create(kName, MFD_CLOEXEC);
    if (memory_descriptor_ < 0 || ::ftruncate(memory_descriptor_, sizeof(GuardMemory)) != 0)
      fail("no shared memory", errno);
    void* memory =
        ::mmap(nullptr, sizeof(GuardMemory), PROT_READ | PROT_WRITE, MAP_SHARED, memory_descriptor_, 0);
    if (memory == MAP_FAILED) fail("no shared memory", errno);
    memory_ = new (memory) GuardMemory{};
    memory_->stall_ns = static_cast<std::int64_t>(1e9 * std::max(kStallSeconds, kStallPeriods / rate_hz));
    memory_->zero_drive_bytes = static_cast<std::uint32_t>(zero_drive.size());
    memory_->zero_any_bytes = static_cast<std::uint32_t>(zero_drive.size() + zero_any.size());
    std::copy(zero_any.begin(), zero_any.end(), std::copy(zero_drive.begin(), zero_drive.end(), memory_->zero_drive));
    start();
    waitUntilReady();
  } catch (...) {
    release();
    throw;
  }
}

void DriveGuard::start() {
  int life[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, life) != 0) fail("no pair of sockets", errno);
  life_ = life[1];
  const std::string program = [&] {
    try {
      return findProgram();
    } catch (...) {
      ::close(life[0]);
      throw;
    }
  }();
  const int descriptors[kGuardFiles] = {STDERR_FILENO, port_, life[0], memory_descriptor_};
  // Blocked over the fork, so that no handler of the driver's runs in the child. The guard keeps them
  // blocked.
  sigset_t all, before;
  sigfillset(&all);
  ::pthread_sigmask(SIG_BLOCK, &all, &before);
  const pid_t child = ::fork();
  if (child == 0) becomeGuard(program.c_str(), descriptors);
  const int error = errno;
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  ::close(life[0]);
  if (child < 0) fail("no process", error);
  while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
}

void DriveGuard::waitUntilReady() {
  pollfd life{life_, POLLIN, 0};
  char said = kGuardReady;
  const int ready = ::poll(&life, 1, kStartPatienceMs);
  if (ready <= 0) fail("it did not start within " + std::to_string(kStartPatienceMs / 1000) + " s");
  if (::read(life_, &said, 1) != 1) fail("it ended while it started");
  if (said != kGuardReady) fail("it did not start", static_cast<unsigned char>(said));
}

bool DriveGuard::watches(std::int64_t now_ns) noexcept {
  pollfd life{life_, 0, 0};  // only the hang-up counts
  ended_ = ended_ || ::poll(&life, 1, 0) > 0;
  if (ended_) return false;
  const std::uint64_t looks = memory_->looks.load(std::memory_order_relaxed);
  const std::int64_t seen_ns = asked_ns_ == 0 ? 0 : std::min(now_ns - asked_ns_, kSeenNs);
  asked_ns_ = now_ns;
  blind_ns_ = looks == looks_ ? blind_ns_ + seen_ns : 0;
  looks_ = looks;
  return blind_ns_ < kBlindNs;
}

DriveGuard::~DriveGuard() {
  release();
}

void DriveGuard::release() noexcept {
  if (life_ >= 0) {
    ::shutdown(life_, SHUT_WR);  // the guard sees the end of this driver, and this one waits for the guard's
    pollfd life{life_, 0, 0};    // only the hang-up counts
    while (::poll(&life, 1, kEndPatienceMs) < 0 && errno == EINTR) {
    }
    ::close(life_);
  }
  if (memory_) ::munmap(memory_, sizeof(GuardMemory));
  if (memory_descriptor_ >= 0) ::close(memory_descriptor_);
}

}  // namespace haptic
