/// Bytes ↔ values of the motor boards: every command and reply, without I/O, clock or state.
///
/// Each packet states its layout once (`layout`), in wire order; encoding and decoding both walk it, for the
/// driver and for the board emulator alike. Integers are little-endian int16 unless said otherwise. Arrays
/// are sized for the largest board; the board's shape says how many entries travel, the rest stays as it was.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "spidar_driver/transport/board_model.h"

namespace haptic {

constexpr int kFifoBytes = 6;  ///< a board looks at its FIFO when it is ¾ full

using MotorWords = std::array<std::int16_t, kMaxBoardMotors>;
using ForceWords = std::array<std::int16_t, kMaxBoardForces>;
using JacobianWords = std::array<std::int16_t, kMaxBoardForces * kMaxBoardMotors>;  ///< row per force sensor

enum class BoardMode : std::uint8_t { kSkip, kTorque, kDirect, kCurrent, kInterpolate, kForceControl };

enum class BoardParam : std::uint8_t {
  kPd,           ///< k[n], b[n]
  kCurrentGain,  ///< a[n]
  kTorqueLimit,  ///< min[n], max[n]
  kBoardId,      ///< u8
  kBaudRate,     ///< u32 command line, u32 monitor line
  kMotorHeat,    ///< limit[n], release[n]
  kMagnet,       ///< cos[n], sin[n]; read only
  kEncoder,      ///< u32, bit i: motor i has a quadrature encoder
  kPwmResolution
};

// ---- commands: host to board ----

struct InfoCommand {
  static constexpr BoardCommand kCommand = BoardCommand::kBoardInfo;
  template <class Self, class Walk>
  static void layout(Self&, const BoardShape&, Walk&) {}
};

struct LengthCommand {
  static constexpr BoardCommand kCommand = BoardCommand::kSetCommandLength;
  std::array<std::uint8_t, kBoardCommands> bytes{};  ///< length of each command of the board in the header
  template <class Self, class Walk>
  static void layout(Self& p, const BoardShape&, Walk& walk) {
    for (auto& b : p.bytes) walk.u8(b);
  }
};

struct AllCommand {
  static constexpr BoardCommand kCommand = BoardCommand::kAll;
  std::uint8_t mode = 0, target_count = 0;
  std::int16_t period = 0;
  MotorWords target{};       ///< currents or positions, by `mode`
  JacobianWords gradient{};  ///< velocities (first n) or the Jacobian, by `mode`
  template <class Self, class Walk>
  static void layout(Self& p, const BoardShape& board, Walk& walk) {
    walk.u8(p.mode);
    walk.u8(p.target_count);
    walk.i16(p.period);
    walk.words(p.target, board.motors);
    walk.words(p.gradient, board.motors * (board.forces > 1 ? board.forces : 1));
  }
};

struct SensorCommand {
  static constexpr BoardCommand kCommand = BoardCommand::kSensor;
  template <class Self, class Walk>
  static void layout(Self&, const BoardShape&, Walk&) {}
};

/// Command and reply have the same layout.
struct DirectPacket {
  static constexpr BoardCommand kCommand = BoardCommand::kDirect;
  MotorWords position{}, velocity{};
  template <class Self, class Walk>
  static void layout(Self& p, const BoardShape& board, Walk& walk) {
    walk.words(p.position, board.motors);
    walk.words(p.velocity, board.motors);
  }
};

struct CurrentCommand {
  static constexpr BoardCommand kCommand = BoardCommand::kCurrent;
  MotorWords current{};  ///< drive digits, see driveDigit
  template <class Self, class Walk>
  static void layout(Self& p, const BoardShape& board, Walk& walk) {
    walk.words(p.current, board.motors);
  }
};

struct InterpolateCommand {
  static constexpr BoardCommand kCommand = BoardCommand::kInterpolate;
  MotorWords position{};
  std::int16_t period = 0;
  std::uint8_t target_count = 0;
  template <class Self, class Walk>
  static void layout(Self& p, const BoardShape& board, Walk& walk) {
    walk.words(p.position, board.motors);
    walk.i16(p.period);
    walk.u8(p.target_count);
  }
};

struct ForceControlCommand {
  static constexpr BoardCommand kCommand = BoardCommand::kForceControl;
  MotorWords position{};
  JacobianWords jacobian{};
  std::int16_t period = 0;
  std::uint8_t target_count = 0;
  template <class Self, class Walk>
  static void layout(Self& p, const BoardShape& board, Walk& walk) {
    walk.words(p.position, board.motors);
    walk.words(p.jacobian, board.forces * board.motors);
    walk.i16(p.period);
    walk.u8(p.target_count);
  }
};

/// SET_PARAM: a type and a block of 4n bytes, read as 2n words; what they mean depends on the type.
struct ParamCommand {
  static constexpr BoardCommand kCommand = BoardCommand::kSetParam;
  std::uint8_t type = 0;
  std::array<std::int16_t, 2 * kMaxBoardMotors> words{};
  template <class Self, class Walk>
  static void layout(Self& p, const BoardShape& board, Walk& walk) {
    walk.u8(p.type);
    walk.words(p.words, 2 * board.motors);
  }
};

struct ResetSensorCommand {
  static constexpr BoardCommand kCommand = BoardCommand::kResetSensor;
  std::int16_t flags = 0;  ///< 1: motors (keep the fraction of a turn), 2: force sensors
  template <class Self, class Walk>
  static void layout(Self& p, const BoardShape&, Walk& walk) {
    walk.i16(p.flags);
  }
};

struct GetParamCommand {
  static constexpr BoardCommand kCommand = BoardCommand::kGetParam;
  std::uint8_t type = 0;
  template <class Self, class Walk>
  static void layout(Self& p, const BoardShape&, Walk& walk) {
    walk.u8(p.type);
  }
};

// ---- replies: board to host ----

struct InfoReply {
  static constexpr BoardCommand kCommand = BoardCommand::kBoardInfo;
  std::uint8_t model = 0, targets = 0, motors = 0, currents = 0, forces = 0, touches = 0;
  template <class Self, class Walk>
  static void layout(Self& p, const BoardShape&, Walk& walk) {
    walk.u8(p.model);
    walk.u8(p.targets);
    walk.u8(p.motors);
    walk.u8(p.currents);
    walk.u8(p.forces);
    walk.u8(p.touches);
  }
};

struct AllReply {
  static constexpr BoardCommand kCommand = BoardCommand::kAll;
  std::uint8_t mode = 0, target_count = 0;
  std::uint16_t tick = 0;
  MotorWords position{}, velocity{}, current{};
  ForceWords force{};
  template <class Self, class Walk>
  static void layout(Self& p, const BoardShape& board, Walk& walk) {
    walk.u8(p.mode);
    walk.u8(p.target_count);
    walk.u16(p.tick);
    walk.words(p.position, board.motors);
    walk.words(p.velocity, board.motors);
    walk.words(p.current, board.currents);
    walk.words(p.force, board.forces);
  }
};

struct SensorReply {
  static constexpr BoardCommand kCommand = BoardCommand::kSensor;
  MotorWords position{}, current{};
  ForceWords force{};
  template <class Self, class Walk>
  static void layout(Self& p, const BoardShape& board, Walk& walk) {
    walk.words(p.position, board.motors);
    walk.words(p.current, board.currents);
    walk.words(p.force, board.forces);
  }
};

struct CurrentReply {
  static constexpr BoardCommand kCommand = BoardCommand::kCurrent;
  MotorWords position{};  ///< low 16 bits of the multi-turn count
  MotorWords velocity{};  ///< change of position per control period of the firmware
  ForceWords force{};
  template <class Self, class Walk>
  static void layout(Self& p, const BoardShape& board, Walk& walk) {
    walk.words(p.position, board.motors);
    walk.words(p.velocity, board.motors);
    walk.words(p.force, board.forces);
  }
};

/// Reply to INTERPOLATE and to FORCE_CONTROL.
template <BoardCommand command>
struct TargetReply {
  static constexpr BoardCommand kCommand = command;
  MotorWords position{};
  std::uint16_t tick = 0;
  std::uint8_t target_count = 0;
  template <class Self, class Walk>
  static void layout(Self& p, const BoardShape& board, Walk& walk) {
    walk.words(p.position, board.motors);
    walk.u16(p.tick);
    walk.u8(p.target_count);
  }
};
using InterpolateReply = TargetReply<BoardCommand::kInterpolate>;
using ForceControlReply = TargetReply<BoardCommand::kForceControl>;

/// GET_PARAM. A board answers before it executes: the type is that of the request before. Ask twice.
struct ParamReply {
  static constexpr BoardCommand kCommand = BoardCommand::kGetParam;
  std::uint8_t type = 0;
  std::array<std::int16_t, 2 * kMaxBoardMotors> words{};
  template <class Self, class Walk>
  static void layout(Self& p, const BoardShape& board, Walk& walk) {
    walk.u8(p.type);
    walk.words(p.words, 2 * board.motors);
  }
};

// ---- walking a layout ----

/// Writes a layout; bytes past the capacity are dropped and `size` still counts them.
class PacketWriter {
 public:
  PacketWriter(std::uint8_t* bytes, std::size_t capacity) : bytes_(bytes), capacity_(capacity) {}
  void u8(std::uint8_t value) {
    if (size_ < capacity_) bytes_[size_] = value;
    ++size_;
  }
  void u16(std::uint16_t value) {
    u8(static_cast<std::uint8_t>(value & 0xFF));
    u8(static_cast<std::uint8_t>(value >> 8));
  }
  void i16(std::int16_t value) { u16(static_cast<std::uint16_t>(value)); }
  template <class Words>
  void words(const Words& values, int count) {
    for (int i = 0; i < count; ++i) i16(values[i]);
  }
  std::size_t size() const { return size_; }

