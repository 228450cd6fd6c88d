/// Are the counts that answer CURRENT of now? The full answer to ALL, asked right behind it, says where the motors are.
///
/// An answer to CURRENT carries no number: one that an adapter or a board repeats a few cycles late looks like any other, and a late
/// position is a delay in the loop that nobody sees. ALL is answered by another packet, latched dt later. With v the rate of a motor's
/// counts, r = p_ALL - p_CURRENT - v dt is rounding where the counts are of now, and v T besides where they are T old. Each comparison
/// adds the logarithm of how much likelier the latter is,
///     l = Σ (v r T - (v T)² / 2) / σ²,   σ² ≈ δ (1 - δ) + kNoise² + ((v - v_slow) dt)²,   δ = |v dt| mod 1,
/// the first term of σ² being the rounding of a difference of two counts, the last what acceleration makes of v; their sum decides
/// (page_test.h). T is a cycle, the least that a repeated answer can be late. A motion of 20 mm/s, half a count a cycle, is enough
/// within 0.1 s.
/// Where the motion has turned since, v says nothing about r: a counter that is off by more than any motion since adds the most as well.
/// Answers that are repeated from several cycles ago go back along the way that they came: they jump, and then are, motor by motor and
/// reading by reading, those of a fixed number of cycles before. Three in a row decide (kMost), before the jump is taken for a slip.
/// A board, or its simulation, may always latch the two otherwise: the age that it has shown from the start is taken off, up to
/// kUsual; before that is known only ages of several cycles count. At rest old counts are the counts of now, and nothing is said.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "spidar_driver/transport/board_protocol.h"
#include "spidar_driver/transport/page_test.h"

namespace haptic {

/// Compares the counts of one board's two kinds of answers.
class AnswerAge {
 public:
  void begin(double cycle_s) noexcept {  ///< (in realtime) the boards were brought into step
    *this = AnswerAge();
    cycle_ = cycle_s;
  }

  /// (in realtime) An answer to CURRENT, latched at `stamp_ns`.
  void take(int motors, const MotorWords& position, std::int64_t stamp_ns) noexcept {
    const double dt = 1e-9 * static_cast<double>(stamp_ns - stamp_ns_);
    const bool near = known_ && dt > 0 && dt < kGap;
    bool follows = near;
    for (int m = 0; m < motors; ++m) {
      const auto i = static_cast<std::size_t>(m);
      follows = follows && std::fabs(step(position[i], position_[i]) - fast_[i] * dt) < kFar + kFarTime * std::fabs(fast_[i]);
    }
    for (int m = 0; m < motors; ++m) {
      const auto i = static_cast<std::size_t>(m);
      const double rate = near ? step(position[i], position_[i]) / dt : 0;
      // What does not follow is another motion, or a disturbed byte: rates begin anew.
      const auto average = [&](double& mean, double now, double over) { mean = follows ? mean + dt / (over + dt) * (now - mean) : rate; };
      average(slow_[i], rate, kSlow);
      average(quick_[i], rate, kQuick);
      average(quick_mean_[i], quick_[i], kQuick);
      fast_[i] = 2 * quick_[i] - quick_mean_[i];  // without the lag of a mean while the rate changes evenly
    }
    if (known_) seekRepeat(motors, position, follows);
    history_[head_++ % kHistory] = position;
    position_ = position;
    stamp_ns_ = stamp_ns;
    since_ = follows ? since_ + dt : 0;
    known_ = true;
  }

  /// (in realtime) The answer to ALL, latched at `stamp_ns`. Returns the logarithm of how much likelier it is that the counts are old.
  double compare(int motors, const MotorWords& position, std::int64_t stamp_ns) noexcept {
    const double dt = 1e-9 * static_cast<double>(stamp_ns - stamp_ns_);
    if (since_ < kSettled || dt <= 0 || dt > kApart) return 0;
    const double usual = usual_known_ ? usual_ : 0, age = usual_known_ ? cycle_ : std::max(kUnknown, cycle_);
    double likelihood = 0, along = 0, weight = 0;
    bool far = false;
    for (int m = 0; m < motors; ++m) {
      const auto i = static_cast<std::size_t>(m);
      const double v = slow_[i], r = step(position[i], position_[i]) - fast_[i] * dt;
      const double way = std::max(std::fabs(fast_[i]), std::fabs(v)) * dt, part = way - std::floor(way), turned = (fast_[i] - v) * dt;
      const double variance = std::max(part * (1 - part), kRounding) + kNoise * kNoise + turned * turned;
      likelihood += (v * age * (r - v * usual) - 0.5 * v * age * v * age) / variance;
      along += v * r, weight += v * v;
      far = far || std::fabs(r) > kFar + kFarTime * std::max(std::fabs(fast_[i]), std::fabs(v));
    }
    if (far) likelihood = PageTest::kMost;
    evidence_.add(likelihood);
    if (!far && evidence_.sum() < 0.5 * PageTest::kDecided) learn(along, weight, stamp_ns);
    return likelihood;
  }
  const PageTest& evidence() const noexcept { return evidence_; }

