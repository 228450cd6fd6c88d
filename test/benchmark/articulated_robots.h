/// Published robots: what a step of them costs.
#pragma once

namespace haptic::bench {

/// Prints panda.step_us, panda.realtime_factor and allegro.step_us of the scenes panda_touch and allegro_grasp; what they lack is named
/// on standard error.
void measureRobots();

}  // namespace haptic::bench
