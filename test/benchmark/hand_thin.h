/// Presses of tools through thin bodies (test/scenes/thin_presses.h): figures `hand.thin.*`.
#pragma once

namespace haptic::bench {

/// Presses [first, first + presses). Each of them that rings, jumps, gives energy or is felt less than by the direct coupling is printed.
void measureThinPresses(int presses, int first);

}  // namespace haptic::bench
