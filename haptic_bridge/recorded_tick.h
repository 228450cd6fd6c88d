/// What the real-time thread hands over of one tick for recordings: its input, and hashes of what came of it.
#pragma once
#include <array>
#include <cstdint>

#include "haptic_core/loop/tick_hash.h"
#include "haptic_core/loop/tick_input.h"

namespace haptic {

struct RecordedHand {
  DeviceSample sample;
  HandRequests requests;
};

struct RecordedTick {
  std::uint64_t tick = 0;
  std::int64_t start_ns = 0;         ///< steady clock
  int lost_periods = 0;
  bool paused = false;
  int hands = 0;
  std::array<RecordedHand, kMaxHands> hand;
  TickHash hash;                     ///< parts = 0: not made
};

}  // namespace haptic
