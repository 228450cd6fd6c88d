/// A group of the benchmark `islands`.
#pragma once

namespace haptic::bench {

/// Prints `scenes_at_10k`, the shipped scenes with a hand that hold 10 kHz in CPU time of the ticking thread, and of how many.
void measureScenesAt10k();

}  // namespace haptic::bench
