/// Instructions of a tick of the shipped scenes: a part of bench_scenes.
#pragma once

namespace haptic::bench {

/// Runs a scene ("touch_cube") at a rate ("1000", Hz) where callgrind counts its ticks.
void countTicks(const char* scene, const char* rate);

/// Prints scenes.tick_instructions_ratio and the like; nothing without valgrind.
void measureTicks();

}  // namespace haptic::bench
