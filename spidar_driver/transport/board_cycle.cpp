#include "spidar_driver/transport/board_cycle.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "haptic_core/base/error.h"
#include "spidar_driver/transport/board_protocol.h"
#include "spidar_driver/transport/drive_limits.h"

namespace haptic {
namespace {

constexpr int kBitsPerByte = 10;           // 8N1
constexpr std::int64_t kSpareNs = 100000;  // least wait beyond the cycle's wire time: the adapter's latency
constexpr double kWaitShare = 0.8;         // of the period; the rest is left to the tick
/// The nearest current whose low byte is none of them: one digit less for each board on the bus at most, 0.01
/// N each; more where less would be below `least`.
int harmlessDigit(int digit, int least, const std::vector<FoundBoard>& boards) {
  const int away = digit > 0 ? 1 : -1;
  int smaller = digit, greater = digit;
  for (int i = 0; i < kMaxBoards && movesBoards(smaller & 0xFF, boards); ++i) smaller -= away;
  for (int i = 0; i < kMaxBoards && movesBoards(greater & 0xFF, boards); ++i) greater += away;
  return std::abs(smaller) >= std::abs(least) ? smaller : greater;
}

}  // namespace

BoardCycle::BoardCycle(const DeviceDef& device, const UartSettings& settings,
                       const std::vector<FoundBoard>& boards)
    : device_(device), boards_(boards) {
  byte_ns = static_cast<std::int64_t>(1e9 * kBitsPerByte / settings.baud);
  layOut();
  max_rate_hz = std::min(1e9 / static_cast<double>(cycle_ns), device_.max_rate_hz);
  if (!(settings.rate_hz > 0) || settings.rate_hz > max_rate_hz) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "%.0f Hz asked, but the wire carries at most %.0f Hz (%zu bytes a cycle, %d baud)",
                  settings.rate_hz, max_rate_hz, cycle_bytes_, settings.baud);
    throw SetupError(device_.name, text, "set the rate to at most that");
  }
  slot_ns = static_cast<std::int64_t>(std::ceil(1e9 / max_rate_hz - 1e-3));
  period_ns = static_cast<std::int64_t>(1e9 / settings.rate_hz);
  const double wait_s = settings.reply_wait_s > 0 ? settings.reply_wait_s : kWaitShare / settings.rate_hz;
  wait_ns = std::max(static_cast<std::int64_t>(wait_s * 1e9), cycle_ns + kSpareNs);
}

void BoardCycle::layOut() {
  int channel = 0;
  std::size_t longest_mark = 0, longest = 0;
  for (int b = 0; b < boardCount(); ++b) {
    const BoardShape& shape = *boards_[b].shape;
    cycle_offset_[b] = static_cast<int>(cycle_bytes_);
    slot_bytes_[b] = commandBytes(shape, BoardCommand::kCurrent) + paddingBytes(shape, BoardCommand::kCurrent);
    first_channel_[b] = channel;
    channel = std::min(channel + shape.motors, static_cast<int>(device_.strings.size()));
    cycle_bytes_ += static_cast<std::size_t>(slot_bytes_[b]);
    state_mark_[b] = stateQuestion(boards_[b]);
    info_mark_[b] = infoQuestion(boards_[b].id, 0);
    for (int k = 0; k < 2; ++k) memory_mark_[b][k] = paramQuestion(boards_[b], BoardMemory::kParams[k]);
    longest_mark = std::max({longest_mark, info_mark_[b].size(), memory_mark_[b][0].size()});
    longest = std::max({longest, longest_mark, state_mark_[b].size()});
  }
  cycle_.assign(cycle_bytes_ + longest, 0);
  for (const BoardLesson::Kind kind : {BoardLesson::kShort, BoardLesson::kLong}) {
    lesson_[kind] = lengthLesson(boards_, 0, BoardLesson::kInfoBytes[kind]);
    for (int b = 0; b < boardCount(); ++b) {
      exam_[b][kind] = lesson_[kind];
      const std::vector<std::uint8_t> question = lessonQuestion(boards_[b].id);
      exam_[b][kind].insert(exam_[b][kind].end(), question.begin(), question.end());
    }
  }
  encode(DriveCommand{}, false);
  zero_.assign(kZeroLead, 0);
  zero_.insert(zero_.end(), cycle_.begin(), cycle_.begin() + static_cast<std::ptrdiff_t>(cycle_bytes_));
  cycle_ns = static_cast<std::int64_t>(cycle_bytes_) * byte_ns;
  longest_mark_ns = static_cast<std::int64_t>(longest_mark) * byte_ns;
}

int BoardCycle::boardOf(int id) const noexcept {
  for (int b = 0; b < boardCount(); ++b)
    if (boards_[b].id == id) return b;
  return -1;
}

CurrentCommand BoardCycle::packetOf(int board, const DriveCommand& command, Drive& drive) noexcept {
  const BoardShape& shape = *boards_[board].shape;
  const int strings = static_cast<int>(device_.strings.size());
  CurrentCommand packet;
  for (int m = 0; m < shape.motors && first_channel_[board] + m < strings; ++m) {
    const int channel = first_channel_[board] + m;
    bool clamped = false;
    const StringDef& string = device_.strings[channel];
    const int digit = driveDigit(shape, allowedVoltage(string, command.voltage[channel], clamped));
    const int least = driveDigit(shape, string.min_tension * string.volt_per_newton);
    const bool weak = std::abs(digit) < std::abs(least);
    packet.current[m] = static_cast<std::int16_t>(harmlessDigit(digit, weak ? 0 : least, boards_));
    digit_[static_cast<std::size_t>(channel)] = packet.current[m];
    drive.clamped = drive.clamped || clamped;
    drive.pulls = drive.pulls || std::abs(digit) > std::abs(least);
    drive.armed = drive.armed || packet.current[m] != 0;
  }
  return packet;
}

BoardCycle::Drive BoardCycle::encode(const DriveCommand& command, bool usable) noexcept {
  Drive drive;
  digit_.fill(0);
  for (int b = 0; b < boardCount(); ++b) {
    CurrentCommand packet;
    if (usable) packet = packetOf(b, command, drive);
    const std::size_t at = static_cast<std::size_t>(cycle_offset_[b]);
    std::fill_n(cycle_.begin() + static_cast<std::ptrdiff_t>(at), slot_bytes_[b], std::uint8_t{0});
    encodePacket(*boards_[b].shape, boards_[b].id, packet, cycle_.data() + at, cycle_bytes_ - at);
  }
  return drive;
}

std::size_t BoardCycle::append(const std::vector<std::uint8_t>& mark) noexcept {
  std::copy(mark.begin(), mark.end(), cycle_.begin() + static_cast<std::ptrdiff_t>(cycle_bytes_));
  return cycle_bytes_ + mark.size();
}

}  // namespace haptic
