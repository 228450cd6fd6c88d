#include "spidar_driver/transport/serial_port.h"

// termios2 carries baud rates that have no B constant (2 Mbaud has, others have not); <termios.h> collides
// with it and is not included here.
#include <asm/termbits.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/serial.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

// A reply must fit between two ticks: the kernel takes a whole cycle at once, so a write that waits longer
// than this [ms] means a line that does not move.
constexpr int kWriteWaitMs = 2;
constexpr double kBaudTolerance = 0.025;  // 8N1 samples its last bit at 9.5 bits: 5 % over both ends

SetupError openError(const std::string& path, int error) {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return {path, "no such port",
              "plug the adapter in, or give another port (ls /dev/ttyUSB* /dev/ttyACM*)"};
    case EACCES:
    case EPERM:
      return {path, "no permission to open the port",
              "install the udev rule (spidar_driver/udev/README.md) or: sudo usermod -aG dialout $USER, "
              "then log in again"};
    case EBUSY:
    case EWOULDBLOCK:
      return {path, "another program holds the port",
              "stop it (fuser -v " + path + "), a device has one driver"};
    default:
      return {path, std::string("cannot open the port: ") + std::strerror(error), "check the path"};
  }
}

timespec toTimespec(std::int64_t ns) {
  return {static_cast<time_t>(ns / 1000000000), static_cast<long>(ns % 1000000000)};
}

}  // namespace

SerialPort::SerialPort(const std::string& path, int baud) : path_(path) {
  fd_ = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) throw openError(path, errno);
  try {
    configure(baud);
  } catch (...) {
    ::close(fd_);
    throw;
  }
}

SerialPort::~SerialPort() {
  ::ioctl(fd_, TIOCNXCL);
  ::close(fd_);
}

void SerialPort::configure(int baud) {
  if (!::isatty(fd_)) throw SetupError(path_, "is no serial port", "give a tty such as /dev/ttyUSB0");
  // TIOCEXCL keeps other users out; root passes it, flock does not let a second driver of root's in.
  if (::flock(fd_, LOCK_EX | LOCK_NB) != 0) throw openError(path_, errno);
  ::ioctl(fd_, TIOCEXCL);

  termios2 tio{};
  if (::ioctl(fd_, TCGETS2, &tio) != 0) throw openError(path_, errno);
  tio.c_iflag = IGNBRK | IGNPAR;
  tio.c_oflag = 0;
  tio.c_lflag = 0;
  tio.c_cflag = CS8 | CREAD | CLOCAL | BOTHER;
  tio.c_ispeed = tio.c_ospeed = static_cast<speed_t>(baud);
  tio.c_cc[VMIN] = 1;  // so that a read of nothing is EAGAIN and a read of zero bytes is a hang-up
  tio.c_cc[VTIME] = 0;
  if (::ioctl(fd_, TCSETS2, &tio) != 0 || ::ioctl(fd_, TCGETS2, &tio) != 0) throw openError(path_, errno);
  if (std::abs(static_cast<double>(tio.c_ospeed) - baud) > kBaudTolerance * baud)
    throw SetupError(path_, "the adapter cannot do " + std::to_string(baud) + " baud",
                     "use one that can, as FT232H");

  int lines = TIOCM_DTR | TIOCM_RTS;
  ::ioctl(fd_, TIOCMBIC, &lines);  // a pseudo-terminal has none
  serial_struct serial{};
  if (::ioctl(fd_, TIOCGSERIAL, &serial) == 0) {
    serial.flags |= ASYNC_LOW_LATENCY;
    ::ioctl(fd_, TIOCSSERIAL, &serial);
  }
  ::ioctl(fd_, TCFLSH, TCIOFLUSH);
}

bool SerialPort::write(const std::uint8_t* bytes, std::size_t size) noexcept {
  while (size > 0) {
    const ssize_t sent = ::write(fd_, bytes, size);
    if (sent > 0) {
      bytes += sent;
      size -= static_cast<std::size_t>(sent);
    } else if (sent < 0 && errno == EAGAIN) {
      pollfd wait{fd_, POLLOUT, 0};
      if (::poll(&wait, 1, kWriteWaitMs) <= 0) return false;
    } else if (sent == 0 || errno != EINTR) {
      return false;
    }
  }
  return true;
}

int SerialPort::read(std::uint8_t* bytes, std::size_t capacity, std::int64_t deadline_ns) noexcept {
  for (;;) {
    const ssize_t got = ::read(fd_, bytes, capacity);
    if (got > 0) return static_cast<int>(got);
    if (got == 0 || (errno != EAGAIN && errno != EINTR)) return -1;
    const std::int64_t left = deadline_ns - now();
    pollfd wait{fd_, POLLIN, 0};
    const timespec patience = toTimespec(std::max<std::int64_t>(left, 0));
    const int ready = ::ppoll(&wait, 1, &patience, nullptr);
    if (ready > 0 && !(wait.revents & POLLIN)) return -1;  // hang-up: unplugged
    if (ready == 0 || (ready < 0 && errno != EINTR)) return ready == 0 ? 0 : -1;
  }
}

std::int64_t SerialPort::now() const noexcept {
  return steadyNanoseconds();
}

void SerialPort::waitUntil(std::int64_t instant_ns) const noexcept {
  const timespec instant = toTimespec(instant_ns);
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &instant, nullptr) == EINTR) {
  }
}

std::int64_t steadyNanoseconds() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<std::int64_t>(t.tv_sec) * 1000000000 + t.tv_nsec;
}

int latencyTimerMs(const std::string& path) {
  char real[PATH_MAX];
  if (!::realpath(path.c_str(), real)) return -1;
  const std::string name = std::filesystem::path(real).filename();
  std::ifstream file("/sys/class/tty/" + name + "/device/latency_timer");
  int ms = -1;
  return file >> ms ? ms : -1;
}

std::vector<std::string> serialCandidates() {
  std::vector<std::string> ports;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", none)) {
    const std::string name = entry.path().filename();
    if (name.rfind("ttyUSB", 0) == 0 || name.rfind("ttyACM", 0) == 0) ports.push_back(entry.path());
  }
  std::sort(ports.begin(), ports.end());
  return ports;
}

}  // namespace haptic
