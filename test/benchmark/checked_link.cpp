#include "checked_link.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "spidar_driver/emulator/memory_link.h"
#include "spidar_driver/transport/uart_boards.h"

namespace haptic::bench {
namespace {

class ShaftPlant : public MotorPlant {
 public:
  void advance(std::int64_t) override {}
  void drive(int channel, std::int16_t digit) override { digits[channel] = digit; }
  std::int32_t position(int channel) const override { return positions[channel]; }
  std::array<std::int32_t, 64> positions{};
  std::array<std::int16_t, 64> digits{};
};

/// Keeps a copy of what passes.
class RecordingLink : public MemoryLink {
 public:
  RecordingLink(MemoryLine& line, std::vector<std::uint8_t>& sent, std::vector<std::uint8_t>& received)
      : MemoryLink(line), sent_(sent), received_(received) {}
  bool write(const std::uint8_t* bytes, std::size_t size) noexcept override {
    sent_.insert(sent_.end(), bytes, bytes + size);
    return MemoryLink::write(bytes, size);
  }
  int read(std::uint8_t* bytes, std::size_t capacity, std::int64_t deadline_ns) noexcept override {
    const int got = MemoryLink::read(bytes, capacity, deadline_ns);
    if (got > 0) received_.insert(received_.end(), bytes, bytes + got);
    return got;
  }

