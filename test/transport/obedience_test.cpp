// Boards that answer and do not do what they are told, and boards that are accused of it without reason.
#include <gtest/gtest.h>

#include <random>

#include "emulated_device.h"

namespace haptic {
namespace obedience_test {

constexpr int kSeenWithin = 50;  // ticks of 1 ms, of figures.md

DriveCommand pull(const DeviceDef& device, double newtons) {
  DriveCommand command;
  for (std::size_t i = 0; i < device.strings.size(); ++i) command.voltage[i] = newtons * device.strings[i].volt_per_newton;
  return command;
}

struct Case {
  std::vector<BoardAt> boards;
  std::vector<std::string> models;
};
const Case kCases[] = {{{{"B5M", 1}}, {"B5M"}}, {{{"B3M", 1}, {"B3M", 2}}, {"B3M", "B3M"}}};

/// Ticks from now until the wire finds something; 2000: never.
int ticksUntilFound(EmulatedDevice& e, const DriveCommand& command, DeviceSample& found) {
  for (int k = 1; k < 2000; ++k) {
    found = e.tick(command);
    if (found.finding != WireFinding::kNone) return k;
  }
  return 2000;
}

/// The board answers each question, names the parameters that it was asked for, and cuts its currents short, by whatever number of bytes;
/// also those of its neighbour, whose rest it takes for headers. At every instant between two lessons.
TEST(Obedience, ASpoiltTableActsForLessThan50Ms) {
  for (const Case& c : kCases)
    for (const BoardAt& board : c.boards)
      for (const BoardAt& row : c.boards)
        for (int length = 0; length < 17; ++length)
          for (int start = 300; start < 330; start += 7) {
            const DeviceDef device = plainDevice(c.models, 8);
            EmulatedDevice e(c.boards, device);
            EmulatedBoard& spoilt = *e.bus.board(board.id);
            const int sound = commandBytes(e.bus.board(row.id)->shape(), BoardCommand::kCurrent);
            if (length == sound) continue;
            for (int k = 0; k < start; ++k) ASSERT_EQ(e.tick(pull(device, 1.3)).finding, WireFinding::kNone) << k;
            spoilt.spoilTable(row.id, BoardCommand::kCurrent, length);
            int acts = 0;
            WireFinding found = WireFinding::kNone;
            while (acts < 2000 && spoilt.tableLength(row.id, BoardCommand::kCurrent) == length && found == WireFinding::kNone) {
              found = e.tick(pull(device, 1.3)).finding;
              ++acts;
            }
            EXPECT_LE(acts, kSeenWithin) << "board " << board.id << " row " << row.id << " length " << length << " from tick " << start;
          }
}

/// It cannot be taught, whatever its table makes of SET_CMDLEN: such a board is named, and told to be switched off.
TEST(Obedience, ABoardThatCannotBeTaughtIsNamed) {
  for (const Case& c : kCases)
    for (const BoardAt& board : c.boards)
      for (const int length : {0, 1, 4, 8, 11, 12}) {
        const DeviceDef device = plainDevice(c.models, 8);
        EmulatedDevice e(c.boards, device);
        for (int k = 0; k < 600; ++k) ASSERT_EQ(e.tick(pull(device, 1.3)).finding, WireFinding::kNone) << k << e.driver->trouble();
        e.bus.board(board.id)->spoilTable(board.id, BoardCommand::kSetCommandLength, length);
        const int whole = commandBytes(e.bus.board(board.id)->shape(), BoardCommand::kCurrent);
        e.bus.board(board.id)->spoilTable(board.id, BoardCommand::kCurrent, whole - 1);
        DeviceSample found;
        EXPECT_LE(ticksUntilFound(e, pull(device, 1.3), found), 200) << "board " << board.id << " length " << length;
        EXPECT_TRUE(e.driver->trouble().find("board " + std::to_string(board.id)) != std::string::npos) << e.driver->trouble();
      }
}

/// No current on the way to a motor is ever another one than the one that is wanted: nothing is put into the hand to find something out.
TEST(Obedience, ExaminingABoardMovesNoCurrent) {
  for (const Case& c : kCases)
    for (const double newtons : {0.3, 0.9, 2.0, 5.0}) {
      const DeviceDef device = plainDevice(c.models, 8);
      EmulatedDevice e(c.boards, device);
      for (int k = 0; k < 50; ++k) e.tick(pull(device, newtons));
      const double wanted = newtons * 0.091 * 4096 / 3.3;
      e.plant.lowest = e.plant.highest = e.plant.digits;
      for (int k = 0; k < 1000; ++k) e.tick(pull(device, newtons));
      for (int i = 0; i < 8; ++i) {
        const int sign = i % 2 ? -1 : 1;
        EXPECT_NEAR(e.plant.lowest[i] * sign, wanted, 3);  // truncated, and away from the headers that move boards
        EXPECT_NEAR(e.plant.highest[i] * sign, wanted, 3);
      }
      EXPECT_EQ(e.report().retaught, 0u) << e.driver->trouble();
      EXPECT_EQ(e.report().doubled, 0u);
    }
}

TEST(Obedience, AWrongModeIsSeenSoonAndNamed) {
  for (const Case& c : kCases)
    for (const BoardAt& board : c.boards) {
      const DeviceDef device = plainDevice(c.models, 8);
      EmulatedDevice e(c.boards, device);
      for (int k = 0; k < 400; ++k) ASSERT_EQ(e.tick(pull(device, 1)).finding, WireFinding::kNone) << k;
      e.bus.board(board.id)->holdMode(static_cast<int>(BoardMode::kDirect));
      DeviceSample found;
      EXPECT_LE(ticksUntilFound(e, pull(device, 1), found), kSeenWithin);
      EXPECT_EQ(found.finding, WireFinding::kWrongMode) << e.driver->trouble();
      EXPECT_EQ(found.board, board.id);
    }
}

/// Boards that measure their currents say so; those that do not are not accused either.
TEST(Obedience, IgnoredCurrentsAreSeenWhereTheyAreMeasured) {
  for (const Case& c : kCases) {
    const DeviceDef device = plainDevice(c.models, 8);
    EmulatedDevice e(c.boards, device);
    for (int k = 0; k < 400; ++k) ASSERT_EQ(e.tick(pull(device, 1 + 0.5 * (k / 50 % 2))).finding, WireFinding::kNone) << k;
    e.bus.board(c.boards.back().id)->setObeys(false);
    DeviceSample found;
    const int seen = ticksUntilFound(e, pull(device, 2.5), found);
    if (c.boards.size() == 2) {
      EXPECT_LE(seen, 200);
      EXPECT_EQ(found.finding, WireFinding::kCurrentsIgnored);
      EXPECT_EQ(found.board, c.boards.back().id);
    } else {
      EXPECT_EQ(found.finding, WireFinding::kNone);
    }
  }
}

/// Of forces that change by 1 N/s, as slowly as that, while the sensors are off by a tenth.
TEST(Obedience, IgnoredSlowCurrentsAreSeen) {
  const Case& c = kCases[1];
  const DeviceDef device = plainDevice(c.models, 8);
  EmulatedDevice e(c.boards, device);
  const auto slow = [](int k) { return 1.5 + std::abs(k % 1000 - 500) * 1e-3; };
  for (int k = 0; k < 1200; ++k) ASSERT_EQ(e.tick(pull(device, slow(k))).finding, WireFinding::kNone) << k;
  e.bus.board(1)->setObeys(false);
  int seen = 0;
  for (int k = 1; k <= 2000 && !seen; ++k)
    if (e.tick(pull(device, slow(1200 + k))).finding == WireFinding::kCurrentsIgnored) seen = k;
  EXPECT_GT(seen, 0);
  EXPECT_LE(seen, 200);
}

/// Currents that change all the time, late ticks and late answers: twenty seconds without an accusation.
TEST(Obedience, ASoundBoardIsNotAccused) {
  for (const Case& c : kCases) {
    const DeviceDef device = plainDevice(c.models, 8);
    EmulatedDevice e(c.boards, device);
    std::mt19937 random(5);
    DriveCommand command;
    for (int k = 0; k < 20000; ++k) {
      for (std::size_t i = 0; i < 8; ++i)
        command.voltage[i] = (0.3 + 5.7e-3 * static_cast<double>(random() % 1000)) * device.strings[i].volt_per_newton;
      if (random() % 50 == 0) e.bus.delayReplies(1, 1000 * static_cast<std::int64_t>(random() % 3000));
      if (random() % 100 == 0) e.line.now_ns += 1000 * static_cast<std::int64_t>(random() % 5000);
      const DeviceSample s = e.tick(command);
      ASSERT_EQ(s.finding, WireFinding::kNone) << k << ": " << e.driver->trouble();
    }
  }
}

/// One counter that is off, by a whole turn too, is its string's business. A board that started anew has all of them within a turn of
/// zero, each with its fraction of a turn.
TEST(Obedience, AJumpOfOneCounterIsNoLossOfPower) {
  const DeviceDef device = plainDevice({"B5M"}, 8);
  for (const int jump : {150, 200, -1024, -1100, 700, 4000}) {
    EmulatedDevice e({{"B5M", 1}}, device);
    for (int i = 0; i < 8; ++i) e.plant.positions[i] = 3000 + 100 * i;
    for (int k = 0; k < 300; ++k) e.tick(pull(device, 1));
    e.plant.positions[3] += jump;
    DeviceSample s;
    for (int k = 0; k < 100; ++k) {
      s = e.tick(pull(device, 1));
      ASSERT_NE(s.status, LinkStatus::kRestarted) << jump;
      ASSERT_EQ(s.finding, WireFinding::kNone) << jump << e.driver->trouble();
    }
    EXPECT_EQ(s.counts[3], 3300 + jump);
    for (int i = 0; i < 8; ++i) e.plant.positions[i] %= 1024;
    bool said = false;
    for (int k = 0; k < 10 && !said; ++k) said = e.tick(pull(device, 1)).status == LinkStatus::kRestarted;
    EXPECT_TRUE(said);
  }
}

/// The whole machine stood still, boards' emulation and all: what is owed from before accuses nobody.
TEST(Obedience, AStoppedMachineAccusesNoBoard) {
  for (const std::int64_t gap_ms : {12, 67, 300}) {
    const DeviceDef device = plainDevice({"B3M", "B3M"}, 8);
    EmulatedDevice e({{"B3M", 1}, {"B3M", 2}}, device);
    for (int k = 0; k < 300; ++k) e.tick(pull(device, 1));
    e.bus.delayReplies(2, gap_ms * 1000000 + 3000000);  // the answers come 3 ms after the machine is back
    e.tick(pull(device, 1));
    e.line.now_ns += gap_ms * 1000000;
    e.start_ns += gap_ms * 1000000;
    for (int k = 0; k < 200; ++k)
      ASSERT_EQ(e.tick(pull(device, 1)).finding, WireFinding::kNone) << gap_ms << ' ' << k << e.driver->trouble();
  }
}

}  // namespace obedience_test
}  // namespace haptic
