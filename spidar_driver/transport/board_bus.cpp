#include "spidar_driver/transport/board_bus.h"

#include <algorithm>
#include <array>

#include "haptic_core/base/error.h"
#include "spidar_driver/transport/reply_stream.h"

namespace haptic {
namespace {

constexpr int kProbePadding = 26;                // reply of 7 bytes − 1 + 20, as in a cycle
constexpr int kLessonPadding = 5;                // fills the FIFO behind a command without reply
constexpr int kScanTries = 2, kPatientTries = 20;  // the latter while boards are missing: 1.3 s
constexpr std::int64_t kPaceNs = 2 * kMs;        // between probes: one takes 1.4 ms of the wire
constexpr std::int64_t kSlowestNs = 50 * kMs;    // an adapter that delivers in bursts of 16 ms, twice and some
constexpr std::int64_t kScanQuietNs = 25 * kMs;  // longer than a burst: nothing is on its way any more
constexpr std::int64_t kScanPatienceNs = 300 * kMs;  // for a line that does not fall silent

bool plausible(const InfoReply& info) {
  const int channels = info.motors + info.currents + info.forces;
  return info.model > 0 && channels > 0 && channels < 100;
}

/// Hears until `deadline_ns`; bounded in bytes as well, for a line that speaks without end.
template <class Take>
void hear(ByteLink& link, ReplyStream& stream, std::int64_t deadline_ns, Take&& take) {
  std::array<std::uint8_t, 256> in;
  for (int reads = 0; reads < 1000; ++reads) {
    const int got = link.read(in.data(), in.size(), deadline_ns);
    if (got <= 0) break;
    stream.feed(in.data(), static_cast<std::size_t>(got), take);
  }
  stream.settle(take);
}

}  // namespace

std::vector<std::uint8_t> infoQuestion(int id, int lead) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(lead + 1 + kProbePadding), 0);
  bytes[static_cast<std::size_t>(lead)] = headerByte(BoardCommand::kBoardInfo, id);
  return bytes;
}

std::vector<std::uint8_t> paramQuestion(const FoundBoard& board, int type) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(commandBytes(*board.shape, BoardCommand::kGetParam) +
                                                           paddingBytes(*board.shape, BoardCommand::kGetParam)), 0);
  bytes[0] = headerByte(BoardCommand::kGetParam, board.id);
  bytes[1] = static_cast<std::uint8_t>(type);
  return bytes;
}

bool decodeInfo(const std::uint8_t* bytes, int size, int id, InfoReply& info) {
  return decodePacket(*findBoardModel(1), id, bytes, static_cast<std::size_t>(size), info) && plausible(info);
}

void drainLink(ByteLink& link) {
  std::array<std::uint8_t, 256> in;
  const std::int64_t end = link.now() + kScanPatienceNs;
  for (int reads = 0; reads < 1000 && link.now() < end; ++reads)
    if (link.read(in.data(), in.size(), link.now() + kScanQuietNs) <= 0) return;
}

namespace {

std::string listed(const std::vector<std::string>& models) {
  std::string text;
  for (const std::string& m : models) text += (text.empty() ? "" : ", ") + m;
  return text;
}

}  // namespace

std::string listed(const std::vector<FoundBoard>& boards) {
  std::string text;
  for (const FoundBoard& b : boards)
    text += (text.empty() ? "" : ", ") + std::string(b.shape->name) + " (id " + std::to_string(b.id) + ")";
  return text;
}

BusScan scanBus(ByteLink& link, std::size_t expected) {
  drainLink(link);
  ReplyStream stream;
  for (int id = 0; id < kMaxBoards; ++id) stream.know(headerByte(BoardCommand::kBoardInfo, id), kInfoBytes);
  std::array<InfoReply, kMaxBoards> info;
  std::array<bool, kMaxBoards> answered{};
  std::size_t foreign = 0;
  std::int64_t asked_ns = 0, late_ns = 0;
  const auto missing = [&] {
    return static_cast<std::size_t>(std::count(answered.begin(), answered.end(), true)) < expected;
  };
  const auto take = [&](const std::uint8_t* bytes, int size) {
    const int id = bytes[0] & 7;
    InfoReply said;
    if (decodeInfo(bytes, size, id, said)) {
      info[id] = said;
      if (!answered[id] && asked_ns > 0) late_ns = std::max(late_ns, link.now() - asked_ns);
      answered[id] = true;
    } else {
      foreign += static_cast<std::size_t>(size);
    }
  };
  for (int i = 0; i < kScanTries || (i < kPatientTries && missing()); ++i) {
    for (int id = 0; id < kMaxBoards && i < kScanTries; ++id) {  // then only late answers are waited for
      if (answered[id]) continue;
      const std::vector<std::uint8_t> question = infoQuestion(id, kResyncZeros);
      link.write(question.data(), question.size());
      hear(link, stream, link.now() + kPaceNs, take);
    }
    if (i == 0) asked_ns = link.now();
    hear(link, stream, link.now() + kSlowestNs, take);
    stream.abandon();
  }
  BusScan scan;
  scan.late_ns = late_ns;
  scan.foreign_bytes = foreign + stream.foreign();
  for (int id = 0; id < kMaxBoards; ++id) {
    if (!answered[id]) continue;
    const BoardShape* shape = findBoardModel(info[id].model);
    if (shape && shape->motors == info[id].motors)
      scan.boards.push_back({id, shape});
    else
      scan.unknown = "id " + std::to_string(id) + ": model " + std::to_string(info[id].model) + ", " +
                     std::to_string(info[id].motors) + " motors";
  }
  return scan;
}

