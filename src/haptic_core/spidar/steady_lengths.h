/// Where within its counts a string is, for a loop that is stiff against one count.
///
/// A count says that a length lies within half a count q of it. A wall that took the middle for the length would meet a grip that
/// swings by little more than q/2 with up to 4/π of its stiffness (the describing function of rounding), and K_max leaves no such room
/// (wall_bound.h): the grip hummed by one or two counts, 0.16 N each at 4571 N/m. Friction of K q/2 would stop that (Diolaiti, Niemeyer,
/// Barbagli, Salisbury, IEEE Trans. Robotics 22(2), 2006), but strings and a relaxed hand have none.
/// So a string is read at the place within its count's interval that is nearest to the middle of its swing. With c the counted length,
/// m half way between its extremes in the last 25 to 50 ms, e = c - m,
///     l = c - o(e),    o(e) = e where |e| ≤ q/2, from there on falling to 0 at |e| = W.
/// l is a function of c while the swing lasts, so it has no lag that could give energy, and its describing function is at most 1. A
/// string that trembles on the edge of a count has its middle there and reads the same. One that moves on is read as counted, one that
/// stays comes to its count within 0.1 s. Readings that lagged (l nearest to the last l) or went on at their last rate hummed more; a
/// low-pass in place of m was still on its way when the motion was over, and hummed until it came.
/// The reading is as true as the count: both are within the count's interval.
#pragma once
#include <algorithm>
#include <cmath>

#include "haptic_core/base/decay.h"
#include "haptic_core/spidar/device_def.h"

namespace haptic {

/// Reads the lengths of a device's strings.
class SteadyLengths {
 public:
  /// Set-up: the strings' counts.
  explicit SteadyLengths(const DeviceDef& def) {
    quantum_ = StringVector::Zero(static_cast<Eigen::Index>(def.strings.size()));
    for (Eigen::Index i = 0; i < quantum_.size(); ++i) {
      quantum_[i] = std::fabs(def.strings[static_cast<std::size_t>(i)].length_per_count);
    }
    startAt(quantum_);
  }

  void forget() noexcept { known_ = false; }  ///< (in realtime) the next lengths do not follow the last

  /// (in realtime) The readings of the lengths that the counts say [m], h [s] after the last.
  StringVector read(const StringVector& counted, double h) noexcept {
    if (!known_) startAt(counted);
    known_ = true;
    since_ += h;
    if (since_ >= kHalfWindow) {
      low_before_ = low_, high_before_ = high_;
      low_ = high_ = counted;
      since_ = 0;
    }
    const double gain = 1 - smooth_.over(h);
    StringVector length = counted;
    for (Eigen::Index i = 0; i < length.size(); ++i) {
      const double c = counted[i], most = kMotion * quantum_[i];
      low_[i] = std::min(low_[i], c);
      high_[i] = std::max(high_[i], c);
      const double middle = 0.5 * (std::min(low_[i], low_before_[i]) + std::max(high_[i], high_before_[i]));
      middle_[i] = c - std::clamp(c - middle_[i] - gain * (middle - middle_[i]), -most, most);
      length[i] -= offset(c - middle_[i], quantum_[i]);
    }
    return length;
  }

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.known_), visit(s.since_), visit(s.middle_), visit(s.low_), visit(s.high_), visit(s.low_before_), visit(s.high_before_);
  }

 private:
  /// Half of the time over which a swing is seen [s]: less, and the hum of a hand of 0.3 kg, 30 Hz, is taken for motion; twice, and a
  /// string that has come to rest hums for longer.
  static constexpr double kHalfWindow = 0.025;
  static constexpr double kSmooth = 0.01;  ///< of m [s]: the window's steps would be felt as 0.08 N
  /// W [counts]: less, and l rises by more than 1.2 counts a count; more, and a string must move further before it is read as counted.
  static constexpr double kMotion = 4;

  /// o(e)
  static double offset(double e, double q) noexcept {
    const double size = std::fabs(e);
    return std::copysign(size <= 0.5 * q ? size : std::max(0.0, 0.5 * (kMotion * q - size) / (kMotion - 0.5)), e);
  }
  void startAt(const StringVector& counted) noexcept {
    middle_ = low_ = high_ = low_before_ = high_before_ = counted;
    since_ = 0;
  }

  Decay smooth_{kSmooth};
  StringVector quantum_, middle_, low_, high_, low_before_, high_before_;  ///< [m]
  double since_ = 0;                                                       ///< of this half of the window [s]
  bool known_ = false;
};

}  // namespace haptic
