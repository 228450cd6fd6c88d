/// A driver on emulated boards in memory, on a clock of its own: for the tests of the UART wire.
#pragma once
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/base/error.h"
#include "spidar_driver/emulator/memory_link.h"
#include "spidar_driver/transport/uart_boards.h"

namespace haptic {

/// Shafts that stand where the test puts them.
class PlacedPlant : public MotorPlant {
 public:
  void advance(std::int64_t) override {}
  void drive(int channel, std::int16_t digit) override {
    digits[channel] = digit;
    lowest[channel] = std::min(lowest[channel], digit);
    highest[channel] = std::max(highest[channel], digit);
  }
  std::int32_t position(int channel) const override { return positions[channel]; }
  std::array<std::int32_t, 64> positions{};
  std::array<std::int16_t, 64> digits{}, lowest{}, highest{};
};

inline DeviceDef plainDevice(const std::vector<std::string>& boards, int strings) {
  DeviceDef device;
  device.name = "test device";
  device.file = "test.yaml";
  device.transport = "uart";
  device.boards = boards;
  device.max_rate_hz = 10000;
  for (int i = 0; i < strings; ++i) {
    StringDef s;
    s.length_per_count = 2.25e-5;
    s.volt_per_newton = i % 2 ? -0.091 : 0.091;
    s.min_tension = 0.3;
    s.max_tension = 6;
    device.strings.push_back(s);
  }
  return device;
}

struct BoardAt {
  const char* model;
  int id;
};

/// Boards, line and driver; `period_ns` passes between exchanges.
struct EmulatedDevice {
  explicit EmulatedDevice(const std::vector<BoardAt>& boards, const DeviceDef& device,
                          UartSettings settings = {})
      : bus(plant), line(bus), period_ns(static_cast<std::int64_t>(1e9 / settings.rate_hz)) {
    for (const BoardAt& b : boards) bus.addBoard(b.model, b.id);
    driver = std::make_unique<UartBoards>(device, settings, "memory", [this] {
      if (!line.plugged) throw SetupError("memory", "unplugged", "plug it in");
      return std::make_unique<MemoryLink>(line);
    });
    start_ns = line.now_ns;
  }

  DeviceSample tick(const DriveCommand& command = {}) {
    const std::int64_t due = start_ns + period_ns * ++ticks;
    line.now_ns = std::max(line.now_ns, due);
    return driver->exchange(command);
  }
  LinkReport report() const { return driver->linkReport(); }

  PlacedPlant plant;
  BoardBusEmulator bus;
  MemoryLine line;
  std::int64_t period_ns, start_ns = 0, ticks = 0;
  std::unique_ptr<UartBoards> driver;
};

}  // namespace haptic
