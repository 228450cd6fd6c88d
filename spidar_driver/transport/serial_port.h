/// A serial port set up for short packets at a high rate: raw bytes, exclusive, low latency.
#pragma once
#include <string>
#include <vector>

#include "spidar_driver/transport/byte_link.h"

namespace haptic {

class SerialPort : public ByteLink {
 public:
  /// Opens `path` with 8 data bits, no parity, 1 stop bit, no flow control, DTR and RTS off. The port is
  /// locked for this process (TIOCEXCL and flock), and asks its driver for low latency where there is such a
  /// switch. Throws SetupError: no such port, no permission, in use, no serial port, baud rate not reached.
  SerialPort(const std::string& path, int baud);
  ~SerialPort() override;
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  bool write(const std::uint8_t* bytes, std::size_t size) noexcept override;
  int read(std::uint8_t* bytes, std::size_t capacity, std::int64_t deadline_ns) noexcept override;
  std::int64_t now() const noexcept override;
  void waitUntil(std::int64_t instant_ns) const noexcept override;

  int descriptor() const { return fd_; }
  const std::string& path() const { return path_; }

 private:
  void configure(int baud);

  int fd_ = -1;
  std::string path_;
};

/// Latency timer of the USB adapter behind a port [ms], as its driver states it; -1 when it has none.
/// FTDI's default of 16 ms holds a loop at 1 kHz off; the udev rule shipped with this package sets 1 ms.
int latencyTimerMs(const std::string& path);

/// Ports a board can be at: /dev/ttyUSB*, /dev/ttyACM*, in order of name.
std::vector<std::string> serialCandidates();

std::int64_t steadyNanoseconds() noexcept;

}  // namespace haptic
