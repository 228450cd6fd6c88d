/// A delay added on purpose between a grip and its pointer: for studies of delay, and to try a slower wire.
///
/// The line gives back what went in n = round(τ/h) ticks ago, so a delay is told to half a tick. A pose that is τ_x old and a force that
/// is τ_F old act on a wall as one longer hold (spidar/wall_bound.h): the loop bears K' = 1/(1/K + (τ_x + τ_F)/B), and weakens a contact
/// to it. Cost: one copy a tick; the memory of a recording grows by n entries.
#pragma once
#include <cmath>
#include <cstddef>
#include <vector>

namespace haptic {

/// Longest delay of a pose or of a force [s]: beyond it a relaxed hand bears less than 50 N/m, and nothing feels like a wall.
inline constexpr double kMostAddedDelay = 0.2;

/// Delays that a hand gets beside those of its wire.
struct AddedDelay {
  double pose = 0;   ///< of the grip's pose on its way to the pointer [s]
  double force = 0;  ///< of the world's wrench on its way to the grip [s]

  double total() const noexcept { return pose + force; }  ///< that a wall is felt with [s]
  bool operator==(const AddedDelay& o) const noexcept { return pose == o.pose && force == o.force; }  ///< both

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.pose), visit(s.force);
  }
};

/// Whole ticks of `h` [s] that come nearest to `delay` [s]; 0 for a delay out of bounds, which its hand refuses.
inline std::size_t ticksOf(double delay, double h) noexcept {
  return delay > 0 && delay <= kMostAddedDelay ? static_cast<std::size_t>(std::lround(delay / h)) : 0;
}

/// What went in a fixed number of ticks ago. Allocates in the constructor alone.
template <class T>
class DelayLine {
 public:
  /// `ticks` times T{} are in it.
  explicit DelayLine(std::size_t ticks) : ring_(ticks) {}

  /// (in realtime) Takes `now` in, and gives the value of `ticks` calls ago.
  T through(const T& now) noexcept {
    if (ring_.empty()) return now;
    at_ %= ring_.size();  // a recording may have been changed
    const T before = ring_[at_];
    ring_[at_] = now;
    at_ = at_ + 1;
    return before;
  }
  /// (in realtime) As if `value` had been taken all the time.
  void fill(const T& value) noexcept {
    for (T& entry : ring_) entry = value;
  }

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.ring_), visit(s.at_);
  }

 private:
  std::vector<T> ring_;
  std::size_t at_ = 0;  ///< the oldest
};

}  // namespace haptic
