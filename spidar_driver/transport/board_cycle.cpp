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
// A board that is out of step takes the end of a lesson for another one and is spoilt by it: zeros go ahead.
constexpr int kLessonLead = 90;

/// The nearest current whose low byte is none of them: one digit less for each board on the bus at most, 0.01
/// N each; more where less would be below `least`.
int harmlessDigit(int digit, int least, const std::vector<FoundBoard>& boards) {
  const int away = digit > 0 ? 1 : -1;
  int smaller = digit, greater = digit;
  for (int i = 0; i < kMaxBoards && spoilsBoards(smaller & 0xFF, boards); ++i) smaller -= away;
  for (int i = 0; i < kMaxBoards && spoilsBoards(greater & 0xFF, boards); ++i) greater += away;
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
  lesson_ = lengthLesson(boards_);
  const std::int64_t room = (period_ns - slot_ns) / byte_ns - static_cast<std::int64_t>(lesson_.size());
  lesson_.insert(lesson_.begin(), static_cast<std::size_t>(std::clamp<std::int64_t>(room, 0, kLessonLead)),
                 0);
}

void BoardCycle::layOut() {
  int channel = 0;
  std::size_t longest_mark = 0;
  for (int b = 0; b < boardCount(); ++b) {
    const BoardShape& shape = *boards_[b].shape;
    cycle_offset_[b] = static_cast<int>(cycle_bytes_);
    first_channel_[b] = channel;
    channel = std::min(channel + shape.motors, static_cast<int>(device_.strings.size()));
    cycle_bytes_ += commandBytes(shape, BoardCommand::kCurrent) + paddingBytes(shape, BoardCommand::kCurrent);
    info_mark_[b] = infoQuestion(boards_[b].id, 0);
    for (int k = 0; k < 2; ++k) memory_mark_[b][k] = paramQuestion(boards_[b], BoardMemory::kParams[k]);
    longest_mark = std::max({longest_mark, info_mark_[b].size(), memory_mark_[b][0].size()});
  }
  cycle_.assign(cycle_bytes_ + longest_mark, 0);
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

BoardCycle::Drive BoardCycle::encode(const DriveCommand& command, bool usable) noexcept {
  const int strings = static_cast<int>(device_.strings.size());
  Drive drive;
  for (int b = 0; b < boardCount(); ++b) {
    const BoardShape& shape = *boards_[b].shape;
    CurrentCommand packet;
    for (int m = 0; m < shape.motors && usable && first_channel_[b] + m < strings; ++m) {
      const int channel = first_channel_[b] + m;
      bool clamped = false;
      const StringDef& string = device_.strings[channel];
      const int digit = driveDigit(shape, allowedVoltage(string, command.voltage[channel], clamped));
      const int least = driveDigit(shape, string.min_tension * string.volt_per_newton);
      const bool weak = std::abs(digit) < std::abs(least);
      packet.current[m] = static_cast<std::int16_t>(harmlessDigit(digit, weak ? 0 : least, boards_));
      drive.clamped = drive.clamped || clamped;
      drive.pulls = drive.pulls || std::abs(digit) > std::abs(least);
      drive.armed = drive.armed || packet.current[m] != 0;
    }
    encodePacket(shape, boards_[b].id, packet, cycle_.data() + cycle_offset_[b],
                 cycle_bytes_ - cycle_offset_[b]);
  }
  return drive;
}

std::size_t BoardCycle::append(const std::vector<std::uint8_t>& mark) noexcept {
  std::copy(mark.begin(), mark.end(), cycle_.begin() + static_cast<std::ptrdiff_t>(cycle_bytes_));
  return cycle_bytes_ + mark.size();
}

}  // namespace haptic
