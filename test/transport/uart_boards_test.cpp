// The UART wire on emulated boards: counts, order, limits, and what happens when the line is disturbed.
#include "spidar_driver/transport/uart_boards.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>
#include <thread>

#include "emulated_device.h"

namespace haptic {
namespace uart_boards_test {

DriveCommand pull(const DeviceDef& device, double newtons) {
  DriveCommand command;
  for (std::size_t i = 0; i < device.strings.size(); ++i)
    command.voltage[i] = newtons * device.strings[i].volt_per_newton;
  return command;
}

std::string messageOf(const std::vector<BoardAt>& boards, const DeviceDef& device,
                      UartSettings settings = {}) {
  try {
    EmulatedDevice emulated(boards, device, settings);
  } catch (const SetupError& error) {
    return error.what();
  }
  return "";
}

TEST(UartBoards, CountsAndCurrentsPassOnEveryModel) {
  for (const char* model : {"B1M", "B1F", "B2M", "B2F", "B3M", "B3F", "B5M"}) {
    const int motors = findBoardModel(std::string(model))->motors;
    const DeviceDef device = plainDevice({model}, motors);
    EmulatedDevice e({{model, 3}}, device);
    e.tick();  // counts first, then currents
    for (int k = 0; k < 50; ++k) {
      for (int i = 0; i < motors; ++i) e.plant.positions[i] = 40 * k * (i % 2 ? -1 : 1) + i;
      const DeviceSample s = e.tick(pull(device, 1 + 0.05 * k));
      EXPECT_EQ(s.status, LinkStatus::kOk);
      EXPECT_EQ(s.age_ticks, 0u);
      for (int i = 0; i < motors; ++i) EXPECT_EQ(s.counts[i], e.plant.positions[i]) << model;
      // 4096 digits per 3.3 V, truncated; less by one where the low byte would be a header of board 3 that changes it.
      const auto expected = [](int i, int tick) {
        const double digit = (1 + 0.05 * tick) * 0.091 * 4096 / 3.3;
        const int whole = static_cast<int>(i % 2 ? -digit : digit), low = whole & 0xFF;
        // SET_CMDLEN, ALL, DIRECT, INTERPOLATE, FORCE_CONTROL, SET_PARAM, RESET_SENSOR
        const bool moves = low == 0x13 || low == 0x1B || low == 0x2B || (low >= 0x3B && low <= 0x53 && low % 8 == 3);
        return moves ? whole - (whole > 0 ? 1 : -1) : whole;
      };
      for (int i = 0; i < motors; ++i) EXPECT_EQ(e.plant.digits[i], expected(i, k)) << model << ' ' << k;
    }
  }
}

TEST(UartBoards, CountsUnwrapOverManyTurnsOfTheCounter) {
  const DeviceDef device = plainDevice({"B3M"}, 4);
  EmulatedDevice e({{"B3M", 1}}, device);
  std::int32_t x = 32000;
  e.plant.positions[0] = x;
  e.plant.positions[1] = -x;
  const std::int64_t first = e.tick().counts[0], other = e.tick().counts[1];
  for (int k = 0; k < 2000; ++k) {
    x += std::min(700, 30 * k);  // up to 15.7 m/s at 1 kHz, 21 wraps of the 16-bit counter in all
    e.plant.positions[0] = x;
    e.plant.positions[1] = -x;
    const DeviceSample s = e.tick();
    ASSERT_EQ(s.counts[0] - first, x - 32000);
    ASSERT_EQ(s.counts[1] - other, 32000 - x);
  }
}

TEST(UartBoards, BoardsOfDifferentModelsShareTheBus) {
  const DeviceDef device = plainDevice({"B1F", "B5M", "B3M"}, 15);
  EmulatedDevice e({{"B1F", 0}, {"B5M", 2}, {"B3M", 7}}, device);
  for (int i = 0; i < 15; ++i) e.plant.positions[i] = 100 * i;
  e.tick();  // counts first, then currents
  for (int k = 0; k < 100; ++k) {
    const DeviceSample s = e.tick(pull(device, 2));
    ASSERT_EQ(s.age_ticks, 0u);
    for (int i = 0; i < 15; ++i) {
      EXPECT_EQ(s.counts[i], 100 * i);
      EXPECT_NE(e.plant.digits[i], 0);
    }
  }
  EXPECT_EQ(e.bus.collisions(), 0u);
  for (const auto& b : e.bus.boards()) EXPECT_GE(b->executed(BoardCommand::kSetCommandLength), 3u);
}

TEST(UartBoards, HighestRateIsThatOfTheWire) {
  struct Case {
    std::vector<BoardAt> boards;
    std::vector<std::string> models;
    int strings, bytes;
  };
  for (const Case& c :
       {Case{{{"B5M", 1}}, {"B5M"}, 8, 61}, Case{{{"B3M", 1}, {"B3M", 2}}, {"B3M", "B3M"}, 8, 74}}) {
    const DeviceDef device = plainDevice(c.models, c.strings);
    UartSettings settings;
    EmulatedDevice e(c.boards, device, settings);
    const double limit = 1e9 / (5000.0 * c.bytes);
    EXPECT_NEAR(e.driver->maxRateHz(), limit, 1e-6 * limit);
    // Called without a pause, the driver keeps the wire busy and no more: nothing collides, nothing is lost.
    const std::int64_t start = e.line.now_ns;
    const int n = 1000;
    for (int k = 0; k < n; ++k) ASSERT_EQ(e.driver->exchange({}).age_ticks, 0u);
    const double rate = n / (1e-9 * static_cast<double>(e.line.now_ns - start));
    EXPECT_LE(rate, limit * (1 + 1.0 / n));
    // Beside the cycles: a question of the memory in 16 ms, with its answer at most 90 bytes (0.45 ms), the state of all boards in
    // 30 ms (0.28 ms), a lesson in 25 ms (0.18 ms): 4.6 %.
    EXPECT_GE(rate, limit / 1.046);
    EXPECT_EQ(e.bus.collisions(), 0u);
    settings.rate_hz = 1.01 * limit;
    EXPECT_NE(messageOf(c.boards, device, settings).find("carries at most"), std::string::npos);
  }
}

TEST(UartBoards, WhateverIsCommandedStaysInsideTheBounds) {
  const DeviceDef device = plainDevice({"B5M"}, 8);
  EmulatedDevice e({{"B5M", 1}}, device);
  const double hostile[] = {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e30, -1e30, 1e-300, 5, -5, 0};
  std::mt19937 random(3);
  const int most = static_cast<int>(6 * 0.091 * 4096 / 3.3);
  for (int k = 0; k < 5000; ++k) {
    DriveCommand command;
    bool finite = true;
    for (int i = 0; i < 8; ++i) {
      command.voltage[i] = k < 2000 ? hostile[random() % 9] : hostile[3 + random() % 6] * (k % 2 ? 1 : -1);
      finite = finite && std::isfinite(command.voltage[i]);
    }
    e.tick(command);
    for (int i = 0; i < 8; ++i) {
      const int pulling = e.plant.digits[i] * (i % 2 ? -1 : 1);
      ASSERT_GE(pulling, 0);
      ASSERT_LE(pulling, finite ? most : 0);
    }
  }
  EXPECT_GT(e.report().bad_commands, 0u);
  EXPECT_GT(e.report().clamped, 0u);
}

enum class Disturb { kDrop, kCorrupt, kDuplicate, kInsert };

void disturb(ByteFaults& faults, Disturb kind, int after) {
  faults.after(after);
  switch (kind) {
    case Disturb::kDrop:
      return faults.drop(1);
    case Disturb::kCorrupt:
      return faults.corrupt(1);
    case Disturb::kDuplicate:
      return faults.duplicate(1);
    case Disturb::kInsert:
      return faults.insert(1);
  }
}

/// One byte of the answers lost, changed, doubled or added, at every place: the driver is in step again two
/// exchanges later, and no count is off for ever.
TEST(UartBoards, ADisturbedAnswerCostsAtMostTwoExchanges) {
  const DeviceDef device = plainDevice({"B3M", "B3M"}, 8);
  for (const Disturb kind : {Disturb::kDrop, Disturb::kCorrupt, Disturb::kDuplicate, Disturb::kInsert})
    for (int place = 0; place < 34; ++place) {
      EmulatedDevice e({{"B3M", 1}, {"B3M", 2}}, device);
      for (int i = 0; i < 8; ++i) e.plant.positions[i] = 30000 + 1000 * i;
      for (int k = 0; k < 3; ++k) ASSERT_EQ(e.tick().age_ticks, 0u);
      disturb(e.bus.to_host, kind, place);
      const DeviceSample hit = e.tick();
      // A changed payload byte cannot be told from a true one, and a byte too many before a reply leaves it whole;
      // everything else is noticed at once.
      const bool header = place % 17 == 0;
      const bool added = kind == Disturb::kDuplicate || kind == Disturb::kInsert;
      const bool visible = kind == Disturb::kCorrupt ? header : !(added && header);
      if (visible) {
        EXPECT_GT(hit.age_ticks, 0u) << "kind " << static_cast<int>(kind) << " place " << place;
      }
      e.tick();
      for (int k = 0; k < 3; ++k) {
        const DeviceSample s = e.tick();
        EXPECT_EQ(s.age_ticks, 0u) << "kind " << static_cast<int>(kind) << " place " << place;
        for (int i = 0; i < 8; ++i)
          ASSERT_EQ(s.counts[i], static_cast<std::int16_t>(30000 + 1000 * i))
              << "kind " << static_cast<int>(kind) << " place " << place;
      }
    }
}

TEST(UartBoards, ADisturbedCommandCostsAtMostTwoLessons) {
  const DeviceDef device = plainDevice({"B3M", "B5M"}, 12);
  for (const Disturb kind : {Disturb::kDrop, Disturb::kCorrupt, Disturb::kDuplicate, Disturb::kInsert})
    for (int place = 0; place < 37 + 61; ++place) {
      EmulatedDevice e({{"B3M", 1}, {"B5M", 2}}, device);
      for (int k = 0; k < 3; ++k) ASSERT_EQ(e.tick(pull(device, 2)).age_ticks, 0u);
      disturb(e.bus.to_boards, kind, place);
      for (int k = 0; k < 1100; ++k) e.tick(pull(device, 2));
      e.plant.digits.fill(0);
      const DeviceSample s = e.tick(pull(device, 2));
      EXPECT_EQ(s.age_ticks, 0u) << "kind " << static_cast<int>(kind) << " place " << place;
      for (int i = 0; i < 12; ++i)
        EXPECT_EQ(e.plant.digits[i], i % 2 ? -225 : 225)
            << "kind " << static_cast<int>(kind) << " place " << place;
    }
}

TEST(UartBoards, AFlippedHighBitNeverShiftsTheCount) {
  const DeviceDef device = plainDevice({"B5M"}, 8);
  EmulatedDevice e({{"B5M", 1}}, device);
  for (int k = 0; k < 400; ++k) {
    for (int i = 0; i < 8; ++i) e.plant.positions[i] += std::min(50, k);
    e.bus.to_host.after(static_cast<int>(1 + k % 16));
    if (k % 3 == 0) e.bus.to_host.corrupt(1);
    e.tick();
  }
  const DeviceSample s = e.tick();
  for (int i = 0; i < 8; ++i) EXPECT_EQ(s.counts[i], e.plant.positions[i]);
  EXPECT_GT(e.report().refused_counts, 0u);
}

TEST(UartBoards, ASilentBoardZeroesTheDriveOfAll) {
  const DeviceDef device = plainDevice({"B3M", "B3M"}, 8);
  UartSettings settings;
  EmulatedDevice e({{"B3M", 1}, {"B3M", 2}}, device, settings);
  for (int i = 0; i < 8; ++i) e.plant.positions[i] = 9000;
  for (int k = 0; k < 10; ++k) e.tick(pull(device, 3));
  e.bus.board(2)->setPower(false);
  int noticed = 0;
  for (int k = 1; k <= 40; ++k) {
    const DeviceSample s = e.tick(pull(device, 3));
    EXPECT_EQ(s.age_ticks, static_cast<std::uint32_t>(k));
    if (!noticed && s.status == LinkStatus::kSilent) noticed = k;
  }
  EXPECT_EQ(noticed, std::lround(settings.zero_after_s * settings.rate_hz));
  EXPECT_TRUE(e.bus.allCurrentsZero());
  EXPECT_EQ(e.report().silent_boards, 1u << 2);

  e.bus.board(2)->setPower(true);
  DeviceSample s;
  for (int k = 0; k < 500; ++k) s = e.tick(pull(device, 3));  // half a second
  EXPECT_EQ(s.status, LinkStatus::kOk);
  EXPECT_FALSE(e.bus.allCurrentsZero());
  EXPECT_NE(e.driver->trouble().find("board 2"), std::string::npos);
  // Its position kept the fraction of a turn only, 9000 mod 1024: reported as a restart of each counter.
  EXPECT_EQ(e.report().restarts, 4u);
  EXPECT_EQ(s.counts[4], 9000 % 1024);
  EXPECT_EQ(s.counts[0], 9000);
}

TEST(UartBoards, LateAnswersAreCountedToTheirOwnExchange) {
  const DeviceDef device = plainDevice({"B5M"}, 8);
  EmulatedDevice e({{"B5M", 1}}, device);
  for (int k = 0; k < 5; ++k) e.tick();
  // 0.7 ms late: after the wait of 0.8 ms, before the next exchange.
  e.plant.positions[0] = 11;
  e.bus.delayReplies(1, 700000);
  EXPECT_EQ(e.tick().age_ticks, 1u);
  e.plant.positions[0] = 22;
  const DeviceSample s = e.tick();
  EXPECT_EQ(s.age_ticks, 0u);
  EXPECT_EQ(s.counts[0], 22);
  EXPECT_EQ(e.report().late, 1u);
  // 1.2 ms late: inside the next exchange, whose own answer is the one to take.
  e.bus.delayReplies(1, 1200000);
  EXPECT_EQ(e.tick().age_ticks, 1u);
  e.plant.positions[0] = 33;
  const DeviceSample next = e.tick();
  EXPECT_EQ(next.counts[0], 33);
  EXPECT_EQ(next.age_ticks, 0u);
}

TEST(UartBoards, UnpluggedIsReportedAtOnceAndReconnects) {
  const DeviceDef device = plainDevice({"B5M"}, 8);
  UartSettings settings;
  settings.reopen_s = 0.01;
  EmulatedDevice e({{"B5M", 1}}, device, settings);
  e.plant.positions[2] = 700;
  for (int k = 0; k < 5; ++k) e.tick(pull(device, 2));
  e.line.plugged = false;
  DeviceSample s = e.tick(pull(device, 2));
  EXPECT_EQ(s.status, LinkStatus::kDisconnected);
  EXPECT_EQ(s.counts[2], 700);
  std::this_thread::sleep_for(
      std::chrono::milliseconds(60));  // the recovery thread meets a line that is gone
  EXPECT_EQ(e.driver->exchange({}).status, LinkStatus::kDisconnected);
  e.line.plugged = true;
  for (int k = 0; k < 500 && s.status != LinkStatus::kOk; ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    s = e.driver->exchange({});
  }
  EXPECT_EQ(s.status, LinkStatus::kOk);
  EXPECT_EQ(s.counts[2], 700);
  EXPECT_EQ(e.report().reconnects, 1u);
}

TEST(UartBoards, CurrentsAreZeroAfterSetUpAndAfterTheEnd) {
  const DeviceDef device = plainDevice({"B5M"}, 8);
  PlacedPlant plant;
  BoardBusEmulator bus(plant);
  bus.addBoard("B5M", 1);
  MemoryLine line(bus);
  plant.digits.fill(77);  // whoever had the boards before
  {
    UartBoards driver(device, {}, "memory", [&line] { return std::make_unique<MemoryLink>(line); });
    for (int i = 0; i < 8; ++i) EXPECT_EQ(plant.digits[i], 0);
    for (int k = 0; k < 2; ++k) {  // counts first, then currents
      line.now_ns += 1000000;
      driver.exchange(pull(device, 4));
    }
    EXPECT_NE(plant.digits[0], 0);
  }
  EXPECT_TRUE(bus.allCurrentsZero());
}

TEST(UartBoards, SetUpSaysWhatIsWrong) {
  const DeviceDef g6x5 = plainDevice({"B5M"}, 8), g6x4 = plainDevice({"B3M", "B3M"}, 8);
  EXPECT_NE(messageOf({}, g6x5).find("no motor board answers"), std::string::npos);
  EXPECT_NE(messageOf({{"B3M", 1}}, g6x4).find("found only B3M (id 1)"), std::string::npos);
  EXPECT_NE(messageOf({{"B3M", 1}}, g6x5).find("needs B5M, found B3M (id 1)"), std::string::npos);
  EXPECT_NE(messageOf({{"B3M", 1}}, plainDevice({}, 8)).find("8 strings"), std::string::npos);
  EXPECT_EQ(messageOf({{"B3M", 1}, {"B1M", 6}}, plainDevice({}, 8)), "");
  EXPECT_NE(messageOf({{"B5M", 1}}, plainDevice({}, 0)).find("no strings"), std::string::npos);
}

/// A line on which somebody else speaks: answers every write with the same bytes.
class OtherDevice : public ByteLink {
 public:
  explicit OtherDevice(std::vector<std::uint8_t> answer) : answer_(std::move(answer)) {}
  bool write(const std::uint8_t*, std::size_t) noexcept override { return pending_ = true; }
  int read(std::uint8_t* bytes, std::size_t capacity, std::int64_t deadline) noexcept override {
    if (!pending_) return now_ = std::max(now_, deadline), 0;
    pending_ = false;
    const std::size_t n = std::min(capacity, answer_.size());
    std::copy_n(answer_.begin(), n, bytes);
    return static_cast<int>(n);
  }
  std::int64_t now() const noexcept override { return now_; }
  void waitUntil(std::int64_t) const noexcept override {}

