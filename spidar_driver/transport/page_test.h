/// Page's test: which of two explanations holds, from one observation after the other?
///
/// Each observation adds log(p(it | fault) / p(it | sound)), and the sum never falls below 0: of all tests that alarm as seldom by chance
/// it sees a fault soonest (E. S. Page, Continuous inspection schemes, Biometrika 41, 1954). The wire has no checksum, so that one
/// observation is never enough: it adds kMost at most.
#pragma once
#include <algorithm>

namespace haptic {

/// Sums up evidence until it decides.
class PageTest {
 public:
  void add(double likelihood) noexcept { sum_ = std::max(0.0, sum_ + std::min(likelihood, kMost)); }  ///< (in realtime)
  bool decided() const noexcept { return sum_ > kDecided; }
  double sum() const noexcept { return sum_; }
  static constexpr double kMost = 7;      ///< of one observation: three must agree
  static constexpr double kDecided = 20;  ///< by chance once in e^20 independent observations, 20 days at 300 a second

 private:
  double sum_ = 0;
};

}  // namespace haptic
