// Packet lengths and layouts against the published tables, which were typed in by hand from them: the code
// derives its lengths from the layouts, the tables were printed by another compiler from other sources.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "spidar_driver/transport/board_bus.h"
#include "spidar_driver/transport/board_protocol.h"

namespace haptic {
namespace board_layout_test {

struct LengthRow {
  const char* models[2];
  int command[kBoardCommands], reply[kBoardCommands];
};

constexpr LengthRow kTable[] = {
    {{"B1M", "B2M"}, {1, 1, 13, 21, 1, 17, 9, 12, 12, 18, 3, 2}, {0, 7, 0, 21, 9, 17, 17, 12, 12, 0, 0, 18}},
    {{"B1F", "B2F"}, {1, 1, 13, 23, 1, 13, 7, 10, 22, 14, 3, 2}, {0, 7, 0, 21, 11, 13, 17, 10, 10, 0, 0, 14}},
    {{"B3M", "B3M"}, {1, 1, 13, 21, 1, 17, 9, 12, 12, 18, 3, 2}, {0, 7, 0, 29, 17, 17, 17, 12, 12, 0, 0, 18}},
    {{"B3F", "B3F"}, {1, 1, 13, 23, 1, 13, 7, 10, 22, 14, 3, 2}, {0, 7, 0, 27, 17, 13, 17, 10, 10, 0, 0, 14}},
    {{"B5M", "B5M"},
     {1, 1, 13, 85, 1, 33, 17, 20, 84, 34, 3, 2},
     {0, 7, 0, 45, 25, 33, 41, 20, 20, 0, 0, 34}}};

std::vector<BoardShape> allShapes() {
  std::vector<BoardShape> shapes;
  for (int model = 1; model <= 7; ++model) shapes.push_back(*findBoardModel(model));
  return shapes;
}

TEST(BoardLayout, LengthsAreThoseOfTheTable) {
  for (const LengthRow& row : kTable)
    for (const char* name : row.models) {
      const BoardShape* shape = findBoardModel(std::string(name));
      ASSERT_TRUE(shape);
      for (int c = 0; c < kBoardCommands; ++c) {
        EXPECT_EQ(commandBytes(*shape, static_cast<BoardCommand>(c)), row.command[c])
            << name << " command " << c;
        EXPECT_EQ(replyBytes(*shape, static_cast<BoardCommand>(c)), row.reply[c]) << name << " command " << c;
      }
    }
}

TEST(BoardLayout, ModelsHaveTheNumbersOfTheTable) {
  const char* names[] = {"B1M", "B1F", "B2M", "B2F", "B3M", "B3F", "B5M"};
  for (int model = 1; model <= 7; ++model) EXPECT_STREQ(findBoardModel(model)->name, names[model - 1]);
  EXPECT_FALSE(findBoardModel(0));
  EXPECT_FALSE(findBoardModel(8));
  EXPECT_FALSE(findBoardModel(std::string("B9M")));
}

TEST(BoardLayout, HeadersAreThoseOfTheTable) {
  const int first[] = {0x00, 0x08, 0x10, 0x18, 0x20, 0x28, 0x30, 0x38, 0x40, 0x48, 0x50, 0x58};
  for (int c = 0; c < kBoardCommands; ++c)
    for (int id = 0; id < kMaxBoards; ++id)
      EXPECT_EQ(headerByte(static_cast<BoardCommand>(c), id), first[c] + id);
}

TEST(BoardLayout, PublishedExampleByteForByte) {
  const BoardShape& b3m = *findBoardModel(std::string("B3M"));
  CurrentCommand command;
  command.current = {100, -100, 0, 1};
  std::uint8_t bytes[16];
  ASSERT_EQ(encodePacket(b3m, 1, command, bytes, sizeof bytes), 9);
  const std::uint8_t expected[] = {0x31, 0x64, 0x00, 0x9C, 0xFF, 0x00, 0x00, 0x01, 0x00};
  EXPECT_TRUE(std::equal(expected, expected + 9, bytes));
  EXPECT_EQ(paddingBytes(b3m, BoardCommand::kCurrent), 28);
  EXPECT_EQ(paddingBytes(*findBoardModel(7), BoardCommand::kCurrent), 44);
  EXPECT_EQ(paddingBytes(b3m, BoardCommand::kSetCommandLength), 7);
}

/// Fills packet bytes with a counter, decodes, encodes: every byte must come back, so no field is left out,
/// doubled or out of place by itself; the order is held by the offsets below.
template <class Packet>
void roundTrip(const BoardShape& shape, int expected_bytes) {
  for (int id = 0; id < kMaxBoards; ++id) {
    std::vector<std::uint8_t> bytes(expected_bytes), again(expected_bytes);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(31 * i + 7);
    bytes[0] = headerByte(Packet::kCommand, id);
    Packet packet;
    ASSERT_TRUE(decodePacket(shape, id, bytes.data(), bytes.size(), packet)) << shape.name;
    EXPECT_EQ(encodePacket(shape, id, packet, again.data(), again.size()), expected_bytes);
    EXPECT_EQ(bytes, again) << shape.name;
    EXPECT_FALSE(decodePacket(shape, id, bytes.data(), bytes.size() - 1, packet));
    bytes.push_back(0);
    EXPECT_FALSE(decodePacket(shape, id, bytes.data(), bytes.size(), packet));
    EXPECT_FALSE(decodePacket(shape, (id + 1) % kMaxBoards, again.data(), again.size(), packet));
    EXPECT_EQ(encodePacket(shape, id, packet, again.data(), again.size() - 1), 0);
  }
}

template <class Packet>
void commandRoundTrip(const BoardShape& shape) {
  roundTrip<Packet>(shape, commandBytes(shape, Packet::kCommand));
}
template <class Packet>
void replyRoundTrip(const BoardShape& shape) {
  roundTrip<Packet>(shape, replyBytes(shape, Packet::kCommand));
}

TEST(BoardLayout, EveryPacketOfEveryModelRoundTrips) {
  for (const BoardShape& shape : allShapes()) {
    commandRoundTrip<InfoCommand>(shape);
    commandRoundTrip<LengthCommand>(shape);
    commandRoundTrip<AllCommand>(shape);
    commandRoundTrip<SensorCommand>(shape);
    commandRoundTrip<DirectPacket>(shape);
    commandRoundTrip<CurrentCommand>(shape);
    commandRoundTrip<InterpolateCommand>(shape);
    commandRoundTrip<ForceControlCommand>(shape);
    commandRoundTrip<ParamCommand>(shape);
    commandRoundTrip<ResetSensorCommand>(shape);
    commandRoundTrip<GetParamCommand>(shape);
    replyRoundTrip<InfoReply>(shape);
    replyRoundTrip<AllReply>(shape);
    replyRoundTrip<SensorReply>(shape);
    replyRoundTrip<DirectPacket>(shape);
    replyRoundTrip<CurrentReply>(shape);
    replyRoundTrip<InterpolateReply>(shape);
    replyRoundTrip<ForceControlReply>(shape);
    replyRoundTrip<ParamReply>(shape);
  }
}

std::int16_t wordAt(const std::vector<std::uint8_t>& bytes, int offset) {
  return static_cast<std::int16_t>(bytes[offset] | bytes[offset + 1] << 8);
}

TEST(BoardLayout, FieldsStandAtThePublishedOffsets) {
  const BoardShape& b5m = *findBoardModel(7);
  const BoardShape& b3f = *findBoardModel(6);
  std::vector<std::uint8_t> bytes(kMaxCommandBytes);

  CurrentReply reply;  // header, position[8], velocity[8], force[4]
  reply.position[7] = -32768;
  reply.velocity[0] = 32767;
  reply.force[3] = 1234;
  ASSERT_EQ(encodePacket(b5m, 5, reply, bytes.data(), bytes.size()), 41);
  EXPECT_EQ(bytes[0], 0x35);
  EXPECT_EQ(wordAt(bytes, 1 + 14), -32768);
  EXPECT_EQ(wordAt(bytes, 1 + 16), 32767);
  EXPECT_EQ(wordAt(bytes, 1 + 32 + 6), 1234);

  AllReply all;  // header, mode, count, u16 tick, position[3], velocity[3], current[3], force[2]
  all.mode = 3;
  all.target_count = 9;
  all.tick = 0xABCD;
  all.position[0] = 11;
  all.velocity[0] = 22;
  all.current[0] = 33;
  all.force[0] = 44;
  ASSERT_EQ(encodePacket(b3f, 2, all, bytes.data(), bytes.size()), 27);
  EXPECT_EQ(bytes[1], 3);
  EXPECT_EQ(bytes[2], 9);
  EXPECT_EQ(bytes[3], 0xCD);
  EXPECT_EQ(bytes[4], 0xAB);
  EXPECT_EQ(wordAt(bytes, 5), 11);
  EXPECT_EQ(wordAt(bytes, 11), 22);
  EXPECT_EQ(wordAt(bytes, 17), 33);
  EXPECT_EQ(wordAt(bytes, 23), 44);

  AllCommand order;  // header, mode, count, period, target[8], gradient[4][8]
  order.period = -2;
  order.target[1] = 77;
  order.gradient[31] = 88;
  ASSERT_EQ(encodePacket(b5m, 0, order, bytes.data(), bytes.size()), 85);
  EXPECT_EQ(wordAt(bytes, 3), -2);
  EXPECT_EQ(wordAt(bytes, 7), 77);
  EXPECT_EQ(wordAt(bytes, 83), 88);

  InfoReply info{5, 12, 4, 4, 0, 0};
  ASSERT_EQ(encodePacket(b5m, 1, info, bytes.data(), bytes.size()), 7);
  const std::uint8_t expected[] = {0x09, 5, 12, 4, 4, 0, 0};
  EXPECT_TRUE(std::equal(expected, expected + 7, bytes.begin()));

  ForceControlCommand force;  // header, position[3], jacobian[2][3], period, count
  force.jacobian[5] = 55;
  force.period = 66;
  force.target_count = 7;
  ASSERT_EQ(encodePacket(b3f, 1, force, bytes.data(), bytes.size()), 22);
  EXPECT_EQ(wordAt(bytes, 1 + 6 + 10), 55);
  EXPECT_EQ(wordAt(bytes, 1 + 18), 66);
  EXPECT_EQ(bytes[21], 7);
}

TEST(BoardLayout, DigitsOfVoltages) {
  const BoardShape& b3m = *findBoardModel(5);
  const BoardShape& b5m = *findBoardModel(7);
  // 4096 digits per 3.3 V, truncated toward zero: G6X4 0.08 V/N → 99.3 digits, G6X5 0.091 V/N → 112.95.
  EXPECT_EQ(driveDigit(b3m, 0.08), 99);
  EXPECT_EQ(driveDigit(b3m, -0.08), -99);
  EXPECT_EQ(driveDigit(b5m, 0.091), 112);
  EXPECT_EQ(driveDigit(b5m, 0.091 * 6), 677);
  EXPECT_EQ(driveDigit(b3m, 1e30), 4095);
  EXPECT_EQ(driveDigit(b3m, -1e30), -4095);
  EXPECT_EQ(driveDigit(b5m, 1e30), 1024);
  EXPECT_EQ(driveDigit(b5m, std::nan("")), 0);
  EXPECT_EQ(driveDigit(b5m, -HUGE_VAL), -1024);
}

TEST(BoardLayout, AnyBytesDecodeWithoutHarm) {
  std::mt19937 random(7);
  for (int n = 0; n < 20000; ++n) {
    const BoardShape& shape = *findBoardModel(1 + static_cast<int>(random() % 7));
    std::vector<std::uint8_t> bytes(random() % 100);
    for (auto& b : bytes) b = static_cast<std::uint8_t>(random());
    CurrentReply reply;
    const int id = static_cast<int>(random() % 8);
    const bool fits = bytes.size() == static_cast<std::size_t>(replyBytes(shape, BoardCommand::kCurrent)) &&
                      bytes[0] == headerByte(BoardCommand::kCurrent, id);
    EXPECT_EQ(decodePacket(shape, id, bytes.data(), bytes.size(), reply), fits);
  }
}

/// A board that is out of step takes the lengths in a lesson for headers: none may teach it nonsense.
TEST(BoardLayout, NoLengthInALessonButTheCyclesIsAHeaderThatSpoilsABoard) {
  for (const char* model : {"B1M", "B2M", "B3M", "B5M"}) {
    const BoardShape* shape = findBoardModel(model);
    for (int first = 0; first < kMaxBoards; ++first) {
      const std::vector<FoundBoard> boards = {{first, shape}, {(first + 1) % kMaxBoards, shape}};
      const std::vector<std::uint8_t> lesson = lengthLesson(boards, 0), longer = lengthLesson(boards, 0, kLongInfoBytes);
      EXPECT_FALSE(movesBoards(kLongInfoBytes, boards));
      EXPECT_EQ(longer[1 + static_cast<std::size_t>(BoardCommand::kBoardInfo)], kLongInfoBytes);
      for (int c = 0; c < kBoardCommands; ++c) {
        const auto command = static_cast<BoardCommand>(c);
        const int taught = lesson[1 + static_cast<std::size_t>(c)], true_bytes = commandBytes(*shape, command);
        const bool in_use = command == BoardCommand::kCurrent || command == BoardCommand::kGetParam;
        EXPECT_TRUE(in_use || !spoilsBoards(taught, boards)) << model << " " << first << " " << c;
        EXPECT_GE(taught, true_bytes);
        if (in_use || command == BoardCommand::kBoardInfo) {
          EXPECT_EQ(taught, true_bytes);
        }
      }
    }
  }
}

}  // namespace board_layout_test
}  // namespace haptic
