/// Hashes of a tick's results, small enough to keep for every tick: two runs are the same while their hashes are.
#pragma once
#include <array>
#include <cstdint>

#include "haptic_core/loop/haptic_loop.h"

namespace haptic {

/// The world as a whole, and its parts, so that a difference can be told to the first body. Parts: the world's links,
/// then the hands. Links beyond `kMaxParts` - kMaxHands share the last slot of the links.
struct TickHash {
  /// Slots of `part`.
  static constexpr int kMaxParts = 64;
  std::uint64_t world = 0;                          ///< World::hash() after the tick
  /// Slots in use.
  int parts = 0;
  /// Of the links' states, then of the hands'.
  std::array<std::uint32_t, kMaxParts> part{};


  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.world), visit(s.parts);
    for (int i = 0; i < s.parts && i < kMaxParts; ++i) visit(s.part[i]);  // the others are not in use
  }

  /// Bit for bit.
  bool operator==(const TickHash& other) const noexcept;
};

/// (in realtime) Of the loop after a tick. About 1 ns per number of the state.
void hashTick(HapticLoop& loop, TickHash& hash) noexcept;

}  // namespace haptic
