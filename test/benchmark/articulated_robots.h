/// Published robots: do they load whole, and what does a step of them cost.
#pragma once

namespace haptic::bench {

/// Prints robots.tried, robots.loaded, robots.collisions_lost over every .urdf below HAPTIC_ROBOTS (default:
/// shared/example-robot-data beside the repository), and panda.step_us, panda.realtime_factor, allegro.step_us of
/// the scenes panda_touch and allegro_grasp. Robots that are refused are named on standard error.
void measureRobots();

}  // namespace haptic::bench
