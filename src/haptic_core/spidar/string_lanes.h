/// One number per string with a capacity known to the compiler, kept in vector registers. Internal.
///
/// Eigen's fixed-size arrays do the same arithmetic, but the compiler stops inlining their expression
/// templates in functions of this size: the warm solve took a third longer.
#pragma once
#include <cstdint>

#include "haptic_core/base/lanes.h"

namespace haptic {

/// One number per string, kept in vector registers.
/// Capacity 4, 8 or 16; lanes beyond the device's strings are padding that no sum feels.
template <int kLanes>
struct StringLane {
  static constexpr int kPackets = kLanes / 4;  ///< registers
  Lanes packet[kPackets];                      ///< strings four by four

  double operator[](int i) const { return packet[i / 4][i % 4]; }  ///< of string i
  void set(int i, double value) { packet[i / 4][i % 4] = value; }  ///< of string i

  /// The same for all strings, padding included.
  static StringLane constant(double value) {
    StringLane lane;
    for (Lanes& p : lane.packet) p = lanes(value);
    return lane;
  }
  /// Over all strings, padding included.
  double dot(const StringLane& b) const {
    Lanes total = packet[0] * b.packet[0];
    for (int k = 1; k < kPackets; ++k) total += packet[k] * b.packet[k];
    return sum(total);
  }
  double squaredNorm() const { return dot(*this); }  ///< over all strings, padding included
};

/// Applies `operation` packet by packet.
template <int kLanes, class Operation>
inline StringLane<kLanes> eachPacket(Operation operation) {
  StringLane<kLanes> out;
  for (int k = 0; k < StringLane<kLanes>::kPackets; ++k) out.packet[k] = operation(k);
  return out;
}

/// String by string.
template <int kLanes>
inline StringLane<kLanes> operator+(const StringLane<kLanes>& a, const StringLane<kLanes>& b) {
  return eachPacket<kLanes>([&](int k) { return a.packet[k] + b.packet[k]; });
}
/// String by string.
template <int kLanes>
inline StringLane<kLanes> operator-(const StringLane<kLanes>& a, const StringLane<kLanes>& b) {
  return eachPacket<kLanes>([&](int k) { return a.packet[k] - b.packet[k]; });
}
/// String by string.
template <int kLanes>
inline StringLane<kLanes> operator*(const StringLane<kLanes>& a, const StringLane<kLanes>& b) {
  return eachPacket<kLanes>([&](int k) { return a.packet[k] * b.packet[k]; });
}
/// Scaled.
template <int kLanes>
inline StringLane<kLanes> operator*(double a, const StringLane<kLanes>& b) {
  return eachPacket<kLanes>([&](int k) { return lanes(a) * b.packet[k]; });
}
/// String by string into [low, high].
template <int kLanes>
inline StringLane<kLanes> clamp(const StringLane<kLanes>& a, const StringLane<kLanes>& low,
                                const StringLane<kLanes>& high) {
  return eachPacket<kLanes>([&](int k) { return minimum(high.packet[k], maximum(low.packet[k], a.packet[k])); });
}
/// A bit per string with a ≤ b.
template <int kLanes>
inline std::uint32_t bitsNotAbove(const StringLane<kLanes>& a, const StringLane<kLanes>& b) {
  unsigned set = 0;
  for (int k = 0; k < StringLane<kLanes>::kPackets; ++k) set |= bits(a.packet[k] <= b.packet[k]) << (4 * k);
  return set;
}
/// Where a equals b: `then`, else `otherwise`.
template <int kLanes>
inline StringLane<kLanes> whereEqual(const StringLane<kLanes>& a, const StringLane<kLanes>& b,
                                     const StringLane<kLanes>& then, const StringLane<kLanes>& otherwise) {
  return eachPacket<kLanes>([&](int k) { return select(a.packet[k] == b.packet[k], then.packet[k], otherwise.packet[k]); });
}

/// One lane per column of a structure matrix.
template <int kLanes, int kColumns>
struct StringColumns {
  StringLane<kLanes> column[kColumns];  ///< column c of the matrix, by string

  /// Σ_c weight_c column_c.
  template <class Weights>
  StringLane<kLanes> combine(const Weights& weight) const {
    return eachPacket<kLanes>([&](int k) {
      Lanes sum = column[0].packet[k] * lanes(weight[0]);
      for (int c = 1; c < kColumns; ++c) sum += column[c].packet[k] * lanes(weight[c]);
      return sum;
    });
  }
};

/// Smallest capacity that holds `strings`.
inline int laneCapacity(int strings) {
  return strings <= 4 ? 4 : strings <= 8 ? 8 : 16;
}

}  // namespace haptic
