#include "spidar_driver/transport/board_bus.h"

#include <array>

#include "haptic_core/base/error.h"
#include "spidar_driver/transport/board_protocol.h"

namespace haptic {
namespace {

// Longest packet of any board: so many zeros end whatever a board believes to be inside of. Fewer, and a
// board that was cut off in ALL (85 bytes) takes the probe for payload.
constexpr int kResyncZeros = 90;
constexpr int kProbePadding = 26;                // reply of 7 bytes − 1 + 20, as in a cycle
constexpr int kLessonPadding = 5;                // fills the FIFO behind a command without reply
constexpr std::int64_t kProbeWaitNs = 10000000;  // a USB adapter with its latency timer at 1 ms needs 2–3 ms
constexpr int kTries = 2;

bool plausible(const InfoReply& info) {
  const int channels = info.motors + info.currents + info.forces;
  return info.model > 0 && channels > 0 && channels < 100;
}

/// True when id answers; what it says goes into `info`.
bool probe(ByteLink& link, int id, InfoReply& info, std::size_t& foreign) {
  std::array<std::uint8_t, kResyncZeros + 1 + kProbePadding> packet{};
  packet[kResyncZeros] = headerByte(BoardCommand::kBoardInfo, id);
  std::array<std::uint8_t, 256> in;
  while (link.read(in.data(), in.size(), 0) > 0) {
  }
  if (!link.write(packet.data(), packet.size())) return false;
  const int reply_bytes =
      replyBytes(*findBoardModel(1), BoardCommand::kBoardInfo);  // the same for all models
  int filled = 0;
  const std::int64_t deadline = link.now() + kProbeWaitNs;
  while (filled < reply_bytes) {
    const int got = link.read(in.data() + filled, in.size() - filled, deadline);
    if (got <= 0) break;
    filled += got;
  }
  const bool answered = decodePacket(*findBoardModel(1), id, in.data(), filled, info) && plausible(info);
  if (!answered) foreign += filled;
  return answered;
}

std::string listed(const std::vector<FoundBoard>& boards) {
  std::string text;
  for (const FoundBoard& b : boards)
    text += (text.empty() ? "" : ", ") + std::string(b.shape->name) + " (id " + std::to_string(b.id) + ")";
  return text;
}

std::string listed(const std::vector<std::string>& models) {
  std::string text;
  for (const std::string& m : models) text += (text.empty() ? "" : ", ") + m;
  return text;
}

}  // namespace

BusScan scanBus(ByteLink& link) {
  BusScan scan;
  for (int id = 0; id < kMaxBoards; ++id) {
    InfoReply info;
    bool answered = false;
    for (int i = 0; i < kTries && !answered; ++i) answered = probe(link, id, info, scan.foreign_bytes);
    if (!answered) continue;
    const BoardShape* shape = findBoardModel(info.model);
    if (shape && shape->motors == info.motors)
      scan.boards.push_back({id, shape});
    else
      scan.unknown = "id " + std::to_string(id) + ": model " + std::to_string(info.model) + ", " +
                     std::to_string(info.motors) + " motors";
  }
  return scan;
}

std::vector<std::uint8_t> lengthLesson(const std::vector<FoundBoard>& boards) {
  std::vector<std::uint8_t> bytes;
  for (const FoundBoard& board : boards) {
    LengthCommand lengths;
    for (int c = 0; c < kBoardCommands; ++c)
      lengths.bytes[c] = static_cast<std::uint8_t>(commandBytes(*board.shape, static_cast<BoardCommand>(c)));
    std::array<std::uint8_t, 1 + kBoardCommands> packet;
    encodePacket(*board.shape, board.id, lengths, packet.data(), packet.size());
    bytes.insert(bytes.end(), packet.begin(), packet.end());
    bytes.insert(bytes.end(), kLessonPadding, 0);
  }
  return bytes;
}

bool teachLengths(ByteLink& link, const std::vector<FoundBoard>& boards) {
  const std::vector<std::uint8_t> bytes = lengthLesson(boards);
  return link.write(bytes.data(), bytes.size());
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
