/// What the real-time thread hands over of one tick for recordings: its input, and hashes of what came of it.
#pragma once
#include "haptic_core/loop/tick_hash.h"
#include "haptic_core/loop/tick_input.h"

namespace haptic {

struct RecordedTick {
  TickInput input;
  TickHash hash;  ///< parts = 0: not made
};

}  // namespace haptic
