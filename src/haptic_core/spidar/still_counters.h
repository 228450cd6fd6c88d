/// Do counters stand still that ought to move? Three kinds of other evidence say so.
///
/// A board that repeats its last counts looks like a grip at rest.
/// Force: a hand gives way, 1 N moves a relaxed one (500 N/m) by 2 mm and the firmest (5 N/mm) by 0.2 mm, seven counts.
///   Counters that show none of it for 50 ms are stuck, or the grip is clamped.
/// Motion so far: a grip that decelerates evenly through rest stays within one step s for T only when its deceleration is
///   below 8 s / T²; it has then moved at no more than 8 s (τ + T/2) / T² on average over the last τ. One that was three times
///   faster and shows nothing for T has not stopped: its counters have.
/// The other boards' counters: no counter of a board changes, and two of them miss kMissing steps of what their rate and its change
///   foretold, while others go on. The lengths must contradict each other besides (device_diagnosis.cpp). A string that is
///   stuck alone has neighbours on its board that move; strings that turn round foretell that they stop.
/// At a constant force a grip that lay still all the time says nothing, and nothing is put into the hand to find out.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "haptic_core/base/decay.h"
#include "haptic_core/base/spatial.h"
#include "haptic_core/spidar/device_def.h"

namespace haptic {

/// Notices counters that stand still although something says that they should not.
class StillCounters {
 public:
  static constexpr double kForceChange = 1;  ///< [N]; less, and a firm grip moves by less than a few counts
  static constexpr double kTime = 0.05;      ///< [s] since that change; a grip of 0.1 kg in a hand moves within 20 ms
  static constexpr double kRest = 0.015;     ///< T [s]; longer: slower motions tell as well, later

  /// Set-up: the strings and the steps of their counters.
  explicit StillCounters(const DeviceDef& def) : strings_(static_cast<int>(def.strings.size())) {
    for (int i = 0; i < strings_; ++i) {
      step_[i] = std::fabs(def.strings[static_cast<std::size_t>(i)].length_per_count);
      coarsest_ = std::max(coarsest_, step_[i]);
    }
    // Strings follow each other in the order of the boards (DeviceDef::boards); B5M has eight motors, those with force sensors three.
    int first = 0;
    for (std::size_t b = 0; b < def.boards.size() && first < strings_; ++b) {
      const std::string& model = def.boards[b];
      first += model == "B5M" ? 8 : !model.empty() && model.back() == 'F' ? 3 : 4;
      end_[boards_++] = std::min(first, strings_);
    }
  }

  void forget() noexcept {  ///< (in realtime) another pose, or a gap
    known_ = false;
    forgetForce();
  }
  void forgetForce() noexcept { under_force_ = 0, force_known_ = false; }  ///< (in realtime) no force acts

