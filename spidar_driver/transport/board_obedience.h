/// Does a board do what it is told, as its reply to ALL says?
///
/// The reply names the mode, which every CURRENT that is taken in sets, and on boards that sense them (B3M, B3F) the motors'
/// currents in the digits of the command. A measured current is right when it lies within what the motor was told lately, and when the
/// currents follow: with x the changes that the motors were told and y those that they measure, about their means of kMean, a board that
/// obeys shows y = x and one that does not y = 0, whatever the offset of its sensors: Σ (x² / 2 - x y) / σ² decides (page_test.h). A
/// board that has never been right (another firmware) proves nothing and is not accused. Kinds of wrong answers must come in a row: the
/// wire has no checksum.
#pragma once
#include <algorithm>
#include <cmath>

#include "spidar_driver/transport/board_protocol.h"
#include "spidar_driver/transport/page_test.h"

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
  Verdict take(const BoardShape& shape, int motors, const AllReply& reply, std::int64_t now_ns) noexcept {
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
    compareChanges(std::min(motors, shape.currents), reply, seconds(now_ns - taken_ns_));
    taken_ns_ = now_ns;
    const bool ignored = (currents_known_ >= kKnown && wrong_currents_ >= kWrong) || (followed_ && stands_.decided());
    return ignored ? Verdict::kCurrentsIgnored : Verdict::kFine;
  }
  /// (in realtime) It must be asked again soon: the last answer was wrong, for once.
  bool doubtful() const noexcept { return (mode_known_ && wrong_mode_ > 0) || (currents_known_ >= kKnown && wrong_currents_ > 0); }

 private:
  static double seconds(std::int64_t ns) noexcept { return std::max(0.0, 1e-9 * static_cast<double>(ns)); }
  static double follow(double mean, double now, double dt, double over) noexcept { return mean + dt / (over + dt) * (now - mean); }

  /// Do the currents follow what they are told?
  void compareChanges(int motors, const AllReply& reply, double dt) noexcept {
    const bool anew = dt > kMean;  // nothing was asked for so long: the means are of before
    double likelihood = -kFade;
    for (int m = 0; m < motors; ++m) {
      Told& t = told_[static_cast<std::size_t>(m)];
      if (!t.settled) continue;
      const double measured = reply.current[static_cast<std::size_t>(m)];
      if (anew) t.mean_told = t.asked, t.mean_measured = measured;
      const double x = t.asked - t.mean_told, y = measured - t.mean_measured;
      likelihood += (0.5 * x * x - x * y) / (kSensor * kSensor);
      t.mean_told = follow(t.mean_told, t.asked, dt, kMean);
      t.mean_measured = follow(t.mean_measured, measured, dt, kMean);
    }
    stands_.add(likelihood);
    follows_.add(-likelihood);
    followed_ = followed_ || follows_.decided();
  }

  static constexpr int kModes = 2, kWrong = 4, kKnown = 3;  // answers
  static constexpr double kLag = 2e-3;      // [s] in which a motor's current follows
  static constexpr double kSettled = 10;    // digits; a step is still on its way
  static constexpr double kMean = 50e-3;    // [s]; longer, and a current that stands still looks for longer as if it followed
  static constexpr double kFade = 0.3;      // of an answer without a change: a suspicion does not wait for years
  static constexpr double kSensor = 3;      // digits, standard deviation of a measured change
  static constexpr int kNoise = 12;                            // digits, 0.1 N: of the sensor
  static constexpr double kGain = 0.1;                         // of what was told: the sensor's scale
  static constexpr std::int64_t kWindowNs = 20000000;          // a motor's current follows within one or two of them
  struct Told {
    int low = 0, high = 0, before_low = 0, before_high = 0;
    std::int64_t since_ns = 0, told_ns = 0;
    double now = 0, told = 0, asked = 0;      ///< digits: the last, with the lag of a motor, that as ALL went out
    double mean_told = 0, mean_measured = 0;  ///< digits
    bool settled = false;                     ///< as ALL went out
  };
  std::array<Told, kMaxBoardMotors> told_{};
  bool mode_known_ = false;
  int wrong_mode_ = 0, wrong_currents_ = 0, currents_known_ = 0;
  PageTest stands_, follows_;  ///< what its currents do
  std::int64_t taken_ns_ = 0;
  bool followed_ = false;  ///< they have
};

}  // namespace haptic
