/// A line to emulated boards inside one process, on a clock that only runs while somebody waits: every run is
/// the same, and as fast as the processor. One thread at a time.
#pragma once
#include <algorithm>
#include <memory>

#include "spidar_driver/emulator/board_bus_emulator.h"
#include "spidar_driver/transport/byte_link.h"

namespace haptic {

/// The cable: it outlives the links that are opened on it.
struct MemoryLine {
  explicit MemoryLine(BoardBusEmulator& emulator) : bus(emulator) {}
  BoardBusEmulator& bus;
  std::int64_t now_ns = 0;
  bool plugged = true;
  std::uint64_t bytes_sent = 0;  ///< by the host
};

class MemoryLink : public ByteLink {
 public:
  explicit MemoryLink(MemoryLine& line) : line_(line), alive_(line.plugged) {}

  bool write(const std::uint8_t* bytes, std::size_t size) noexcept override {
    if (!connected()) return false;
    line_.bytes_sent += size;
    line_.bus.receive(bytes, size, line_.now_ns);
    return true;
  }

  int read(std::uint8_t* bytes, std::size_t capacity, std::int64_t deadline_ns) noexcept override {
    if (!connected()) return -1;
    const std::int64_t due = line_.bus.quietAt();
    if (due > line_.now_ns && line_.bus.nextByteAt() > line_.now_ns)
      line_.now_ns = std::max(line_.now_ns, std::min(due, deadline_ns));
    return static_cast<int>(line_.bus.take(bytes, capacity, line_.now_ns));
  }

  std::int64_t now() const noexcept override { return line_.now_ns; }
  void waitUntil(std::int64_t instant_ns) const noexcept override {
    line_.now_ns = std::max(line_.now_ns, instant_ns);
  }

 private:
  /// A link does not come back to life with the cable: the driver has to open a new one.
  bool connected() { return alive_ = alive_ && line_.plugged; }

  MemoryLine& line_;
  bool alive_;
};

}  // namespace haptic
