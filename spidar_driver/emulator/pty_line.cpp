#include "spidar_driver/emulator/pty_line.h"

#include <asm/termbits.h>
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "haptic_core/base/error.h"
#include "spidar_driver/transport/serial_port.h"

namespace haptic {
namespace {

constexpr std::int64_t kForgetNs = 100000000;  // [ns]

}  // namespace

PtyLine::PtyLine(BoardBusEmulator& bus, const std::string& link, bool wire_time)
    : bus_(bus), link_(link) {
  bus.setInstant(!wire_time);
  plug();
}

PtyLine::~PtyLine() {
  unplug();
}

void PtyLine::plug() {
  if (plugged()) return;
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  char name[64];
  if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0 ||
      ::ptsname_r(master_, name, sizeof name) != 0)
    throw SetupError("pseudo-terminal", std::strerror(errno), "mount /dev/pts");
  path_ = name;
  // Kept open, so that the terminal does not hang up while no driver has it.
  slave_ = ::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios2 raw{};
  ::ioctl(slave_, TCGETS2, &raw);
  raw.c_iflag = raw.c_oflag = raw.c_lflag = 0;
  raw.c_cflag = CS8 | CREAD | CLOCAL | BOTHER;
  raw.c_ispeed = raw.c_ospeed = 2000000;
  ::ioctl(slave_, TCSETS2, &raw);
  if (link_.empty()) return;
  // A link left by an emulator that was killed is replaced; a file of somebody else's is not.
  char target[64];
  if (::readlink(link_.c_str(), target, sizeof target) >= 0) ::unlink(link_.c_str());
  if (::symlink(name, link_.c_str()) != 0)
    throw SetupError(link_, std::strerror(errno), "give another path to --link");
}

void PtyLine::unplug() {
  if (!plugged()) return;
  ::close(slave_);
  ::close(master_);
  master_ = slave_ = -1;
  bus_.clearLine();
  if (!link_.empty()) ::unlink(link_.c_str());
}

/// A real port forgets its exclusive lock when the last one closes it; this one is held open here, and a
/// driver that was killed could not undo it. The driver's flock stays in force.
void PtyLine::forgetExclusive() {
  const std::int64_t now = steadyNanoseconds();
  if (now - last_forget_ns_ < kForgetNs) return;
  last_forget_ns_ = now;
  ::ioctl(slave_, TIOCNXCL);
}

void PtyLine::sendDue() {
  std::uint8_t out[512];
  const std::int64_t now = steadyNanoseconds();
  if (bus_.quietAt() > now) return;
  for (;;) {
    const std::size_t size = bus_.take(out, sizeof out, now);
    if (size == 0) return;
    // A host that does not read loses what its buffer cannot hold, as on a real port.
    if (::write(master_, out, size) < 0) return;
  }
}

bool PtyLine::serve(int patience_ms, int also_descriptor) {
  const std::int64_t deadline = steadyNanoseconds() + patience_ms * 1000000ll;
  for (;;) {
    const std::int64_t wake = std::min(deadline, bus_.quietAt());
    const std::int64_t left = std::max<std::int64_t>(0, wake - steadyNanoseconds());
    const timespec patience{static_cast<time_t>(left / 1000000000), static_cast<long>(left % 1000000000)};
    pollfd wait[2] = {{master_, POLLIN, 0}, {also_descriptor, POLLIN, 0}};
    ::ppoll(wait, 2, &patience, nullptr);
    if (plugged()) {
      std::uint8_t in[4096];
      const ssize_t got = wait[0].revents & POLLIN ? ::read(master_, in, sizeof in) : 0;
      if (got > 0) {
        received_ += static_cast<std::uint64_t>(got);
        bus_.receive(in, static_cast<std::size_t>(got), steadyNanoseconds());
      }
      sendDue();
      forgetExclusive();
    }
    if (wait[1].revents) return true;
    if (steadyNanoseconds() >= deadline) return false;
  }
}

}  // namespace haptic
