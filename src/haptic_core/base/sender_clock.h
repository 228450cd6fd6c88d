/// When a sender measured what it stamped, on the receiver's own clock.
///
/// Stamps tell exactly how far two messages lie apart, and nothing else for sure: a system's clock is set, a bag begins anew, another
/// machine has another time. The time of receipt never goes back, and wavers by the way of the message. So
///
///     own = stamp + offset,   offset ← offset + kTrust (heard − own),
///
/// which follows a sender whose second is longer or shorter than ours (a bag played at half its rate lags by (1 − ½) T / kTrust).
/// Where own and heard are farther apart than kLongestWay the sender's clock was set, or the messages waited: own = heard, anew.
/// Times never go back. Cost: a few additions.
#pragma once
#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace haptic {

/// Of one sender. All times in nanoseconds.
class SenderClock {
 public:
  /// The own time of a message with the sender's `stamp` that was heard at `heard` of the own clock. Zero is no stamp.
  /// A stamp that comes again is the same measurement, and has the same own time.
  std::int64_t own(std::int64_t stamp, std::int64_t heard) noexcept {
    if (stamp == 0) return latest_ = std::max(latest_, heard);
    if (stamp == stamp_ && std::abs(heard - latest_) <= kLongestWay) return latest_;
    const std::int64_t late = heard - (stamp + offset_);
    const bool anew = stamp_ == 0 || std::abs(late) > kLongestWay;
    offset_ += anew ? late : late / kTrust;
    stamp_ = stamp;
    return latest_ = std::max(latest_, stamp + offset_);
  }

 private:
  /// Half of the tenth of a second within which a frame is followed again [ns]. Shorter: a busy machine begins anew all the time, and
  /// speeds waver by the times of receipt. Longer: a clock that is set by less is noticed that much later.
  static constexpr std::int64_t kLongestWay = 50'000'000;
  /// One part in so many of a message's delay moves the offset [1]. Fewer: speeds waver with each delay. More: a sender whose seconds
  /// are longer lags, and begins anew again and again.
  static constexpr std::int64_t kTrust = 16;

  std::int64_t stamp_ = 0, offset_ = 0, latest_ = 0;
};

}  // namespace haptic
