/// The share of an exponential memory that is left after a time.
#pragma once
#include "haptic_core/base/elementary.h"

namespace haptic {

/// exp(-h / time) for a step h that hardly ever changes: the last result is kept. A result depends on its own h alone.
class Decay {
 public:
  explicit Decay(double time) : time_(time) {}  ///< [s]

  /// (in realtime) Over h [s].
  double over(double h) noexcept {
    if (h != h_) h_ = h, left_ = elementary::exp(-h / time_);
    return left_;
  }

 private:
  double time_, h_ = 0, left_ = 1;
};

}  // namespace haptic
