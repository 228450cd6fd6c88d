/// Motor boards on the shared UART bus: what each model carries and how long its packets are.
///
/// A packet has one header byte, (command << 3) | board id, and a fixed length that depends on the model and
/// the command alone: there is no start byte, no length byte and no checksum. Lengths include the header.
/// Source: firmware layout facts (device_facts, section 4b); the lengths below follow from the layouts in
/// board_protocol.h, and the test holds both against the published table.
#pragma once
#include <cstdint>
#include <string>

namespace haptic {

enum class BoardModel : std::uint8_t { kB1M = 1, kB1F, kB2M, kB2F, kB3M, kB3F, kB5M };

enum class BoardCommand : std::uint8_t {
  kNone,              ///< padding
  kBoardInfo,         ///< model and channel numbers
  kSetCommandLength,  ///< teaches every board how far to skip a command that is for another one
  kAll,
  kSensor,
  kDirect,        ///< position and velocity targets
  kCurrent,       ///< motor currents out, positions in: the cycle of the haptic loop
  kInterpolate,   ///< piecewise-linear position targets
  kForceControl,  ///< the same with a Jacobian to the force sensors
  kSetParam,
  kResetSensor,
  kGetParam
};

inline constexpr int kBoardCommands = 12;
inline constexpr int kMaxBoards = 8;         ///< ids 0–7 fit the header's three bits
inline constexpr int kMaxBoardMotors = 8;    ///< B5M
inline constexpr int kMaxBoardForces = 4;    ///< B5M
inline constexpr int kMaxCommandBytes = 85;  ///< ALL of a B5M: the longest packet on the wire
inline constexpr int kMaxReplyBytes = 45;    ///< ALL of a B5M

/// What one model carries. `currents` counts the measured currents that its packets contain.
struct BoardShape {
  BoardModel model;
  const char* name;
  int motors;
  int currents;
  int forces;
  int targets;  ///< capacity of the ring of position targets
};

const BoardShape* findBoardModel(int model);                ///< nullptr when the number is unknown
const BoardShape* findBoardModel(const std::string& name);  ///< "B3M"; nullptr when unknown

int commandBytes(const BoardShape& board, BoardCommand command);  ///< header included
int replyBytes(const BoardShape& board, BoardCommand command);    ///< header included; 0: no reply

/// Zero bytes that must follow a command: the receiver wakes at ¾ of its FIFO, and the time they take is the
/// board's slot for its reply on the shared line: max(5, reply − command + 20).
int paddingBytes(const BoardShape& board, BoardCommand command);

constexpr std::uint8_t headerByte(BoardCommand command, int id) {
  return static_cast<std::uint8_t>(static_cast<int>(command) << 3 | (id & 7));
}

/// Largest drive digit the model obeys: current-sensing boards compare with a 12-bit ADC, the others saturate
/// at 1024 = full duty.
int maxDriveDigit(const BoardShape& board);

/// Drive voltage [V] to digit: ADC counts of the current-sense amplifier, 4096 per 3.3 V, truncated toward
/// zero and clamped to the model's range. NaN gives 0: no current.
std::int16_t driveDigit(const BoardShape& board, double voltage);

/// "B1M, B1F, ...": for messages.
std::string boardModelNames();

}  // namespace haptic
