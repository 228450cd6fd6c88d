/// Was this program on time, and how long have the boards been silent while it was?
///
/// The end of an exchange is known on the steady clock: latch of the counts and their age (transport.h). Two ends that lie
/// farther apart than a period and kLate mean that this program did not run, whoever took its time (SIGSTOP, a busy core, a
/// debugger). Nothing that is old then accuses a board. Silence is therefore counted in ticks that were on time: a tick adds
/// at most two periods, whatever the clock says. A simulated device has no stamps: its ticks are on time by definition.
#pragma once
#include <algorithm>

#include "haptic_core/spidar/transport.h"

namespace haptic {

/// Tells a late program from a silent board.
class LoopClock {
 public:
  /// (in realtime) One exchange, nominally h [s] after the last; `lost`: it left counts that are too old, or none.
  void take(const DeviceSample& sample, bool lost, double h) noexcept {
    const double now = sample.stamp_ns == 0 ? 0 : 1e-9 * static_cast<double>(sample.stamp_ns) + 1e-6 * sample.age_us;
    gap_ = now > 0 && end_ > 0 ? std::max(0.0, now - end_) : h;
    end_ = now;
    const bool late = gap_ > h + kLate;
    if (late) late_by_ = gap_ - h;
    excuse_ = late ? gap_ + kExcuse : std::max(0.0, excuse_ - gap_);
    const double on_time = std::min(gap_, 2 * h);
    heard_ = lost ? 0 : heard_ + on_time;
    lost_now_ = lost;
    lost_ = lost || (lost_ && heard_ < (silenceLasts() ? kBackForGood : kBack));
    silence_ = lost ? silence_ + on_time : lost_ ? silence_ : 0;
  }
  double gap() const { return gap_; }          ///< since the exchange before [s]
  double lateBy() const { return late_by_; }   ///< the last time that it was late [s]
  bool late() const { return excuse_ > 0; }    ///< it was, and counts may be old because of that
  /// Counts were too old, and have not come for long enough since: no flicker between two states.
  bool linkLost() const { return lost_; }
  bool lostNow() const { return lost_now_; }   ///< in this exchange
  bool silenceLasts() const { return silence_ > kLasting; }  ///< that is no interruption any more
  /// Boards were asked on time for longer than an answer may take: their silence is theirs.
  bool silenceIsTheirs() const { return silence_ > kTheirs; }

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.end_), visit(s.gap_), visit(s.late_by_), visit(s.excuse_), visit(s.heard_), visit(s.silence_);
    visit(s.lost_), visit(s.lost_now_);
  }

 private:
  static constexpr double kLate = 0.01;     ///< [s]; the guard turns motors off after 12 ms. Smaller: a busy desktop says so often
  static constexpr double kExcuse = 0.1;    ///< [s] behind a stall: boards that the guard turned off are brought back into step
  static constexpr double kBack = 0.05;     ///< [s] of counts until a link that was lost is back
  static constexpr double kBackForGood = 0.3;  ///< [s] likewise after a silence that lasted: boards that fall out of step again
  static constexpr double kLasting = 0.5;   ///< [s]; boards are brought back into step in 60 ms, over the slowest wire in 0.4 s
  static constexpr double kTheirs = 0.02;   ///< [s], as FreshnessSettings::limit_s
  double end_ = 0, gap_ = 0, late_by_ = 0, excuse_ = 0, heard_ = 0, silence_ = 0;
  bool lost_ = false, lost_now_ = false;
};

}  // namespace haptic
