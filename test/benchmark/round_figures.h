/// Figures of round bodies in motion, printed by `bench round`.
#pragma once

namespace haptic::bench {

void measureRoundMotion();   ///< one body that rolls, against closed forms
void measureRollingBalls();  ///< SimBenchmark's rolling, against its closed form
void measureSix();           ///< SimBenchmark's 666, beside ODE

}  // namespace haptic::bench
