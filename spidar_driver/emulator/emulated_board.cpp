#include "spidar_driver/emulator/emulated_board.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr std::uint8_t kFirstInvalidHeader = 0x60;  // 12 << 3: commands 12 and up do not exist
constexpr int kCountsPerTurn = 1024;                // of the magnetic sensor
constexpr double kControlPeriod = 1 / 11111.0;      // of the firmware [s]: velocities are per this time
constexpr int kB5mReportsCurrents = 0;              // firmware's BOARD_INFO, although it has eight sensors

std::int16_t low16(std::int32_t count) {
  return static_cast<std::int16_t>(static_cast<std::uint32_t>(count) & 0xFFFF);
}

}  // namespace

EmulatedBoard::EmulatedBoard(int id, const BoardShape& shape, int first_channel, MotorPlant& plant)
    : id_(std::clamp(id, 0, kMaxBoards - 1)), shape_(shape), first_channel_(first_channel), plant_(plant) {
  resetTable();
}

void EmulatedBoard::resetTable() {
  for (auto& row : table_)
    for (int c = 0; c < kBoardCommands; ++c)
      row[c] = static_cast<std::uint8_t>(commandBytes(shape_, static_cast<BoardCommand>(c)));
}

void EmulatedBoard::resetPosition() {
  for (int m = 0; m < shape_.motors; ++m) {
    const std::int32_t absolute = plant_.position(first_channel_ + m);
    const std::int32_t fraction = ((absolute % kCountsPerTurn) + kCountsPerTurn) % kCountsPerTurn;
    origin_[m] = absolute - fraction;
  }
}

void EmulatedBoard::setPower(bool on) {
  if (on == powered_) return;
  powered_ = on;
  setCurrents({});
  filled_ = length_ = skip_ = 0;
  mode_ = static_cast<std::uint8_t>(BoardMode::kCurrent);
  if (!on) return;
  held_mode_ = 0;
  resetTable();
  resetPosition();
  asked_param_ = 0;
}

void EmulatedBoard::reset(bool forget) {
  setPower(false);
  setPower(true);
  for (int m = 0; m < shape_.motors && forget; ++m) origin_[m] = plant_.position(first_channel_ + m);
}

void EmulatedBoard::setStuck(bool stuck) {
  stuck_ = stuck;
  for (int m = 0; m < shape_.motors; ++m) stuck_at_[m] = low16(plant_.position(first_channel_ + m) - origin_[m]);
}

int EmulatedBoard::receive(std::uint8_t byte, std::int64_t now_ns) {
  if (!powered_) return 0;
  if (skip_ > 0) return --skip_, 0;
  int reply = 0;
  if (filled_ == 0) {
    if (byte == 0 || byte >= kFirstInvalidHeader) return 0;
    const auto command = static_cast<BoardCommand>(byte >> 3);
    const int board = byte & 7;
    length_ = std::max<int>(1, table_[board][byte >> 3]);
    if (board != id_ && command != BoardCommand::kSetCommandLength) return skip_ = length_ - 1, 0;
    if (board == id_) reply = startReply(command, now_ns);
  }
  packet_[filled_++] = byte;
  if (filled_ < length_) return reply;
  execute();
  filled_ = 0;
  return reply;
}

void EmulatedBoard::fillPositions(MotorWords& position, MotorWords& velocity, std::int64_t now_ns) {
  plant_.advance(now_ns);
  const double periods = static_cast<double>(now_ns - last_ns_) * 1e-9 / kControlPeriod;
  for (int m = 0; m < shape_.motors; ++m) {
    const std::int32_t p = plant_.position(first_channel_ + m) - origin_[m];
    position[m] = low16(p);
    velocity[m] = periods > 0 ? static_cast<std::int16_t>(std::lround((p - last_position_[m]) / periods)) : 0;
    last_position_[m] = p;
  }
  if (stuck_) position = stuck_at_, velocity = {};
  last_ns_ = now_ns;
}

