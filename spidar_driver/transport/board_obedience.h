/// Does a board do what it is told, as its reply to ALL says?
///
/// The reply names the mode, which every CURRENT that is taken in sets, and on boards that sense them (B3M, B3F) the motors'
/// currents in the digits of the command. A measured current is right when it lies within what the motor was told lately. A
/// board that has never been right (another firmware) proves nothing and is not accused. Kinds of wrong answers must come in a row: the
/// wire has no checksum.
#pragma once
#include <algorithm>
#include <cmath>

#include "spidar_driver/transport/board_protocol.h"

namespace haptic {

/// Judges the replies to ALL of one board.
class BoardObedience {
 public:
  enum class Verdict : unsigned char { kFine, kWrongMode, kCurrentsIgnored };

  void begin() noexcept { *this = BoardObedience(); }  ///< (in realtime) the boards were brought into step

  /// (in realtime) A cycle goes out with that digit for a motor.
  void tell(int motor, int digit, std::int64_t now_ns) noexcept {
    Told& t = told_[static_cast<std::size_t>(motor)];
    if (now_ns - t.since_ns > kWindowNs) t.before_low = t.low, t.before_high = t.high, t.low = t.high = digit, t.since_ns = now_ns;
    t.low = std::min(t.low, digit);
    t.high = std::max(t.high, digit);
  }

  /// (in realtime) `motors`: those that drive strings.
  Verdict take(const BoardShape& shape, int motors, const AllReply& reply) noexcept {
    const bool right_mode = reply.mode == static_cast<std::uint8_t>(BoardMode::kCurrent);
    mode_known_ = mode_known_ || right_mode;
    wrong_mode_ = right_mode ? 0 : wrong_mode_ + 1;
    if (mode_known_ && wrong_mode_ >= kModes) return Verdict::kWrongMode;
    bool wrong = false, pulls = false;
    for (int m = 0; m < std::min(motors, shape.currents); ++m) {
      const Told& t = told_[static_cast<std::size_t>(m)];
      const int low = std::min(t.low, t.before_low), high = std::max(t.high, t.before_high);
      const double slack = kNoise + kGain * std::max(std::abs(low), std::abs(high));
      const int measured = reply.current[static_cast<std::size_t>(m)];
      wrong = wrong || measured < low - slack || measured > high + slack;
      pulls = pulls || low > kNoise || high < -kNoise;
    }
    currents_known_ += pulls && !wrong;
    wrong_currents_ = wrong ? wrong_currents_ + 1 : 0;
    return currents_known_ >= kKnown && wrong_currents_ >= kWrong ? Verdict::kCurrentsIgnored : Verdict::kFine;
  }
  /// (in realtime) It must be asked again soon: the last answer was wrong, for once.
  bool doubtful() const noexcept { return (mode_known_ && wrong_mode_ > 0) || (currents_known_ >= kKnown && wrong_currents_ > 0); }

 private:
  static constexpr int kModes = 2, kWrong = 4, kKnown = 3;      // answers
  static constexpr int kNoise = 12;                            // digits, 0.1 N: of the sensor
  static constexpr double kGain = 0.1;                         // of what was told: the sensor's scale
  static constexpr std::int64_t kWindowNs = 20000000;          // a motor's current follows within one or two of them
  struct Told {
    int low = 0, high = 0, before_low = 0, before_high = 0;
    std::int64_t since_ns = 0;
  };
  std::array<Told, kMaxBoardMotors> told_{};
  bool mode_known_ = false;
  int wrong_mode_ = 0, wrong_currents_ = 0, currents_known_ = 0;
};

}  // namespace haptic