bool movesBoards(int byte, const std::vector<FoundBoard>& boards) {
  for (const FoundBoard& b : boards)
    for (const BoardCommand c : {BoardCommand::kAll, BoardCommand::kDirect, BoardCommand::kInterpolate, BoardCommand::kForceControl})
      if (byte == headerByte(c, b.id)) return true;
  return spoilsBoards(byte, boards);
}

std::vector<std::uint8_t> stateQuestion(const FoundBoard& board) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(commandBytes(*board.shape, BoardCommand::kAll) +
                                                           paddingBytes(*board.shape, BoardCommand::kAll)), 0);
  bytes[0] = headerByte(BoardCommand::kAll, board.id);
  return bytes;
}

bool spoilsBoards(int byte, const std::vector<FoundBoard>& boards) {
  for (const FoundBoard& b : boards)
    for (const BoardCommand c : {BoardCommand::kSetCommandLength, BoardCommand::kSetParam, BoardCommand::kResetSensor})
      if (byte == headerByte(c, b.id)) return true;
  return false;
}

namespace {

/// A board that is out of step takes a length for a header: 17, the length of a B3M's DIRECT, is SET_CMDLEN for board 1, and
/// what follows spoils its table for good. A longer command waits for the zeros behind it. CURRENT, the cycle's own, stays.
std::uint8_t taughtLength(BoardCommand command, const BoardShape& shape, const std::vector<FoundBoard>& boards) {
  int bytes = commandBytes(shape, command);
  while (command != BoardCommand::kCurrent && spoilsBoards(bytes, boards)) ++bytes;  // 8 ids have a header each: 8 times
  return static_cast<std::uint8_t>(bytes);
}

}  // namespace

std::vector<std::uint8_t> lengthLesson(const std::vector<FoundBoard>& boards, int padding, int info_bytes) {
  std::vector<std::uint8_t> bytes;
  for (const FoundBoard& board : boards) {
    LengthCommand lengths;
    for (int c = 0; c < kBoardCommands; ++c)
      lengths.bytes[c] = taughtLength(static_cast<BoardCommand>(c), *board.shape, boards);
    lengths.bytes[static_cast<std::size_t>(BoardCommand::kBoardInfo)] = static_cast<std::uint8_t>(info_bytes);
    std::array<std::uint8_t, 1 + kBoardCommands> packet;
    encodePacket(*board.shape, board.id, lengths, packet.data(), packet.size());
    bytes.insert(bytes.end(), packet.begin(), packet.end());
    bytes.insert(bytes.end(), static_cast<std::size_t>(std::max(padding, kLessonPadding)), 0);
  }
  return bytes;
}

std::vector<std::uint8_t> lessonQuestion(int id) {
  std::vector<std::uint8_t> bytes(kLongInfoBytes - 1, 0);
  bytes[0] = headerByte(BoardCommand::kBoardInfo, id);
  const std::vector<std::uint8_t> again = infoQuestion(id, 0);
  bytes.insert(bytes.end(), again.begin(), again.end());
  return bytes;
}

std::vector<std::uint8_t> zeroForAnyTable() {
  const BoardShape& longest = *findBoardModel("B5M");
  std::vector<std::uint8_t> bytes(kResyncZeros, 0);
  for (const BoardCommand command : {BoardCommand::kCurrent, BoardCommand::kAll})
    for (int id = 0; id < kMaxBoards; ++id) {
      const std::size_t at = bytes.size();
      bytes.resize(at + static_cast<std::size_t>(commandBytes(longest, command)), 0);
      bytes[at] = headerByte(command, id);
      if (command == BoardCommand::kAll) bytes[at + 1] = static_cast<std::uint8_t>(BoardMode::kCurrent);
    }
  bytes.insert(bytes.end(), kResyncZeros, 0);
  return bytes;
}

std::vector<FoundBoard> matchBoards(const BusScan& scan, const DeviceDef& device, const std::string& port) {
  if (!scan.unknown.empty())
    throw SetupError(port, "a board of unknown model answers (" + scan.unknown + ")",
                     "known are " + boardModelNames() + "; take it off the bus or use a matching firmware");
  if (scan.boards.empty() && scan.foreign_bytes > 0)
    throw SetupError(port, "bytes come back that are no motor board's answer",
                     "check the baud rate (boards use 2000000) and that this is the boards' port");
  if (scan.boards.empty())
    throw SetupError(port, "no motor board answers",
                     "switch the boards' power on, check the cable and that this is the boards' port");
  const std::string found = listed(scan.boards);
  if (!device.boards.empty()) {
    if (scan.boards.size() < device.boards.size())
      throw SetupError(port, device.name + " needs " + listed(device.boards) + ", found only " + found,
                       "check power and cable of the others; each needs an id of its own (0-7)");
    for (std::size_t i = 0; i < device.boards.size(); ++i)
      if (device.boards[i] != scan.boards[i].shape->name)
        throw SetupError(
            port, device.name + " needs " + listed(device.boards) + ", found " + found,
            "choose the device file that belongs to these boards, or correct `boards` in " + device.file);
    return {scan.boards.begin(), scan.boards.begin() + static_cast<std::ptrdiff_t>(device.boards.size())};
  }
  std::size_t motors = 0;
  for (const FoundBoard& b : scan.boards) motors += b.shape->motors;
  if (motors < device.strings.size())
    throw SetupError(port,
                     device.name + " has " + std::to_string(device.strings.size()) + " strings, found " +
                         found + " with " + std::to_string(motors) + " motors",
                     "connect the missing board or choose another device file");
  return scan.boards;
}

}  // namespace haptic
