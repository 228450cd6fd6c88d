/// Do the counters stand still although the force on the hand changes?
///
/// A board that repeats its last counts looks like a grip at rest. But a hand gives way: 1 N moves a relaxed one (500 N/m) by
/// 2 mm and the firmest (5 N/mm) by 0.2 mm, seven counts. Counters that show none of it for 50 ms are stuck, or the grip is
/// clamped; either way the pose is not what the force acts on. At a constant force nothing is said: nothing is put into the hand.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>

#include "haptic_core/base/spatial.h"
#include "haptic_core/spidar/device_def.h"

namespace haptic {

/// Notices counters that stand still although the force on the hand changes.
class StillCounters {
 public:
  void forget() noexcept { *this = StillCounters(); }  ///< (in realtime)

  /// (in realtime) New counts, h [s] after the last, and the force [N] that has acted meanwhile. True: they are stuck.
  bool take(const std::array<std::int64_t, kMaxStrings>& counts, const Vector3& force, double h) noexcept {
    if (!known_ || !std::equal(counts.begin(), counts.end(), counts_)) {
      std::copy(counts.begin(), counts.end(), counts_);
      known_ = true;
      low_ = high_ = force;
      still_ = 0;
      return false;
    }
    low_ = low_.cwiseMin(force);
    high_ = high_.cwiseMax(force);
    still_ = (high_ - low_).norm() >= kForceChange ? still_ + h : 0;
    return still_ >= kTime;
  }

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.known_), visit(s.counts_), visit(s.low_), visit(s.high_), visit(s.still_);
  }

 private:
  static constexpr double kForceChange = 1;  ///< [N]; less, and a firm grip moves by less than a few counts
  static constexpr double kTime = 0.05;      ///< [s] since that change; a grip of 0.1 kg in a hand moves within 20 ms

  std::int64_t counts_[kMaxStrings] = {};
  bool known_ = false;
  Vector3 low_ = Vector3::Zero(), high_ = Vector3::Zero();  ///< of the force since the counts last changed [N]
  double still_ = 0;                                        ///< since it changed by so much [s]
};

}  // namespace haptic