 private:
  /// Is this reading one of before, as the last one was, or a jump back to one?
  void seekRepeat(int motors, const MotorWords& position, bool follows) noexcept {
    if (lag_ > 0 && position == before(lag_)) return evidence_.add(PageTest::kMost);
    lag_ = 0;
    bool jumps = false;
    for (std::size_t i = 0; i < static_cast<std::size_t>(motors); ++i)
      jumps = jumps || std::fabs(step(position[i], position_[i])) > kFar;
    if (follows || !jumps) return;
    const std::uint32_t kept = std::min(head_, kHistory);
    for (std::uint32_t lag = 1; lag <= kept && lag_ == 0; ++lag)
      if (position == before(lag)) lag_ = lag;
    if (lag_ > 0) evidence_.add(PageTest::kMost);
  }
  const MotorWords& before(std::uint32_t lag) const noexcept { return history_[(head_ - lag) % kHistory]; }

  /// What it always shows. A block waits for the next one, and none is learned while counts look old: an age that begins is not taken
  /// for the usual one. (Learning only from what looks sound would learn an age below the true one.)
  void learn(double along, double weight, std::int64_t now_ns) noexcept {
    block_along_ += along, block_weight_ += weight;
    if (1e-9 * static_cast<double>(now_ns - block_ns_) < kBlock) return;
    usual_along_ += before_along_, usual_weight_ += before_weight_;
    before_along_ = block_along_, before_weight_ = block_weight_;
    block_along_ = block_weight_ = 0;
    block_ns_ = now_ns;
    const double known = usual_weight_ * kUsualSigma * kUsualSigma;
    if (known < 1) return;
    usual_ = std::clamp(usual_along_ / usual_weight_, -kUsual, kUsual);
    usual_known_ = true;
    if (known > kUsualMemory) usual_along_ *= 0.5, usual_weight_ *= 0.5;
  }
  static double step(std::int16_t a, std::int16_t b) noexcept {
    return static_cast<std::int16_t>(static_cast<std::uint16_t>(a) - static_cast<std::uint16_t>(b));
  }

  static constexpr std::uint32_t kHistory = 256;  ///< readings
  static constexpr double kSlow = 8e-3;      ///< [s] of v as a direction: shorter, and rounding hides a motion of 20 mm/s
  static constexpr double kQuick = 3e-3;     ///< [s] of v over dt: longer, and a hand's shaking looks like an age
  static constexpr double kGap = 5e-3;       ///< [s] between two answers that tell a rate
  static constexpr double kSettled = 25e-3;  ///< [s] of answers until rates are rates
  static constexpr double kApart = 3e-3;     ///< [s]; two latches further apart are not compared: the motion may have changed
  static constexpr double kNoise = 0.14;     ///< [counts] of the rates over dt
  static constexpr double kRounding = 0.1;   ///< [counts²] at least: latches are not as regular as that
  static constexpr double kFar = 8;          ///< [counts]; a jerk of 1000 m/s² makes 4 of 20 um in 0.4 ms
  static constexpr double kFarTime = 2.5e-3; ///< [s]
  static constexpr double kUsual = 1.2e-3;   ///< [s], a cycle at 1 kHz and some
  static constexpr double kUnknown = 5e-3;   ///< [s], age that is looked for before the usual one is known
  static constexpr double kBlock = 0.1;      ///< [s]
  static constexpr double kUsualSigma = 0.3e-3;  ///< [s/count]: the usual age is known to 0.15 ms from then on
  static constexpr double kUsualMemory = 400;    ///< times that evidence: it is forgotten by halves

  PageTest evidence_;
  MotorWords position_{};
  std::array<MotorWords, kHistory> history_{};
  std::uint32_t head_ = 0, lag_ = 0;  ///< readings so far; of those that are repeated, how many readings ago: 0: none are
  std::array<double, kMaxBoardMotors> slow_{}, quick_{}, quick_mean_{}, fast_{};  ///< rates [counts/s]
  double cycle_ = 1e-3;  ///< between two questions [s]
  double since_ = 0;     ///< since the first of answers that follow each other [s]
  double usual_ = 0, usual_along_ = 0, usual_weight_ = 0;
  double block_along_ = 0, block_weight_ = 0, before_along_ = 0, before_weight_ = 0;
  std::int64_t stamp_ns_ = 0, block_ns_ = 0;
  bool known_ = false, usual_known_ = false;
};

}  // namespace haptic
