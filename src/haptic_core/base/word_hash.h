/// A hash of numbers, to tell whether two runs are the same bit for bit.
#pragma once
#include <cstdint>
#include <cstring>

namespace haptic {

/// FNV-1a's offset basis: where every hash begins.
inline constexpr std::uint64_t kHashStart = 0xcbf29ce484222325ull;

/// (in realtime) FNV-1a in words of 8 bytes instead of bytes, with the upper half folded down after each product so
/// that every bit of a double reaches the low bits. 1 ns per word; no secret, no defence against an adversary.
/// `bytes` must be a multiple of 8.
inline std::uint64_t hashWords(std::uint64_t hash, const void* data, std::size_t bytes) noexcept {
  const auto* next = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < bytes; i += sizeof(std::uint64_t)) {
    std::uint64_t word;
    std::memcpy(&word, next + i, sizeof word);
    hash = (hash ^ word) * 0x100000001b3ull;
    hash ^= hash >> 32;
  }
  return hash;
}

}  // namespace haptic