 private:
  std::uint8_t* bytes_;
  std::size_t capacity_, size_ = 0;
};

/// Reads a layout; reads past the end give 0 and `size` still counts them.
class PacketReader {
 public:
  PacketReader(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes), end_(size) {}
  void u8(std::uint8_t& value) {
    value = size_ < end_ ? bytes_[size_] : 0;
    ++size_;
  }
  void u16(std::uint16_t& value) {
    std::uint8_t low = 0, high = 0;
    u8(low);
    u8(high);
    value = static_cast<std::uint16_t>(low | high << 8);
  }
  void i16(std::int16_t& value) {
    std::uint16_t word = 0;
    u16(word);
    value = static_cast<std::int16_t>(word);
  }
  template <class Words>
  void words(Words& values, int count) {
    for (int i = 0; i < count; ++i) i16(values[i]);
  }
  std::size_t size() const { return size_; }

 private:
  const std::uint8_t* bytes_;
  std::size_t end_, size_ = 0;
};

/// (in realtime) Writes header and payload; returns the packet's length, or 0 when `capacity` is too small.
template <class Packet>
int encodePacket(const BoardShape& board, int id, const Packet& packet, std::uint8_t* bytes,
                 std::size_t capacity) {
  PacketWriter writer(bytes, capacity);
  writer.u8(headerByte(Packet::kCommand, id));
  Packet::layout(packet, board, writer);
  return writer.size() <= capacity ? static_cast<int>(writer.size()) : 0;
}

/// (in realtime) Reads a packet of exactly `size` bytes. False, and `packet` unspecified, when the header is
/// not that of `id` and the packet's command, or the length is not the layout's.
template <class Packet>
bool decodePacket(const BoardShape& board, int id, const std::uint8_t* bytes, std::size_t size,
                  Packet& packet) {
  if (size == 0 || bytes[0] != headerByte(Packet::kCommand, id)) return false;
  PacketReader reader(bytes + 1, size - 1);
  Packet::layout(packet, board, reader);
  return reader.size() == size - 1;
}

}  // namespace haptic
