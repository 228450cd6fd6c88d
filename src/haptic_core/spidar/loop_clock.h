/// Was this program on time, how long have the boards been silent while it was, and may force come back by itself?
///
/// Three things make a silence, and this is the one place that tells them apart:
///   - the boards: they were asked on time and did not answer. `silence_` counts that, in ticks that were on time: a tick adds at most
///     two periods, whatever the clock says, so nothing that is old because this program did not run accuses a board;
///   - this program: two exchanges lie farther apart than a period and kLate (SIGSTOP, a busy core, a debugger). The runner says so
///     (TimeLost), and the steady clock of the samples does: the end of an exchange is the latch of the counts and their age
///     (transport.h). A simulated device has no stamps; the runner's word holds for both;
///   - the machine: it slept. The steady clock stands still meanwhile, CLOCK_BOOTTIME does not (loop/realtime.h): the runner says so.
/// Whatever made it, `absent_` counts the true time without counts. Beyond kLasting nobody knows what the hand does by now, or whether
/// there is one: force waits for a person who asks for it.
#pragma once
#include <algorithm>

#include "haptic_core/spidar/transport.h"

namespace haptic {

/// Time before an exchange in which the loop did not run, beyond its period.
struct TimeLost {
  double seconds = 0;   ///< by the clock that goes on while the machine sleeps [s]
  bool asleep = false;  ///< the machine slept during a part of it

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.seconds), visit(s.asleep);
  }
};

/// Tells a late program from a silent board, and an interruption from a silence that lasts.
class LoopClock {
 public:
  /// Longest silence from which force comes back by itself [s]. Boards are brought back into step in 60 ms, over the slowest wire in
  /// 0.4 s; in half a second nobody lets go of a grip and leaves.
  static constexpr double kLasting = 0.5;

  /// (in realtime) One exchange, nominally h [s] after the last; `lost`: it left counts that are too old, or none.
  void take(const DeviceSample& sample, bool lost, double h, const TimeLost& stood = {}) noexcept {
    const double now = sample.stamp_ns == 0 ? 0 : 1e-9 * static_cast<double>(sample.stamp_ns) + 1e-6 * sample.age_us;
    gap_ = now > 0 && end_ > 0 ? std::max(0.0, now - end_) : h;
    if (stood.seconds > 0) gap_ = std::max(gap_, h + stood.seconds);
    end_ = now;
    const bool late = gap_ > h + kLate;
    if (late) late_by_ = gap_ - h, asleep_ = stood.asleep;
    excuse_ = late ? gap_ + kExcuse : std::max(0.0, excuse_ - gap_);
    const double on_time = std::min(gap_, 2 * h);
    heard_ = lost ? 0 : heard_ + on_time;
    lost_now_ = lost;
    lost_ = lost || (lost_ && heard_ < (silenceLasts() ? kBackForGood : kBack));
    silence_ = lost ? silence_ + on_time : lost_ ? silence_ : 0;
    absent_ = lost ? absent_ + gap_ : lost_ ? absent_ : 0;
  }
  /// (in realtime) Another runner begins with the device: the time until then is nobody's silence.
  void handOver() noexcept { *this = LoopClock(); }

  double gap() const { return gap_; }          ///< since the exchange before [s]
  double lateBy() const { return late_by_; }   ///< the last time that it was late [s]
  bool late() const { return excuse_ > 0; }    ///< it was, and counts may be old because of that
  bool asleep() const { return asleep_; }      ///< it was late because the machine slept
  /// Without an exchange, or without counts, for so long that force waits for a person who asks.
  bool forceWaits() const { return absence() > kLasting; }
  double absence() const { return std::max(gap_, absent_); }  ///< true time without an exchange or without counts [s]
  /// Counts were too old, and have not come for long enough since: no flicker between two states.
  bool linkLost() const { return lost_; }
  bool lostNow() const { return lost_now_; }   ///< in this exchange
  bool silenceLasts() const { return silence_ > kLasting; }  ///< that is no interruption any more
  /// Boards were asked on time for longer than an answer may take: their silence is theirs.
  bool silenceIsTheirs() const { return silence_ > kTheirs; }

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.end_), visit(s.gap_), visit(s.late_by_), visit(s.excuse_), visit(s.heard_), visit(s.silence_), visit(s.absent_);
    visit(s.lost_), visit(s.lost_now_), visit(s.asleep_);
  }

 private:
  static constexpr double kLate = 0.01;     ///< [s]; the guard turns motors off after 12 ms. Smaller: a busy desktop says so often
  static constexpr double kExcuse = 0.1;    ///< [s] behind a stall: boards that the guard turned off are brought back into step
  static constexpr double kBack = 0.05;     ///< [s] of counts until a link that was lost is back
  static constexpr double kBackForGood = 0.3;  ///< [s] likewise after a silence that lasted: boards that fall out of step again
  static constexpr double kTheirs = 0.02;   ///< [s], as FreshnessSettings::limit_s
  double end_ = 0, gap_ = 0, late_by_ = 0, excuse_ = 0, heard_ = 0, silence_ = 0, absent_ = 0;
  bool lost_ = false, lost_now_ = false, asleep_ = false;
};

}  // namespace haptic
