/// All inputs of one tick of the loop beside its own memory and the commands before it: a recording keeps them, a replay gives
/// them back.
#pragma once
#include <array>
#include <cstdint>

#include "haptic_core/spidar/transport.h"

namespace haptic {

/// Devices that one loop can carry.
inline constexpr int kMaxHands = 4;

/// Everything that one tick of the loop takes in.
struct TickInput {
  std::uint64_t tick = 0;  ///< index since the start
  int lost_periods = 0;    ///< ticks that were lost before this one: simulated time has waited
  /// Valid entries of `sample`.
  int hands = 0;
  std::array<DeviceSample, kMaxHands> sample;  ///< per hand

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.tick), visit(s.lost_periods), visit(s.hands);
    for (int i = 0; i < s.hands && i < kMaxHands; ++i) visit(s.sample[i]);  // the others are not valid
  }
};

}  // namespace haptic
