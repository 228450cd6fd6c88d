/// May a pose be shown and force be on? The one place that says so.
///
/// The invariant: force is on only while counts of *every* board, fresh and plausible, have arrived within the last
/// `limit_s`, and while it will still be so when the command in the making has been replaced by the next. It is bounded in
/// time, not in samples: a command computed from counts of t0 leaves with the next exchange and acts until the one after.
/// Beside it: lost answers are a rate with a limit, and the age of the counts is the delay in the bound of wall_bound.h.
#pragma once
#include <algorithm>

#include "haptic_core/spidar/transport.h"
#include "haptic_core/spidar/wall_bound.h"

namespace haptic {

/// Limits on the age of counts, on lost answers and on the wire's delay.
struct FreshnessSettings {
  double limit_s = 0.02;        ///< counts older than this: no pose and no current. 20 ticks; a hand moves 20 mm in it
  double lost_reduce = 0.1;     ///< share of the exchanges without an answer of every board: only a small force
  double lost_fault = 0.5;      ///< likewise: none. A board that is deaf to half of its commands does not obey
  double lost_time_s = 0.05;    ///< the share's low-pass: five losses in a row at 1 kHz make 10 %, 35 make 50 %
  double delay_time_s = 0.25;   ///< the delay's low-pass: one late answer is no slower wire
  double least_stiffness = 1e3; ///< [N/m] a wall softer than twice a relaxed hand (500 N/m) is none: force is refused
};

/// How old and how complete the counts of a device are. Fed at every exchange.
class Freshness {
 public:
  explicit Freshness(const FreshnessSettings& settings) : settings_(settings) {}  ///< nothing has arrived yet

  /// (in realtime) One exchange, h [s] after the last. `plausible`: no count moved as no string can.
  void take(const DeviceSample& sample, bool plausible, double h) noexcept {
    const double arrived = 1e-6 * sample.age_us, delayed = std::min(arrived, settings_.limit_s);
    age_ = bringsCounts(sample.status) && plausible ? arrived : std::max(age_ + h, arrived);
    const double lost = std::min(1.0, static_cast<double>(sample.lost));
    lost_ += std::min(1.0, h / settings_.lost_time_s) * (lost - lost_);
    if (!bringsCounts(sample.status)) return;  // silence is no delay, and what is older than the limit is old, not slow
    delay_ = known_ ? delay_ + std::min(1.0, h / settings_.delay_time_s) * (delayed - delay_) : delayed;
    known_ = true;
  }

  /// Between two latches of counts there was more than the limit: whatever acted meanwhile acted on old ones.
  bool gap(std::int64_t from_ns, std::int64_t to_ns) const noexcept {
    return from_ns > 0 && tooLong(1e-9 * static_cast<double>(to_ns - from_ns));
  }
  bool tooLong(double seconds) const noexcept { return seconds > settings_.limit_s; }  ///< for what acted all the while
  void forgetLosses() noexcept { lost_ = 0; }  ///< (in realtime) the user says that the cause is gone

  bool fresh() const noexcept { return age_ <= settings_.limit_s; }  ///< a pose of these counts may be shown
  /// A command computed now leaves h later, and its successor 2h later, with half a period for the wire.
  bool carriesForce(double h) const noexcept { return carriesForce(age_, h); }
  bool carriesForce(double age, double h) const noexcept { return age + kReach * h <= settings_.limit_s; }  ///< counts of that age [s]
  bool lossy() const noexcept { return lost_ > settings_.lost_reduce; }   ///< only a small force is allowed
  bool failing() const noexcept { return lost_ > settings_.lost_fault; }  ///< no force is allowed
  double age() const noexcept { return age_; }        ///< of the oldest board's counts [s]
  double lostShare() const noexcept { return lost_; } ///< of the exchanges [1]
  double delay() const noexcept { return delay_; }    ///< mean age of the counts [s]: the wire's part of the loop's delay

  /// Largest wall [N/m] that a relaxed hand on a device of this damping [N·s/m] keeps stable over this wire.
  double stableStiffness(double device_damping, double known_delay, double h) const noexcept {
    return largestWallStiffness(device_damping + kRelaxedHandDamping, 0, h, loopDelay(h, std::max(delay_, known_delay)));
  }
  /// A wire that allows less gets no force [N/m].
  double leastStiffness() const noexcept { return settings_.least_stiffness; }

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.age_), visit(s.lost_), visit(s.delay_), visit(s.known_);
  }

 private:
  static constexpr double kReach = 2.5;  // [periods]
  FreshnessSettings settings_;
  double age_ = 1e9, lost_ = 0, delay_ = 0;
  bool known_ = false;
};

}  // namespace haptic
