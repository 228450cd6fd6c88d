/// What goes out in one exchange, and how long the wire takes for it: layout, currents, marks, lesson.
///
///   for each board  CURRENT(digits) + padding   ·   at times a mark   ·   at times the lesson of lengths
///   ahead
///
/// No current has a low byte that is the header of a command that spoils a board on the bus, or puts it into another mode: a
/// board that missed its own header takes what follows for headers.
///
/// A canary is a cycle whose last board gets its CURRENT without the last motor's two bytes, whose low one is the header of
/// BOARD_INFO; they follow at the start of the next exchange, when the board has sent its counts. A board whose length table cuts
/// CURRENT short takes them for a question and answers it: such a board looks sound otherwise, and takes in no current. All
/// other low bytes are zero or no header, so that nothing swallows the question. The currents of that board come one period late,
/// its last motor's is off by 128 digits at most for the 0.3 ms until the cycle's own CURRENT. Costs 28 bytes.
#pragma once
#include <array>
#include <vector>

#include "haptic_core/spidar/transport.h"
#include "spidar_driver/transport/board_bus.h"
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
  /// From the first byte of a cycle in which board `last` (-1: as they come) was the last to the header of a board's command [ns].
  std::int64_t offsetNs(int board, int last) const { return offset(board, last) * byte_ns; }

  struct Drive {
    bool armed = false;    ///< some current is not zero
    bool pulls = false;    ///< some string is told more than its least tension
    bool clamped = false;  ///< some voltage was outside its bounds
  };
  /// (in realtime) Writes the currents; not `usable`: zero ones. `canary`: the board that comes last, with the header of BOARD_INFO
  /// for the board `asked`; -1: none.
  Drive encode(const DriveCommand& command, bool usable, int canary = -1, int asked = -1) noexcept;
  /// (in realtime) What was left out of the canary's cycle, with the slot of the answer that must not come; `sound` false: zeros
  /// in its place. The bytes stay until the next call.
  const std::vector<std::uint8_t>& rest(bool sound) noexcept;
  /// A board of three motors does not look at so few bytes.
  bool takesCanary(int board) const noexcept;
  /// (in realtime) The cycle with what is to follow it. The bytes stay until the next call.
  const std::vector<std::uint8_t>& bytes() const { return cycle_; }
  std::size_t size() const { return canary_ < 0 ? cycle_bytes_ : canary_bytes_; }  ///< without a mark
  std::size_t append(const std::vector<std::uint8_t>& mark) noexcept;  ///< (in realtime) size with it

  const std::vector<std::uint8_t>& zero() const {
    return zero_;
  }  ///< turns all motors off, on a line in whatever state
  static constexpr int kZeroLead =
      90;  ///< zeros at its start: they end any packet that a board in step may be inside of
  const std::vector<std::uint8_t>& lesson() const {
    return lesson_;
  }  ///< zeros as there is room for, then the lengths
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
  int offset(int board, int last) const noexcept;
  CurrentCommand packetOf(int board, const DriveCommand& command, Drive& drive) noexcept;
  void placeCanary(int board, int asked, CurrentCommand& packet) noexcept;

  const DeviceDef& device_;
  std::vector<FoundBoard> boards_;
  std::vector<std::uint8_t> zero_, lesson_, cycle_, rest_;
  std::array<std::int16_t, kMaxStrings> digit_{};
  std::array<std::vector<std::uint8_t>, kMaxBoards> info_mark_, state_mark_;
  std::array<std::array<std::vector<std::uint8_t>, 2>, kMaxBoards> memory_mark_;
  std::array<int, kMaxBoards> cycle_offset_{}, slot_bytes_{}, first_channel_{};
  std::size_t cycle_bytes_ = 0, canary_bytes_ = 0;
  int canary_ = -1;
};

}  // namespace haptic
