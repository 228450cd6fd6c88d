// The emulated boards against the firmware facts, byte by byte, without the driver's transport.
#include <gtest/gtest.h>

#include <limits>

#include "emulated_device.h"
#include "spidar_driver/emulator/fault_script.h"

namespace haptic {
namespace emulator_test {

constexpr std::int64_t kForever = std::numeric_limits<std::int64_t>::max() - 1;

struct Bench {
  Bench() : bus(plant) {}
  std::vector<std::uint8_t> ask(std::vector<std::uint8_t> bytes, int padding = 40) {
    bytes.insert(bytes.end(), padding, 0);
    bus.receive(bytes.data(), bytes.size(), now += 10000000);
    std::vector<std::uint8_t> answer(256);
    answer.resize(bus.take(answer.data(), answer.size(), kForever));
    return answer;
  }
  PlacedPlant plant;
  BoardBusEmulator bus;
  std::int64_t now = 0;
};

using Bytes = std::vector<std::uint8_t>;

TEST(Emulator, PublishedExampleIsAnsweredAndThenObeyed) {
  Bench b;
  b.bus.addBoard("B3M", 1);
  b.plant.positions = {1, -2, 0x1234, 70000};
  const Bytes answer = b.ask({0x31, 0x64, 0x00, 0x9C, 0xFF, 0x00, 0x00, 0x01, 0x00}, 28);
  const Bytes head(answer.begin(), answer.begin() + 9);
  EXPECT_EQ(answer.size(), 17u);
  EXPECT_EQ(head, (Bytes{0x31, 0x01, 0x00, 0xFE, 0xFF, 0x34, 0x12, 0x70, 0x11}));  // 70000 − 65536 = 0x1170
  EXPECT_EQ(b.plant.digits[0], 100);
  EXPECT_EQ(b.plant.digits[1], -100);
  EXPECT_EQ(b.plant.digits[2], 0);
  EXPECT_EQ(b.plant.digits[3], 1);
}

TEST(Emulator, InfoNamesTheModel) {
  Bench b;
  b.bus.addBoard("B3F", 0);
  b.bus.addBoard("B5M", 7);
  EXPECT_EQ(b.ask({0x08}), (Bytes{0x08, 6, 12, 3, 3, 2, 0}));
  EXPECT_EQ(b.ask({0x0F}), (Bytes{0x0F, 7, 12, 8, 0, 4, 0}));  // firmware: eight sensors, none reported
  EXPECT_TRUE(b.ask({0x0C}).empty());                          // nobody has id 4
}

TEST(Emulator, ZerosAndBytesWithoutCommandAreSkippedAtAHeader) {
  Bench b;
  b.bus.addBoard("B1M", 1);
  EXPECT_EQ(b.ask({0, 0, 0x60, 0xFF, 0x80, 0x09}).size(), 7u);
}

TEST(Emulator, WithoutPaddingNoCommandIsSeen) {
  Bench b;
  b.bus.addBoard("B1M", 1);
  EXPECT_TRUE(b.ask({0x09}, 4).empty());  // 5 bytes: below ¾ of the FIFO
  EXPECT_EQ(b.ask({}, 1).size(), 7u);     // the sixth byte wakes the board
  EXPECT_EQ(b.ask({0x09}, 5).size(), 7u);
}

TEST(Emulator, AnAnswerShowsTheStateBeforeItsCommand) {
  Bench b;
  b.bus.addBoard("B3M", 1);
  Bytes all(21, 0);
  all[0] = 0x19;
  all[1] = 3;  // current mode
  all[5] = 50;
  const Bytes first = b.ask(all), second = b.ask(all);
  EXPECT_EQ(first.size(), 29u);
  EXPECT_EQ(first[5 + 16], 0);    // measured current before
  EXPECT_EQ(second[5 + 16], 50);  // after
}

TEST(Emulator, GetParamReportsTheTypeAskedBefore) {
  Bench b;
  b.bus.addBoard("B3M", 1);
  Bytes set(18, 0);
  set[0] = 0x49;
  set[1] = 1;
  set[2] = 0x55;
  EXPECT_TRUE(b.ask(set).empty());
  EXPECT_EQ(b.ask({0x59, 1})[1], 0);
  const Bytes again = b.ask({0x59, 1});
  EXPECT_EQ(again[1], 1);
  EXPECT_EQ(again[2], 0x55);
}

TEST(Emulator, SetBoardIdMovesTheBoard) {
  Bench b;
  b.bus.addBoard("B3M", 1);
  Bytes set(18, 0);
  set[0] = 0x49;
  set[1] = 3;
  set[2] = 5;
  b.ask(set);
  EXPECT_TRUE(b.ask({0x09}).empty());
  EXPECT_EQ(b.ask({0x0D}).size(), 7u);
}

TEST(Emulator, ResetSensorKeepsTheFractionOfATurn) {
  Bench b;
  b.bus.addBoard("B3M", 1);
  b.plant.positions = {1024 * 3 + 17, -1, 0, 0};
  b.ask({0x51, 1, 0});
  const Bytes answer = b.ask({0x21});
  EXPECT_EQ(answer.size(), 17u);
  EXPECT_EQ(answer[1] | answer[2] << 8, 17);
  EXPECT_EQ(answer[3] | answer[4] << 8, 1023);
}

TEST(Emulator, ACommandForALongerBoardIsSkippedOnlyAfterTheLesson) {
  Bench b;
  b.bus.addBoard("B3M", 1);
  Bytes current(17, 0x09);  // payload of a B5M's CURRENT for id 2 that looks like a probe of board 1
  current[0] = 0x32;
  EXPECT_FALSE(b.ask(current).empty());  // board 1 skips 9 bytes and answers the rest
  Bytes lesson = {0x12, 1, 1, 13, 85, 1, 33, 17, 20, 84, 34, 3, 2};
  EXPECT_TRUE(b.ask(lesson).empty());
  EXPECT_TRUE(b.ask(current).empty());
}

TEST(Emulator, NinetyZerosEndAnyPacket) {
  Bench b;
  b.bus.addBoard("B5M", 1);
  const std::uint8_t cut = 0x19;  // ALL, 85 bytes, cut off behind its header
  b.bus.receive(&cut, 1, 0);
  EXPECT_TRUE(b.ask({0x09}, 26).size() != 7u);  // swallowed as payload (the answer to ALL came instead)
  Bytes resync(90, 0);
  resync.push_back(0x09);
  EXPECT_EQ(b.ask(resync).size(), 7u);
}

TEST(Emulator, RepliesWithoutASlotCollide) {
  for (const int slot : {0, 28}) {
    Bench b;
    b.bus.addBoard("B3M", 1);
    b.bus.addBoard("B3M", 2);
    Bytes two(9 + slot, 0);
    two[0] = 0x31;
    two.push_back(0x32);
    two.insert(two.end(), 8, 0);
    b.ask(two);
    EXPECT_EQ(b.bus.collisions() > 0, slot == 0);
  }
}

TEST(Emulator, AReplyTakesItsTimeOnTheWire) {
  Bench b;
  b.bus.addBoard("B5M", 1);
  Bytes cycle(61, 0);
  cycle[0] = 0x31;
  b.bus.receive(cycle.data(), cycle.size(), 0);
  // Seen with the 6th byte (30 µs), answered 25 µs later, 41 bytes of 5 µs.
  EXPECT_EQ(b.bus.nextByteAt(), 30000 + 25000 + 5000);
  EXPECT_EQ(b.bus.quietAt(), 30000 + 25000 + 41 * 5000);
}

TEST(Emulator, ABoardWithoutPowerIsSilentAndWithoutCurrent) {
  Bench b;
  b.bus.addBoard("B3M", 1);
  b.ask({0x31, 0x64, 0, 0, 0, 0, 0, 0, 0});
  b.bus.board(1)->setPower(false);
  EXPECT_EQ(b.plant.digits[0], 0);
  EXPECT_TRUE(b.ask({0x09}).empty());
  b.bus.board(1)->setPower(true);
  EXPECT_EQ(b.ask({0x09}).size(), 7u);
}

TEST(Emulator, AnyBytesDoNoHarm) {
  Bench b;
  b.bus.addBoard("B3M", 1);
  b.bus.addBoard("B5M", 2);
  std::uint32_t state = 1;
  Bytes noise(100);
  for (int n = 0; n < 3000; ++n) {
    for (auto& byte : noise) byte = static_cast<std::uint8_t>((state = state * 1664525u + 1013904223u) >> 24);
    b.ask(noise, 0);
  }
  for (int i = 0; i < 12; ++i) EXPECT_LE(std::abs(b.plant.digits[i]), 4095);
}

TEST(Emulator, OrdersAreCarriedOutOrExplained) {
  DeviceDef device = plainDevice({"B5M"}, 8);
  for (int i = 0; i < 8; ++i) {
    device.strings[i].p_BE = Vector3(i & 1 ? 0.1 : -0.1, i & 2 ? 0.1 : -0.1, i & 4 ? 0.1 : -0.1);
    device.strings[i].p_GK = 0.2 * Vector3(i & 2 ? 0.1 : -0.1, i & 4 ? 0.1 : -0.1, i & 1 ? 0.1 : -0.1);
  }
  TwinPlant plant(device, {});
  BoardBusEmulator bus(plant);
  bus.addBoard("B5M", 1);
  bool stop = false;
  for (const char* good :
       {"drop 3", "corrupt 1", "duplicate 1", "insert 2", "board_drop 1", "delay 2 1.5", "kill 1", "revive 1",
        "slack 0 0.01", "slip 1 500", "freeze 2", "snap 3", "mend 0", "hand rest"})
    EXPECT_EQ(carryOut(good, bus, plant, nullptr, stop), "") << good;
  for (const char* bad : {"", "fly", "kill", "kill 5", "hand nowhere", "unplug", "explode 3"})
    EXPECT_NE(carryOut(bad, bus, plant, nullptr, stop), "") << bad;
  EXPECT_FALSE(stop);
  EXPECT_EQ(carryOut("quit", bus, plant, nullptr, stop), "");
  EXPECT_TRUE(stop);
  EXPECT_EQ(plant.position(1), 500);
  EXPECT_EQ(parseTimedFault("2.5 kill 1").order, "kill 1");
  EXPECT_THROW(parseTimedFault("soon"), SetupError);
}

}  // namespace emulator_test
}  // namespace haptic