  /// (in realtime) New counts, h [s] after the last.
  void take(const std::array<std::int64_t, kMaxStrings>& counts, double h) noexcept {
    if (!known_) {
      std::copy(counts.begin(), counts.end(), counts_);
      for (int i = 0; i < kMaxStrings; ++i) rate_[i] = slow_rate_[i] = missing_[i] = since_[i] = waited_[i] = 0;
      known_ = true, still_ = 0;
      return;
    }
    bool moved = false;
    for (int i = 0; i < strings_; ++i) moved = moved || counts[static_cast<std::size_t>(i)] != counts_[i];
    still_ = moved ? 0 : still_ + h;
    moving_ = 0;
    for (int i = 0; i < strings_; ++i) {
      const double change = static_cast<double>(counts[static_cast<std::size_t>(i)] - counts_[i]);
      since_[i] = change != 0 ? 0 : since_[i] + h;
      // The rates wait while a string shows nothing: they are those that it had. Once it steps again the wait was slow, and counts.
      const double change_of_rate = (rate_[i] - slow_rate_[i]) / (kSlowMean - kMean);
      const double foretold = std::fabs(rate_[i]) + (rate_[i] < 0 ? -1 : 1) * change_of_rate * since_[i];
      missing_[i] = change != 0 ? 0 : missing_[i] + std::max(0.0, foretold) * h;
      waited_[i] += h;
      if (change != 0 || missing_[i] < 1) {
        const double now = change / waited_[i];  // strings that move have waited alike
        rate_[i] = now + mean_.over(waited_[i]) * (rate_[i] - now);
        slow_rate_[i] = now + slow_mean_.over(waited_[i]) * (slow_rate_[i] - now);
        waited_[i] = 0;
      }
      moving_ += change != 0;
      counts_[i] = counts[static_cast<std::size_t>(i)];
    }
    if (moved) force_known_ = false, under_force_ = 0;
  }
  /// (in realtime) And the force [N] that has acted meanwhile. True: it changed, and no counter did.
  bool stuckUnder(const Vector3& force, double h) noexcept {
    if (!force_known_) low_ = high_ = force, force_known_ = true;
    low_ = low_.cwiseMin(force);
    high_ = high_.cwiseMax(force);
    under_force_ = (high_ - low_).norm() >= kForceChange ? under_force_ + h : 0;
    return under_force_ >= kTime;
  }
  /// All of them, of a grip that was moving. A string that had stopped before the others says nothing of how they stopped.
  bool frozen() const noexcept {
    if (still_ < kRest) return false;
    double fastest = 0;
    for (int i = 0; i < strings_; ++i) {
      if (since_[i] - still_ < kMean) fastest = std::max(fastest, std::fabs(rate_[i]) * step_[i]);
    }
    return fastest > tellingSpeed();
  }
  /// A string that was slower than this [m/s] may have stopped as it stands still: only force tells then.
  double tellingSpeed() const noexcept { return 3 * 8 * coarsest_ * (kMean + kRest / 2) / (kRest * kRest); }
  /// Bit per string of a board that repeats its counts while others go on; 0: none.
  std::uint32_t boardStill() const noexcept {
    for (int b = 0, first = 0; b < boards_; first = end_[b++]) {
      int still = 0, missing = 0;
      for (int i = first; i < end_[b]; ++i) still += since_[i] >= kBoardRest, missing += missing_[i] >= kMissing;
      if (still == end_[b] - first && missing > 1 && moving_ > 0) return ((1u << (end_[b] - first)) - 1) << first;
    }
    return 0;
  }

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.known_), visit(s.force_known_), visit(s.counts_), visit(s.low_), visit(s.high_), visit(s.under_force_), visit(s.still_);
    visit(s.moving_), visit(s.rate_), visit(s.slow_rate_), visit(s.missing_), visit(s.since_), visit(s.waited_);
  }

 private:
  static constexpr double kMean = 0.005;     ///< τ [s], over which the rates are taken: five counts at 17 mm/s
  static constexpr double kSlowMean = 0.015; ///< [s]; the difference of the two tells how the rate changes
  static constexpr double kMissing = 3;      ///< [counts]; a string at 0.1 m/s misses them within a tick
  static constexpr double kBoardRest = 0.0025;  ///< [s]; three readings at 1 kHz

  Decay mean_{kMean}, slow_mean_{kSlowMean};
  int strings_, boards_ = 0;
  int end_[kMaxStrings] = {};  ///< of each board's strings
  double step_[kMaxStrings] = {}, coarsest_ = 0;  ///< [m]
  std::int64_t counts_[kMaxStrings] = {};
  bool known_ = false, force_known_ = false;
  Vector3 low_ = Vector3::Zero(), high_ = Vector3::Zero();  ///< of the force since the counts last changed [N]
  double under_force_ = 0;                                  ///< since it changed by so much [s]
  double still_ = 0;                                        ///< since any count changed [s]
  int moving_ = 0;                                          ///< strings whose count just changed
  double rate_[kMaxStrings] = {}, slow_rate_[kMaxStrings] = {};  ///< [counts/s]
  double missing_[kMaxStrings] = {}, since_[kMaxStrings] = {};   ///< [counts], [s] since it last changed
  double waited_[kMaxStrings] = {};                              ///< that its rates do not count yet [s]
};

}  // namespace haptic
