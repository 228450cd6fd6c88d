/// All inputs of one tick of the loop beside its own memory and the commands before it: a recording keeps them, a replay gives
/// them back.
#pragma once
#include <array>
#include <cstdint>

#include "haptic_core/spidar/loop_clock.h"

namespace haptic {

/// Devices that one loop can carry.
inline constexpr int kMaxHands = 4;

/// Everything that one tick of the loop takes in.
struct TickInput {
  std::uint64_t tick = 0;  ///< index since the start
  int lost_periods = 0;    ///< ticks that were lost before this one: simulated time has waited
  bool asleep = false;     ///< the machine slept during a part of them
  /// Valid entries of `sample`.
  int hands = 0;
  std::array<DeviceSample, kMaxHands> sample;  ///< per hand

  /// (in realtime) What the loop did not run for, of ticks of h [s].
  TimeLost lost(double h) const noexcept { return {h * lost_periods, asleep}; }

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.tick), visit(s.lost_periods), visit(s.asleep), visit(s.hands);
    for (int i = 0; i < s.hands && i < kMaxHands; ++i) visit(s.sample[i]);  // the others are not valid
  }
};

/// Lost periods and whether the machine slept in one word, as recordings keep them; those of before never slept.
inline std::uint32_t lostWord(const TickInput& input) noexcept {
  return static_cast<std::uint32_t>(input.lost_periods) | (input.asleep ? 1u << 31 : 0u);
}
/// Both out of such a word.
inline void takeLostWord(std::uint32_t word, TickInput& input) noexcept {
  input.lost_periods = static_cast<int>(word & ~(1u << 31));
  input.asleep = (word >> 31) != 0;
}

}  // namespace haptic
