/// Numbers for scenes that look random.
#pragma once
#include <cstdint>

namespace haptic::scenes {

/// From −1 to 1, the same on every machine.
class Offsets {
 public:
  double next() {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;  // Knuth's MMIX
    return static_cast<double>(static_cast<std::int64_t>(state_ >> 11)) * 0x1p-52 - 1;
  }

 private:
  std::uint64_t state_ = 20261123;
};

}  // namespace haptic::scenes
