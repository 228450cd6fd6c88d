/// Does a board do what it is told, as its reply to ALL says?
///
/// The reply names the mode, which every CURRENT that is taken in sets, and on boards that sense them (B3M, B3F) the motors'
/// currents in the digits of the command. A measured current is right when it lies within what the motor was told lately, and when the
/// currents follow: with x the change of what the motors were told and y that of what they measure, both since an answer before, a
/// board that obeys shows y = x and one that does not y = 0, whatever the offset of its sensors. A board that has never been right
/// (another firmware) proves nothing and is not accused. Kinds of wrong answers must come in a row: the
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
    t.told = follow(t.told, digit, seconds(now_ns - t.told_ns), kLag);
    t.now = digit;
    t.told_ns = now_ns;
  }

  /// (in realtime) ALL goes out behind that cycle.
  void ask() noexcept {
    for (Told& t : told_) t.asked = t.told, t.settled = std::fabs(t.now - t.told) <= kSettled;
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
    compareChanges(std::min(motors, shape.currents), reply);
    const bool ignored = (currents_known_ >= kKnown && wrong_currents_ >= kWrong) || (followed_ >= kKnown && stands_ >= kStands);
    return ignored ? Verdict::kCurrentsIgnored : Verdict::kFine;
  }
  /// (in realtime) It must be asked again soon: the last answer was wrong, for once.
  bool doubtful() const noexcept { return (mode_known_ && wrong_mode_ > 0) || (currents_known_ >= kKnown && wrong_currents_ > 0); }

 private:
  static double seconds(std::int64_t ns) noexcept { return std::max(0.0, 1e-9 * static_cast<double>(ns)); }
  static double follow(double mean, double now, double dt, double over) noexcept { return mean + dt / (over + dt) * (now - mean); }

  /// Do the currents follow what they are told?
  void compareChanges(int motors, const AllReply& reply) noexcept {
    double told = 0, stands = 0, follows = 0;  // Σ x², Σ y², Σ (x - y)² [digits²]
    for (int m = 0; m < motors; ++m) {
      const Told& t = told_[static_cast<std::size_t>(m)];
      if (!t.settled) return;
      const double x = t.asked - t.told_before, y = reply.current[static_cast<std::size_t>(m)] - t.measured_before;
      told += x * x, stands += y * y, follows += (x - y) * (x - y);
    }
    const double noise = motors * kSensor * kSensor;
    const bool may_stand = stands <= 0.1 * told + noise, may_follow = follows <= 0.25 * told + noise;
    if (may_stand && may_follow) return;  // too little has changed
    if (may_stand) {
      stands_ += told >= kTelling * noise;
      return;
    }
    followed_ += may_follow;
    stands_ = 0;
    for (int m = 0; m < motors; ++m) {
      Told& t = told_[static_cast<std::size_t>(m)];
      t.told_before = t.asked, t.measured_before = reply.current[static_cast<std::size_t>(m)];
    }
  }

  static constexpr int kModes = 2, kWrong = 4, kKnown = 3, kStands = 3;  // answers
  static constexpr double kLag = 2e-3;      // [s] in which a motor's current follows
  static constexpr double kSettled = 3;     // digits; more is still on its way
  static constexpr double kSensor = 4.2;    // digits, of a measured change: twice its standard deviation
  static constexpr double kTelling = 2.8;   // of what noise can make: 7 digits of each motor, 0.07 N
  static constexpr int kNoise = 12;                            // digits, 0.1 N: of the sensor
  static constexpr double kGain = 0.1;                         // of what was told: the sensor's scale
  static constexpr std::int64_t kWindowNs = 20000000;          // a motor's current follows within one or two of them
  struct Told {
    int low = 0, high = 0, before_low = 0, before_high = 0;
    std::int64_t since_ns = 0, told_ns = 0;
    double now = 0, told = 0, asked = 0;      ///< digits: the last, with the lag of a motor, that as ALL went out
    double told_before = 0, measured_before = 0;  ///< digits, of the answer that changes are counted from
    bool settled = false;                     ///< as ALL went out
  };
  std::array<Told, kMaxBoardMotors> told_{};
  bool mode_known_ = false;
  int wrong_mode_ = 0, wrong_currents_ = 0, currents_known_ = 0;
  int stands_ = 0, followed_ = 0;  ///< answers that say that the currents stand, that they follow
};

}  // namespace haptic