int EmulatedBoard::startReply(BoardCommand command, std::int64_t now_ns) {
  MotorWords position{}, velocity{};
  if (replyBytes(shape_, command) > 0) fillPositions(position, velocity, now_ns);
  switch (command) {
    case BoardCommand::kBoardInfo: {
      const int currents = shape_.model == BoardModel::kB5M ? kB5mReportsCurrents : shape_.currents;
      return encoded(InfoReply{static_cast<std::uint8_t>(shape_.model),
                               static_cast<std::uint8_t>(shape_.targets),
                               static_cast<std::uint8_t>(shape_.motors), static_cast<std::uint8_t>(currents),
                               static_cast<std::uint8_t>(shape_.forces), 0});
    }
    case BoardCommand::kAll: {
      AllReply r;
      r.mode = mode_;
      r.target_count = targets_;
      r.position = position;
      r.velocity = velocity;
      r.current = digit_;
      return encoded(r);
    }
    case BoardCommand::kSensor: {
      SensorReply r;
      r.position = position;
      r.current = digit_;
      return encoded(r);
    }
    case BoardCommand::kDirect:
      return encoded(DirectPacket{position, velocity});
    case BoardCommand::kCurrent:
      return encoded(CurrentReply{position, velocity, {}});
    case BoardCommand::kInterpolate:
      return encoded(InterpolateReply{position, 0, targets_});
    case BoardCommand::kForceControl:
      return encoded(ForceControlReply{position, 0, targets_});
    case BoardCommand::kGetParam: {
      ParamReply r = asked_param_ < param_.size() ? param_[asked_param_] : ParamReply{};
      r.type = asked_param_;
      return encoded(r);
    }
    default:
      return 0;
  }
}

void EmulatedBoard::setCurrents(const MotorWords& digits) {
  if (!obeys_ && powered_) return;
  digit_ = {};
  for (int m = 0; m < shape_.motors; ++m) {
    const int limit = maxDriveDigit(shape_);
    digit_[m] = static_cast<std::int16_t>(std::clamp<int>(digits[m], -limit, limit));
    plant_.drive(first_channel_ + m, digit_[m]);
  }
}

void EmulatedBoard::setParam(const ParamCommand& param) {
  if (param.type >= param_.size()) return;
  param_[param.type].words = param.words;
  if (static_cast<BoardParam>(param.type) == BoardParam::kBoardId)
    id_ = std::min(param.words[0] & 0xFF, kMaxBoards - 1);
}

/// Goes into a mode whose targets are counted.
template <class Command>
void EmulatedBoard::follow(BoardMode mode) {
  Command p;
  if (!decoded(p)) return;
  mode_ = static_cast<std::uint8_t>(mode);
  targets_ = p.target_count;
}

void EmulatedBoard::execute() {
  const auto command = static_cast<BoardCommand>(packet_[0] >> 3);
  ++executed_[static_cast<int>(command)];
  switch (command) {
    case BoardCommand::kSetCommandLength: {
      LengthCommand p;
      if (decoded(p)) std::copy(p.bytes.begin(), p.bytes.end(), table_[packet_[0] & 7].begin());
      break;
    }
    case BoardCommand::kCurrent: {
      CurrentCommand p;
      if (!decoded(p) || held_mode_ > 0) break;
      mode_ = static_cast<std::uint8_t>(BoardMode::kCurrent);
      setCurrents(p.current);
      break;
    }
    case BoardCommand::kAll: {
      AllCommand p;
      if (!decoded(p) || p.mode == 0) break;
      mode_ = p.mode;
      targets_ = p.target_count;
      if (p.mode == static_cast<std::uint8_t>(BoardMode::kCurrent)) setCurrents(p.target);
      break;
    }
    // The position loops of the firmware are not emulated: the boards of a SPIDAR run in current mode.
    case BoardCommand::kDirect:
      mode_ = static_cast<std::uint8_t>(BoardMode::kDirect);
      break;
    case BoardCommand::kInterpolate:
      follow<InterpolateCommand>(BoardMode::kInterpolate);
      break;
    case BoardCommand::kForceControl:
      follow<ForceControlCommand>(BoardMode::kForceControl);
      break;
    case BoardCommand::kSetParam: {
      ParamCommand p;
      if (decoded(p)) setParam(p);
      break;
    }
    case BoardCommand::kResetSensor: {
      ResetSensorCommand p;
      if (decoded(p) && (p.flags & 1)) resetPosition();
      break;
    }
    case BoardCommand::kGetParam: {
      GetParamCommand p;
      if (decoded(p)) asked_param_ = p.type;
      break;
    }
    default:
      break;
  }
}

}  // namespace haptic
