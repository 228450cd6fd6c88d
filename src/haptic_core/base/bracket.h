/// The root of a function that changes its sign from below to above: regula falsi that lets no end stay.
///
/// Where the same end is kept twice, its value counts less, by 1 - f/f' with f, f' the last two values at the other end, or by half
/// where that is not positive (Anderson, Björck: A new high order method of regula falsi type, BIT 13, 1973). Of smooth functions it
/// converges with order 1.7, of others at least as halving would, often enough. Each value costs the caller one evaluation.
#pragma once
#include <algorithm>

namespace haptic {

/// An interval [low, high] with f(low) < 0 < f(high).
class Bracket {
 public:
  Bracket(double low, double f_low, double high, double f_high) noexcept
      : low_(low), f_low_(f_low), high_(high), f_high_(f_high) {}  ///< f_low < 0 < f_high

  /// (in realtime) Where the root may be: no nearer to an end than this share of the interval.
  double guess(double margin = 0) const noexcept {
    const double width = high_ - low_, secant = low_ + width * f_low_ / (f_low_ - f_high_);
    return std::clamp(secant, low_ + margin * width, high_ - margin * width);
  }

  /// (in realtime) The function's value at a guess.
  void take(double x, double f) noexcept {
    if (f > 0) {
      if (kept_ < 0) f_low_ *= weight(f / f_high_);
      high_ = x, f_high_ = f, kept_ = -1;
    } else {
      if (kept_ > 0) f_high_ *= weight(f / f_low_);
      low_ = x, f_low_ = f, kept_ = 1;
    }
  }

 private:
  static double weight(double ratio) noexcept { return ratio < 1 ? 1 - ratio : 0.5; }

  double low_, f_low_, high_, f_high_;
  int kept_ = 0;  ///< the end that the last value left: -1 low, 1 high
};

}  // namespace haptic
