#include "spidar_driver/transport/board_model.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace haptic {
namespace {

// B5M measures eight currents but sends none of them, so `currents` is 0.
constexpr std::array<BoardShape, 7> kShapes = {{{BoardModel::kB1M, "B1M", 4, 0, 0, 12},
                                                {BoardModel::kB1F, "B1F", 3, 0, 2, 12},
                                                {BoardModel::kB2M, "B2M", 4, 0, 0, 12},
                                                {BoardModel::kB2F, "B2F", 3, 0, 2, 12},
                                                {BoardModel::kB3M, "B3M", 4, 4, 0, 12},
                                                {BoardModel::kB3F, "B3F", 3, 3, 2, 12},
                                                {BoardModel::kB5M, "B5M", 8, 0, 4, 12}}};

constexpr double kDigitPerVolt = 4096 / 3.3;  // 12-bit ADC, 3.3 V reference
constexpr int kFullAdc = 4095;                // largest ADC reading [digit]
constexpr int kFullDuty = 1024;               // open-loop PWM at 100 % [digit]
constexpr int kMinPadding = 5;                // fills the receive FIFO past ¾ behind the shortest command
constexpr int kSlotBytes = 20;                // spare wire time around a reply [bytes]; less: replies collide

}  // namespace

const BoardShape* findBoardModel(int model) {
  const auto it = std::find_if(kShapes.begin(), kShapes.end(),
                               [model](const BoardShape& s) { return static_cast<int>(s.model) == model; });
  return it == kShapes.end() ? nullptr : &*it;
}

const BoardShape* findBoardModel(const std::string& name) {
  const auto it =
      std::find_if(kShapes.begin(), kShapes.end(), [&name](const BoardShape& s) { return name == s.name; });
  return it == kShapes.end() ? nullptr : &*it;
}

int commandBytes(const BoardShape& board, BoardCommand command) {
  const int n = board.motors, f = board.forces;
  switch (command) {
    case BoardCommand::kNone:
    case BoardCommand::kBoardInfo:
    case BoardCommand::kSensor:
      return 1;
    case BoardCommand::kSetCommandLength:
      return 1 + kBoardCommands;
    case BoardCommand::kAll:
      return 1 + 2 + 2 + 2 * n + 2 * std::max(n, f * n);
    case BoardCommand::kDirect:
      return 1 + 4 * n;
    case BoardCommand::kCurrent:
      return 1 + 2 * n;
    case BoardCommand::kInterpolate:
      return 1 + 2 * n + 2 + 1;
    case BoardCommand::kForceControl:
      return 1 + 2 * n + 2 * f * n + 2 + 1;
    case BoardCommand::kSetParam:
      return 1 + 1 + 4 * n;
    case BoardCommand::kResetSensor:
      return 1 + 2;
    case BoardCommand::kGetParam:
      return 1 + 1;
  }
  return 0;
}

int replyBytes(const BoardShape& board, BoardCommand command) {
  const int n = board.motors, c = board.currents, f = board.forces;
  switch (command) {
    case BoardCommand::kNone:
    case BoardCommand::kSetCommandLength:
    case BoardCommand::kSetParam:
    case BoardCommand::kResetSensor:
      return 0;
    case BoardCommand::kBoardInfo:
      return 1 + 6;
    case BoardCommand::kAll:
      return 1 + 2 + 2 + 4 * n + 2 * c + 2 * f;
    case BoardCommand::kSensor:
      return 1 + 2 * n + 2 * c + 2 * f;
    case BoardCommand::kDirect:
      return 1 + 4 * n;
    case BoardCommand::kCurrent:
      return 1 + 4 * n + 2 * f;
    case BoardCommand::kInterpolate:
    case BoardCommand::kForceControl:
      return 1 + 2 * n + 2 + 1;
    case BoardCommand::kGetParam:
      return 1 + 1 + 4 * n;
  }
  return 0;
}

int paddingBytes(const BoardShape& board, BoardCommand command) {
  return std::max(kMinPadding, replyBytes(board, command) - commandBytes(board, command) + kSlotBytes);
}

int maxDriveDigit(const BoardShape& board) {
  return board.currents > 0 ? kFullAdc : kFullDuty;
}

std::int16_t driveDigit(const BoardShape& board, double voltage) {
  if (std::isnan(voltage)) return 0;
  const double limit = maxDriveDigit(board);
  return static_cast<std::int16_t>(std::trunc(std::clamp(voltage * kDigitPerVolt, -limit, limit)));
}

std::string boardModelNames() {
  std::string names;
  for (const BoardShape& shape : kShapes) names += (names.empty() ? "" : ", ") + std::string(shape.name);
  return names;
}

}  // namespace haptic
