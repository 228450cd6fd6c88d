/// A hash of numbers, to tell whether two runs are the same bit for bit.
#pragma once
#include <cstdint>
#include <cstring>

namespace haptic {

inline constexpr std::uint64_t kHashStart = 0xcbf29ce484222325ull;  ///< where every hash begins: FNV-1a's offset basis

/// (in realtime) A rotation, a sum modulo 2 and a product for each word of 8 bytes: three instructions. All three steps can be undone, so
/// words that differ in one place never have the same hash. The product carries a difference upwards, the rotation brings it down to the
/// low bits of the next word's. 1.3 ns per word; no secret, no defence against an adversary. `bytes` must be a multiple of 8.
inline std::uint64_t hashWords(std::uint64_t hash, const void* data, std::size_t bytes) noexcept {
  constexpr int kTurn = 29;                                 // bits: no divisor of 64, so that no bit soon returns to where it was
  constexpr std::uint64_t kFactor = 0x9e3779b97f4a7c15ull;  // 2⁶⁴ over the golden ratio, odd: half of its bits are set
  const auto* next = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < bytes; i += sizeof(std::uint64_t)) {
    std::uint64_t word;
    std::memcpy(&word, next + i, sizeof word);
    hash = ((hash << kTurn | hash >> (64 - kTurn)) ^ word) * kFactor;
  }
  return hash;
}

}  // namespace haptic