 private:
  std::vector<std::uint8_t> answer_;
  bool pending_ = false;
  std::int64_t now_ = 0;
};

std::string messageOfAnswer(const std::vector<std::uint8_t>& answer) {
  OtherDevice link(answer);
  try {
    matchBoards(scanBus(link), plainDevice({"B5M"}, 8), "port");
  } catch (const SetupError& error) {
    return error.what();
  }
  return "";
}

TEST(UartBoards, APortThatIsNoBoardIsNamed) {
  EXPECT_NE(messageOfAnswer({'$', 'G', 'P', 'G', 'G', 'A', ','}).find("no motor board's answer"),
            std::string::npos);
  EXPECT_NE(messageOfAnswer({0xFF, 0x80}).find("baud rate"), std::string::npos);
  // Loop-back: the probe itself comes back.
  EXPECT_NE(messageOfAnswer({0x08, 0, 0, 0, 0, 0, 0}).find("no motor board's answer"), std::string::npos);
  EXPECT_NE(
      messageOfAnswer({0x0B, 9, 12, 5, 0, 0, 0}).find("unknown model answers (id 3: model 9, 5 motors)"),
      std::string::npos);
}


/// Its counters come back where they were: only its memory of what it was asked tells.
TEST(UartBoards, ABoardThatLostItsPowerBetweenTwoReadingsIsNoticed) {
  const DeviceDef device = plainDevice({"B3M", "B3M"}, 8);
  EmulatedDevice e({{"B3M", 1}, {"B3M", 2}}, device);
  for (int i = 0; i < 8; ++i) e.plant.positions[i] = 100;  // within the turn that a board keeps
  for (int k = 0; k < 200; ++k) ASSERT_EQ(e.tick(pull(device, 3)).status, LinkStatus::kOk) << k;
  e.bus.board(2)->reset(false);
  bool said = false;
  for (int k = 0; k < 100 && !said; ++k) said = e.tick(pull(device, 3)).status == LinkStatus::kRestarted;
  EXPECT_TRUE(said);
  EXPECT_NE(e.driver->trouble().find("board 2 had lost its power"), std::string::npos) << e.driver->trouble();
}

/// A length table that cuts every packet of its board short: it answers each question, takes nothing in and cannot be taught.
TEST(UartBoards, ABoardThatAnswersAndDoesNotObeyIsNamed) {
  const DeviceDef device = plainDevice({"B3M", "B3M"}, 8);
  EmulatedDevice e({{"B3M", 1}, {"B3M", 2}}, device);
  for (int k = 0; k < 200; ++k) e.tick(pull(device, 3));
  for (int c = 1; c < kBoardCommands; ++c) e.bus.board(1)->spoilTable(1, static_cast<BoardCommand>(c), 0);
  int ended = 0;
  for (int k = 1; k <= 200 && !ended; ++k) ended = e.tick(pull(device, 3)).status == LinkStatus::kOk ? 0 : k;
  EXPECT_GT(ended, 0);
  for (int k = 0; k < 2000; ++k) e.tick();
  for (int k = 0; k < 2000; ++k) {  // also while it seems to be in step
    e.tick();
    ASSERT_NE(e.driver->trouble().find("board 1"), std::string::npos) << k << e.driver->trouble();
    ASSERT_NE(e.driver->trouble().find("power off and on"), std::string::npos) << k << e.driver->trouble();
  }
  e.bus.board(1)->replace();
  DeviceSample s;
  for (int k = 0; k < 3000; ++k) s = e.tick();
  EXPECT_EQ(s.status, LinkStatus::kOk);
  EXPECT_EQ(e.driver->trouble().find("power off and on"), std::string::npos) << e.driver->trouble();
  for (int k = 0; k < 100; ++k) e.tick(pull(device, 3));
  EXPECT_FALSE(e.bus.allCurrentsZero());
}

/// It names the parameter that it was asked for before, and takes in no current and no lesson: nobody must call that obeying.
TEST(UartBoards, ABoardThatCutsItsCurrentsAndCannotBeTaughtIsNamed) {
  const DeviceDef device = plainDevice({"B3M", "B3M"}, 8);
  EmulatedDevice e({{"B3M", 1}, {"B3M", 2}}, device);
  for (int k = 0; k < 200; ++k) e.tick(pull(device, 3));
  const std::pair<BoardCommand, int> table[] = {{BoardCommand::kSetCommandLength, 0}, {BoardCommand::kAll, 0},
                                                {BoardCommand::kCurrent, 5}, {BoardCommand::kGetParam, 96}};
  for (const auto& [command, length] : table) e.bus.board(2)->spoilTable(2, command, length);
  e.bus.board(1)->reset(false);  // the boards are brought into step for another reason
  for (int k = 0; k < 1000; ++k) e.tick(pull(device, 3));
  for (int k = 0; k < 2000; ++k) {
    EXPECT_NE(e.tick(pull(device, 3)).status, LinkStatus::kOk) << k;
    ASSERT_NE(e.driver->trouble().find("board 2"), std::string::npos) << k << e.driver->trouble();
    ASSERT_NE(e.driver->trouble().find("power off and on"), std::string::npos) << k << e.driver->trouble();
  }
  for (int i = 0; i < 4; ++i) EXPECT_EQ(e.plant.digits[i], 0) << "board 1 pulls alone";
  e.bus.board(2)->replace();
  DeviceSample s;
  for (int k = 0; k < 2000; ++k) s = e.tick();
  EXPECT_EQ(s.status, LinkStatus::kOk);
}

/// Zero currents reach boards of any id and table, as long as one of CURRENT and ALL takes in a whole packet.
TEST(UartBoards, ZeroReachesBoardsWhateverTheirTablesSay) {
  for (const int id : {0, 3, 7})
    for (const int current : {1, 5, 16, 17, 40, 255})
      for (const int all : {1, 20, 85, 255}) {
        if (current < 17 && all < 85) continue;  // nothing takes in a packet
        EmulatedDevice e({{"B5M", id}}, plainDevice({"B5M"}, 8));
        for (int k = 0; k < 10; ++k) e.tick(pull(plainDevice({"B5M"}, 8), 3));
        ASSERT_FALSE(e.bus.allCurrentsZero());
        e.bus.board(id)->spoilTable(id, BoardCommand::kCurrent, current);
        e.bus.board(id)->spoilTable(id, BoardCommand::kAll, all);
        const std::vector<std::uint8_t> zero = zeroForAnyTable();
        e.bus.receive(zero.data(), zero.size(), e.line.now_ns);
        EXPECT_TRUE(e.bus.allCurrentsZero()) << id << ' ' << current << ' ' << all;
      }
}
}  // namespace uart_boards_test
}  // namespace haptic
