/// What is left of a memory after a time.
#pragma once
#include "haptic_core/base/elementary.h"

namespace haptic {

/// exp(-h / time), for callers who mostly ask for the same h: the last answer is kept. A number for each h, whatever was asked before.
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
