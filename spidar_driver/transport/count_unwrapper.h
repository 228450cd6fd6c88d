/// Follows a 16-bit counter over its wraps, and keeps readings out that no string can have made.
#pragma once
#include <cstdint>
#include <cstdlib>

namespace haptic {

/// The wire has no checksum: one flipped high bit looks like a jump of up to 2¹⁵ counts, and taking it would
/// leave the unwrapped count a full turn of the counter off for ever. A reading farther from the last
/// accepted one than the fastest string could go is therefore refused, until kConfirm readings in a row agree
/// with each other: then the counter itself was restarted (board reset) or slipped, and the new count is
/// taken over.
class CountUnwrapper {
 public:
  enum class Result : unsigned char { kAccepted, kRefused, kRestarted };

  /// `counts_per_second`: fastest believable change of the counter.
  explicit CountUnwrapper(double counts_per_second = 1e6) : rate_(counts_per_second) {}

  Result accept(std::int16_t reading, std::int64_t stamp_ns) noexcept {  ///< (in realtime)
    if (!started_) return take(reading, reading, stamp_ns), started_ = true, Result::kAccepted;
    const std::int16_t step = difference(reading, last_);
    if (std::abs(step) <= limit(stamp_ns - last_stamp_)) {
      take(count_ + step, reading, stamp_ns);
      return Result::kAccepted;
    }
    const bool agrees =
        refused_ > 0 && std::abs(difference(reading, suspect_)) <= limit(stamp_ns - suspect_stamp_);
    refused_ = agrees ? refused_ + 1 : 1;
    suspect_ = reading;
    suspect_stamp_ = stamp_ns;
    if (refused_ < kConfirm) return Result::kRefused;
    take(count_ + step, reading, stamp_ns);
    return Result::kRestarted;
  }

  std::int64_t count() const { return count_; }

 private:
  static constexpr int kConfirm =
      3;  // readings; two flipped bytes in a row that agree are not seen in practice
  static constexpr int kSlack = 64;        // [counts], about 1.5 mm: jitter of the stamps at standstill
  static constexpr int kFarthest = 16383;  // [counts], a quarter of the range is never believed at once
  // Time for which a string is believed to have moved unseen at full speed [s], 100 mm at 20 m/s. After a
  // longer silence a greater step counts as a restart: the board may have lost power.
  static constexpr double kUnseen = 5e-3;

  static std::int16_t difference(std::int16_t a, std::int16_t b) {
    return static_cast<std::int16_t>(static_cast<std::uint16_t>(a) - static_cast<std::uint16_t>(b));
  }
  int limit(std::int64_t elapsed_ns) const {
    const double seconds = 1e-9 * static_cast<double>(elapsed_ns);
    const double counts = kSlack + rate_ * (seconds < kUnseen ? seconds : kUnseen);
    return counts < kFarthest ? static_cast<int>(counts) : kFarthest;
  }
  void take(std::int64_t count, std::int16_t reading, std::int64_t stamp_ns) {
    count_ = count;
    last_ = reading;
    last_stamp_ = stamp_ns;
    refused_ = 0;
  }

  double rate_;
  std::int64_t count_ = 0, last_stamp_ = 0, suspect_stamp_ = 0;
  std::int16_t last_ = 0, suspect_ = 0;
  int refused_ = 0;
  bool started_ = false;
};

}  // namespace haptic
