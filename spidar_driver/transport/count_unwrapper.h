/// Follows a 16-bit counter over its wraps, and keeps readings out that no motor can have made.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace haptic {

/// The wire has no checksum: a changed byte looks like a jump of up to 2¹⁵ counts. A string has a velocity, and its motor
/// a greatest torque over its own inertia: a reading is taken when it lies where the last velocity leads, within what the
/// greatest acceleration can have changed since. One that does not is refused. When the next fits the old line again, it
/// was a disturbed byte. When kConfirm in a row agree with each other instead, the counter moved: either the string was
/// jerked, then some motion within that acceleration leads from the old line to the new one, or the counter itself jumped: an
/// encoder slipped, or the board started anew. It is followed either way; which of them it was others judge, who see more
/// than one counter (BoardAnswers, CountScreen).
class CountUnwrapper {
 public:
  enum class Result : unsigned char { kAccepted, kRefused, kJumped };

  struct Limits {
    double speed = 1e6;         ///< fastest believable change [counts/s]
    double acceleration = 5e7;  ///< of a motor alone with its string, greatest torque over its inertia [counts/s²]
  };

  CountUnwrapper() = default;
  explicit CountUnwrapper(const Limits& limits) : limits_(limits) {}

  Result accept(std::int16_t reading, std::int64_t stamp_ns) noexcept {  ///< (in realtime)
    if (!started_) return take(reading, reading, stamp_ns, 0), started_ = true, Result::kAccepted;
    const double dt = seconds(stamp_ns - last_stamp_);
    const std::int16_t step = difference(reading, last_);
    const double off = step - expected(dt), suspect_off = offSuspects(reading, stamp_ns);
    // A disturbance small enough to be taken has bent the line: what fits the line before it is as good.
    const double off_before = difference(reading, before_.reading) -
                              before_.speed * std::min(seconds(stamp_ns - before_.stamp_ns), kUnseen);
    const bool fits = std::min(std::fabs(off), std::fabs(off_before)) <= limit(dt) &&
                      std::abs(static_cast<int>(step)) <= kFarthest;
    if (fits && (refused_ == 0 || std::min(std::fabs(off), std::fabs(off_before)) <= std::fabs(suspect_off))) {
      if (std::fabs(off_before) < std::fabs(off)) last_ = before_.reading, last_stamp_ = before_.stamp_ns;
      return take(count_ + step, reading, stamp_ns, seconds(stamp_ns - last_stamp_)), Result::kAccepted;
    }
    const bool agrees = refused_ > 0 && std::fabs(suspect_off) <= limit(seconds(stamp_ns - suspect_stamp_));
    if (agrees) {
      const double since = seconds(stamp_ns - suspect_stamp_);
      if (since > 0) suspect_speed_ = difference(reading, suspect_) / since;
      ++refused_;
    } else {
      refused_ = 1;
      suspect_speed_ = speed_;
    }
    suspect_ = reading;
    suspect_stamp_ = stamp_ns;
    if (refused_ < kConfirm) return Result::kRefused;
    const bool jerked = wasJerked(step, dt);
    jump_ = static_cast<int>(std::lround(step - expected(dt)));
    take(count_ + step, reading, stamp_ns, 0);
    speed_ = std::fabs(suspect_speed_) <= limits_.speed ? suspect_speed_ : 0;
    return jerked ? Result::kAccepted : Result::kJumped;
  }

  std::int64_t count() const { return count_; }
  int jump() const { return jump_; }              ///< of the last kJumped, off the line [counts]
  /// (in realtime) What the counter was at an instant between its last two readings, on the line between them; the last
  /// reading elsewhere. Boards are read one after the other: 0.2 ms apart, a string at 1 m/s has moved 0.2 mm.
  std::int64_t countAt(std::int64_t at_ns) const noexcept {
    const double dt = seconds(last_stamp_ - before_.stamp_ns), back = seconds(last_stamp_ - at_ns);
    if (!(back < dt) || dt > kUnseen) return count_;
    return count_ - std::llround(difference(last_, before_.reading) * (back / dt));
  }

 private:
  static constexpr int kConfirm = 3;  // readings; two changed bytes in a row that agree are not seen in practice
  // Jitter of the stamps: a busy machine sends up to so much later than it noted [s], and half a millimetre of counts
  // besides [counts].
  static constexpr double kJitter = 0.5e-3;
  static constexpr int kSlack = 22;
  static constexpr int kFarthest = 16383;  // [counts], a quarter of the range is never believed at once
  // Time for which a string is believed to have moved unseen at full speed [s], 100 mm at 20 m/s. After a longer silence
  // a greater step counts as a restart: the board may have lost power.
  static constexpr double kUnseen = 5e-3;

  static double seconds(std::int64_t ns) { return std::max(0.0, 1e-9 * static_cast<double>(ns)); }
  static std::int16_t difference(std::int16_t a, std::int16_t b) {
    return static_cast<std::int16_t>(static_cast<std::uint16_t>(a) - static_cast<std::uint16_t>(b));
  }
  double expected(double dt) const { return speed_ * std::min(dt, kUnseen); }
  double limit(double dt) const {
    const double unseen = limits_.speed * std::min(dt, kUnseen);
    const double pulled = dt > kUnseen ? unseen : std::min(limits_.acceleration * dt * dt, unseen);
    return kSlack + std::fabs(speed_) * kJitter + pulled;
  }
  /// How far a reading lies off the line that the refused ones before it began.
  double offSuspects(std::int16_t reading, std::int64_t stamp_ns) const {
    if (refused_ == 0) return 0;
    return difference(reading, suspect_) - suspect_speed_ * std::min(seconds(stamp_ns - suspect_stamp_), kUnseen);
  }
  /// Some motion within the acceleration leads from the last good line to the new one: between two given velocities a
  /// path of length dt is off their mean by at most a dt² / 4.
  bool wasJerked(int travelled, double dt) const {
    if (dt > kUnseen || std::fabs(suspect_speed_) > limits_.speed) return false;
    const double mean = 0.5 * (speed_ + suspect_speed_) * dt;
    return std::fabs(travelled - mean) <= 0.25 * limits_.acceleration * dt * dt + kSlack;
  }
  void take(std::int64_t count, std::int16_t reading, std::int64_t stamp_ns, double dt) {
    before_ = started_ ? Line{last_, last_stamp_, speed_} : Line{reading, stamp_ns, 0};
    if (dt > 0) speed_ = std::clamp(difference(reading, last_) / std::max(dt, kLeastTime), -limits_.speed, limits_.speed);
    count_ = count;
    last_ = reading;
    last_stamp_ = stamp_ns;
    refused_ = 0;
  }
  static constexpr double kLeastTime = 1e-4;  // [s] between two readings that tell a velocity

  struct Line {
    std::int16_t reading = 0;
    std::int64_t stamp_ns = 0;
    double speed = 0;  ///< [counts/s]
  };

  Limits limits_;
  Line before_;  ///< as it was before the last reading that was taken
  double speed_ = 0, suspect_speed_ = 0;  ///< [counts/s]
  std::int64_t count_ = 0, last_stamp_ = 0, suspect_stamp_ = 0;
  std::int16_t last_ = 0, suspect_ = 0;
  int refused_ = 0, jump_ = 0;
  bool started_ = false;
};

}  // namespace haptic
