/// One motor board, as its firmware behaves on the wire: byte by byte, no more forgiving than the real one.
///
/// At a header position 0x00 and bytes from 0x60 on are skipped. Any other byte is (command << 3) | id; its
/// packet length comes from the board's own table of 8 ids × 12 commands, which holds the board's own lengths
/// until SET_CMDLEN teaches it others: a command for another board is skipped by that length, right or wrong.
/// A reply is built when the header is recognised, before the payload is executed. Absent ids stay silent.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>

#include "spidar_driver/emulator/motor_plant.h"
#include "spidar_driver/transport/board_protocol.h"

namespace haptic {

class EmulatedBoard {
 public:
  EmulatedBoard(int id, const BoardShape& shape, int first_channel, MotorPlant& plant);

  /// Takes one byte from the wire at `now_ns`. Returns the length of the reply that it starts, 0 for none.
  int receive(std::uint8_t byte, std::int64_t now_ns);
  const std::uint8_t* reply() const { return reply_.data(); }

  /// Off: silent and without current. On again: length table and mode as after power-on, the position keeps
  /// only its fraction of a turn.
  void setPower(bool on);

  /// Brown-out: as off and on at once, and the counters at zero when `forget` is set.
  void reset(bool forget);
  void replace() { id_ = first_id_, reset(false); }  ///< switched off and on, and its id as it came
  /// What a disturbed SET_CMDLEN leaves behind: the length that this board takes that id's command to have.
  void spoilTable(int id, BoardCommand command, int length) {
    table_[id & 7][static_cast<int>(command)] = static_cast<std::uint8_t>(length);
  }
  int tableLength(int id, BoardCommand command) const { return table_[id & 7][static_cast<int>(command)]; }  ///< [bytes]
  /// False: its table cuts everything short that could turn its motors off or teach it better.
  bool reachable() const {
    for (const BoardCommand c : {BoardCommand::kCurrent, BoardCommand::kAll, BoardCommand::kSetCommandLength})
      if (table_[id_ & 7][static_cast<int>(c)] >= commandBytes(shape_, c)) return true;
    return false;
  }
  void setObeys(bool obeys) { obeys_ = obeys; }  ///< false: it answers, and its currents stay what they are
  /// It went into that mode (BoardMode) and stays in it, whatever it is told; 0: no more.
  void holdMode(int mode) { held_mode_ = mode, mode_ = static_cast<std::uint8_t>(mode > 0 ? mode : static_cast<int>(BoardMode::kCurrent)); }
  void setStuck(bool stuck);                     ///< its counters stand still

  int id() const { return id_; }
  const BoardShape& shape() const { return shape_; }
  bool powered() const { return powered_; }
  int firstChannel() const { return first_channel_; }
  std::int16_t digit(int motor) const { return digit_[motor]; }
  std::uint64_t executed(BoardCommand command) const { return executed_[static_cast<int>(command)]; }

 private:
  int startReply(BoardCommand command, std::int64_t now_ns);
  template <class Command>
  void follow(BoardMode mode);
  void execute();
  void setCurrents(const MotorWords& digits);
  void setParam(const ParamCommand& param);
  void fillPositions(MotorWords& position, MotorWords& velocity, std::int64_t now_ns);
  void resetTable();
  void resetPosition();
  template <class Packet>
  bool decoded(Packet& packet) const {
    // A table that says more makes the board wait longer; what it then reads are the first bytes.
    const int length = std::min(length_, commandBytes(shape_, Packet::kCommand));
    return decodePacket(shape_, packet_[0] & 7, packet_.data(), static_cast<std::size_t>(length), packet);
  }
  template <class Packet>
  int encoded(const Packet& packet) {
    return encodePacket(shape_, id_, packet, reply_.data(), reply_.size());
  }

  int id_, first_id_ = id_;
  const BoardShape& shape_;
  int first_channel_;
  MotorPlant& plant_;
  bool powered_ = true, obeys_ = true, stuck_ = false;
  MotorWords stuck_at_{};
  int held_mode_ = 0;
  std::array<std::array<std::uint8_t, kBoardCommands>, kMaxBoards> table_{};
  std::array<std::uint8_t, 256> packet_{};
  int length_ = 0, filled_ = 0, skip_ = 0;
  std::array<std::uint8_t, kMaxReplyBytes> reply_{};
  MotorWords digit_{};
  std::array<std::int32_t, kMaxBoardMotors> origin_{}, last_position_{};
  std::int64_t last_ns_ = 0;
  std::uint8_t mode_ = static_cast<std::uint8_t>(BoardMode::kCurrent), asked_param_ = 0, targets_ = 0;
  std::array<ParamReply, 9> param_{};
  std::array<std::uint64_t, kBoardCommands> executed_{};
};

}  // namespace haptic