 private:
  std::vector<std::uint8_t>&sent_, &received_;
};

// The published table, by hand: motors, bytes of the CURRENT command, of its padding and of its reply.
struct Row {
  int motors, command, padding, reply;
};
Row rowOf(const std::string& model) {
  return model == "B5M" ? Row{8, 17, 44, 41} : Row{4, 9, 28, 17};
}

void appendWord(std::vector<std::uint8_t>& bytes, int value) {
  bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
  bytes.push_back(static_cast<std::uint8_t>(value >> 8 & 0xFF));
}

/// Takes a mark off the end of a cycle: BOARD_INFO of one board with 26 zeros and its reply of 7 bytes, or GET_PARAM with the
/// parameter's number, its zeros (reply - 2 + 20) and its reply.
bool cutMark(const std::string& model, std::vector<std::uint8_t>& sent, std::vector<std::uint8_t>& received) {
  struct Mark {
    int header, body;
    std::size_t question, reply;
  };
  const std::size_t param = model == "B5M" ? 34 : 18;
  for (const Mark& m : {Mark{0x08, 0, 27, 7}, Mark{0x58, 1, 20 + param, param}}) {
    if (sent.size() < m.question || received.size() < m.reply) continue;
    const auto question = sent.end() - static_cast<std::ptrdiff_t>(m.question);
    const bool mark = (*question & 0xF8) == m.header && received[received.size() - m.reply] == *question &&
                      std::all_of(question + 1 + m.body, sent.end(), [](std::uint8_t b) { return b == 0; });
    if (!mark) continue;
    sent.resize(sent.size() - m.question);
    received.resize(received.size() - m.reply);
    return true;
  }
  return false;
}

/// The digit that the wire carries: no low byte is the header of SET_CMDLEN, SET_PARAM or RESET_SENSOR of a board on the bus.
int carried(int digit, int boards) {
  const auto spoils = [&](int d) {
    const int command = (d & 0xFF) >> 3, id = d & 7;
    return (command == 2 || command == 9 || command == 10) && id >= 1 && id <= boards;
  };
  while (spoils(digit)) --digit;
  return digit;
}

DeviceDef deviceOf(const std::vector<std::string>& models) {
  DeviceDef device;
  device.name = "checked";
  device.boards = models;
  device.max_rate_hz = 1e4;
  for (const std::string& model : models)
    for (int m = 0; m < rowOf(model).motors; ++m) {
      StringDef s;
      s.length_per_count = 2e-5;
      s.volt_per_newton = 0.1;
      s.min_tension = 0.3;
      s.max_tension = 8;
      device.strings.push_back(s);
    }
  return device;
}

}  // namespace

CycleCheck checkCycles(const std::vector<std::string>& models, long cycles) {
  const DeviceDef device = deviceOf(models);
  ShaftPlant plant;
  BoardBusEmulator bus(plant);
  for (std::size_t b = 0; b < models.size(); ++b) bus.addBoard(models[b], static_cast<int>(b) + 1);
  MemoryLine line(bus);
  std::vector<std::uint8_t> sent, received, expected_sent, expected_received;
  UartBoards driver(device, {}, "memory",
                    [&] { return std::make_unique<RecordingLink>(line, sent, received); });
  CycleCheck check;
  const int strings = static_cast<int>(device.strings.size());
  std::vector<int> digit(strings);
  for (long k = 0; k < cycles; ++k) {
    line.now_ns += 1000000;
    DriveCommand command;
    for (int i = 0; i < strings; ++i) {
      // More than the least tension, 0.3 N of 0.1 V: a digit that is left out there becomes the next one above.
      const int asked = 60 + static_cast<int>((37 * k + 101 * i) % 930);
      command.voltage[i] = (asked + 0.5) * 3.3 / 4096;
      digit[i] = carried(asked, static_cast<int>(models.size()));
      plant.positions[i] += i % 2 ? -40 : 40;  // 0.4 m/s in steps: what a motor can do
    }
    // Empty the line and take the lesson of every 1000th exchange, if it is due. Counts are those of one instant, on the line
    // between a board's last two readings: both see the new position.
    driver.exchange({});
    line.now_ns += 1000000;
    driver.exchange({});
    sent.clear();
    received.clear();
    line.now_ns += 1000000;
    const DeviceSample sample = driver.exchange(command);
    expected_sent.clear();
    expected_received.clear();
    int channel = 0;
    for (std::size_t b = 0; b < models.size(); ++b) {
      const Row row = rowOf(models[b]);
      expected_sent.push_back(static_cast<std::uint8_t>(0x30 + b + 1));
      expected_received.push_back(static_cast<std::uint8_t>(0x30 + b + 1));
      for (int m = 0; m < row.motors; ++m) appendWord(expected_sent, digit[channel + m]);
      for (int m = 0; m < row.motors; ++m) appendWord(expected_received, plant.positions[channel + m]);
      expected_sent.insert(expected_sent.end(), row.padding, 0);
      expected_received.insert(expected_received.end(), row.reply - 1 - 2 * row.motors,
                               0);  // at rest, no force
      channel += row.motors;
    }
    const bool marked = cutMark(models[0], sent, received);
    const std::size_t lesson = sent.size() - std::min(sent.size(), expected_sent.size());
    bool ok = std::equal(expected_sent.begin(), expected_sent.end(),
                         sent.begin() + static_cast<std::ptrdiff_t>(lesson), sent.end()) &&
              received == expected_received && sample.age_ticks == 0;
    check.marks += marked;
    for (int i = 0; i < strings; ++i)
      ok = ok && sample.counts[i] == plant.positions[i] && plant.digits[i] == digit[i];
    ++(ok ? check.ok : check.wrong);
  }
  return check;
}

double highestRate(const DeviceDef& device) {
  ShaftPlant plant;
  BoardBusEmulator bus(plant);
  int id = 1;
  for (const std::string& model : device.boards) bus.addBoard(model, id++);
  MemoryLine line(bus);
  UartBoards driver(device, {}, "memory", [&line] { return std::make_unique<MemoryLink>(line); });
  for (int k = 0; k < 10; ++k) driver.exchange({});
  const std::int64_t start = line.now_ns;
  constexpr int kExchanges = 20000;
  int fresh = 0;
  for (int k = 0; k < kExchanges; ++k) fresh += driver.exchange({}).age_ticks == 0;
  return fresh / (1e-9 * static_cast<double>(line.now_ns - start));
}

}  // namespace haptic::bench
