/// A line that carries bytes both ways: a serial port, or a bus in memory for tests.
#pragma once
#include <cstddef>
#include <cstdint>

namespace haptic {

constexpr std::int64_t kMs = 1000000;  ///< [ns]

/// Both calls are bounded in time and never throw. After a failure the link stays dead; a new one is opened.
class ByteLink {
 public:
  virtual ~ByteLink() = default;

  /// (in realtime) Hands all bytes to the line. False: the line is gone or does not take them.
  virtual bool write(const std::uint8_t* bytes, std::size_t size) noexcept = 0;

  /// (in realtime) Waits for bytes until `deadline_ns`; returns how many came, 0 at the deadline, -1 when the
  /// line is gone. A deadline in the past only looks.
  virtual int read(std::uint8_t* bytes, std::size_t capacity, std::int64_t deadline_ns) noexcept = 0;

  virtual std::int64_t now() const noexcept = 0;                       ///< steady clock of the line [ns]
  virtual void waitUntil(std::int64_t instant_ns) const noexcept = 0;  ///< sleeps to that instant [ns]
};

}  // namespace haptic
