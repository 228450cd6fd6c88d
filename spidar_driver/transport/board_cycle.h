/// What goes out in one exchange, and how long the wire takes for it: layout, currents, marks, lesson.
///
///   for each board  CURRENT(digits) + padding   ·   at times a mark   ·   at times, when the answers are here, the lesson of lengths
///
/// No current has a low byte that is the header of a command that spoils a board on the bus, or puts it into another mode: a
/// board that missed its own header takes what follows for headers.
/// Nothing else touches a current: no force is put into the hand to find out whether a board obeys (board_lesson.h).
#pragma once
#include <array>
#include <vector>

#include "haptic_core/spidar/transport.h"
#include "spidar_driver/transport/board_bus.h"
#include "spidar_driver/transport/board_lesson.h"
#include "spidar_driver/transport/board_memory.h"
#include "spidar_driver/transport/board_protocol.h"
#include "spidar_driver/transport/uart_settings.h"

namespace haptic {

class BoardCycle {
 public:
  /// Set-up. `device` must outlive this. Throws SetupError when the wire does not carry the rate.
  BoardCycle(const DeviceDef& device, const UartSettings& settings, const std::vector<FoundBoard>& boards);

  const std::vector<FoundBoard>& boards() const { return boards_; }
  int boardCount() const { return static_cast<int>(boards_.size()); }
  int boardOf(int id) const noexcept;                                  ///< -1: none has this id
  int firstChannel(int board) const { return first_channel_[board]; }  ///< of the device's strings
  /// From the first byte of a cycle to the header of a board's command [ns].
  std::int64_t offsetNs(int board) const { return cycle_offset_[board] * byte_ns; }

  struct Drive {
    bool armed = false;    ///< some current is not zero
    bool pulls = false;    ///< some string is told more than its least tension
    bool clamped = false;  ///< some voltage was outside its bounds
  };
  /// (in realtime) Writes the currents; not `usable`: zero ones.
  Drive encode(const DriveCommand& command, bool usable) noexcept;
  /// (in realtime) The cycle with what is to follow it. The bytes stay until the next call.
  const std::vector<std::uint8_t>& bytes() const { return cycle_; }
  std::size_t size() const { return cycle_bytes_; }  ///< without a mark
  std::size_t append(const std::vector<std::uint8_t>& mark) noexcept;  ///< (in realtime) size with it

  const std::vector<std::uint8_t>& zero() const {
    return zero_;
  }  ///< turns all motors off, on a line in whatever state
  static constexpr int kZeroLead =
      90;  ///< zeros at its start: they end any packet that a board in step may be inside of
  /// The lengths of all boards; `exam` >= 0: and the question that shows whether this board has kept them.
  const std::vector<std::uint8_t>& lesson(BoardLesson::Kind kind, int exam) const {
    return exam < 0 ? lesson_[static_cast<std::size_t>(kind)] : exam_[exam][static_cast<std::size_t>(kind)];
  }
  const std::vector<std::uint8_t>& infoMark(int board) const { return info_mark_[board]; }
  const std::vector<std::uint8_t>& stateMark(int board) const { return state_mark_[board]; }
  std::int16_t digit(int channel) const { return digit_[static_cast<std::size_t>(channel)]; }  ///< of the last `encode`
  const std::vector<std::uint8_t>& memoryMark(int board, int k) const {
    return memory_mark_[board][k];
  }  ///< kParams[k]

  std::int64_t byte_ns = 0;    ///< one byte on the wire
  std::int64_t cycle_ns = 0;   ///< a cycle without a mark
  std::int64_t slot_ns = 0;    ///< the same, as the device's highest rate has it
  std::int64_t period_ns = 0;  ///< of the exchanges
  std::int64_t wait_ns = 0;    ///< longest wait for answers
  std::int64_t longest_mark_ns = 0;
  double max_rate_hz = 0;

 private:
  void layOut();
  CurrentCommand packetOf(int board, const DriveCommand& command, Drive& drive) noexcept;

  const DeviceDef& device_;
  std::vector<FoundBoard> boards_;
  std::vector<std::uint8_t> zero_, cycle_;
  std::array<std::vector<std::uint8_t>, 2> lesson_;
  std::array<std::int16_t, kMaxStrings> digit_{};
  std::array<std::vector<std::uint8_t>, kMaxBoards> info_mark_, state_mark_;
  std::array<std::array<std::vector<std::uint8_t>, 2>, kMaxBoards> memory_mark_, exam_;
  std::array<int, kMaxBoards> cycle_offset_{}, slot_bytes_{}, first_channel_{};
  std::size_t cycle_bytes_ = 0;
};

}  // namespace haptic
