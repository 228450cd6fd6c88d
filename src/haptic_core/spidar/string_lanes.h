/// One number per string with a capacity known to the compiler, kept in vector registers. Internal.
///
/// Eigen's fixed-size arrays do the same arithmetic, but the compiler stops inlining their expression
/// templates in functions of this size: the warm solve took a third longer.
#pragma once
#include <cstdint>

namespace haptic {

#ifdef __AVX__
inline constexpr int kPacketWidth = 4;
using StringPacket = double __attribute__((vector_size(32)));
inline double sumOf(const StringPacket& p) {
  return (p[0] + p[2]) + (p[1] + p[3]);
}
#else
inline constexpr int kPacketWidth = 2;
using StringPacket = double __attribute__((vector_size(16)));
inline double sumOf(const StringPacket& p) {
  return p[0] + p[1];
}
#endif

/// Capacity 4, 8 or 16; what is beyond the device's strings is padding that no sum feels.
template <int kLanes>
struct StringLane {
  static constexpr int kPackets = kLanes / kPacketWidth;
  StringPacket packet[kPackets];

  double operator[](int i) const { return packet[i / kPacketWidth][i % kPacketWidth]; }
  void set(int i, double value) { packet[i / kPacketWidth][i % kPacketWidth] = value; }

  static StringLane constant(double value) {
    StringLane lane;
    for (StringPacket& p : lane.packet) p = StringPacket{} + value;
    return lane;
  }
  double dot(const StringLane& b) const {
    StringPacket total = packet[0] * b.packet[0];
    for (int k = 1; k < kPackets; ++k) total += packet[k] * b.packet[k];
    return sumOf(total);
  }
  double squaredNorm() const { return dot(*this); }
};

/// Applies `operation` packet by packet.
template <int kLanes, class Operation>
inline StringLane<kLanes> eachPacket(Operation operation) {
  StringLane<kLanes> out;
  for (int k = 0; k < StringLane<kLanes>::kPackets; ++k) out.packet[k] = operation(k);
  return out;
}

template <int kLanes>
inline StringLane<kLanes> operator+(const StringLane<kLanes>& a, const StringLane<kLanes>& b) {
  return eachPacket<kLanes>([&](int k) { return a.packet[k] + b.packet[k]; });
}
template <int kLanes>
inline StringLane<kLanes> operator-(const StringLane<kLanes>& a, const StringLane<kLanes>& b) {
  return eachPacket<kLanes>([&](int k) { return a.packet[k] - b.packet[k]; });
}
template <int kLanes>
inline StringLane<kLanes> operator*(const StringLane<kLanes>& a, const StringLane<kLanes>& b) {
  return eachPacket<kLanes>([&](int k) { return a.packet[k] * b.packet[k]; });
}
template <int kLanes>
inline StringLane<kLanes> operator*(double a, const StringLane<kLanes>& b) {
  return eachPacket<kLanes>([&](int k) { return a * b.packet[k]; });
}
template <int kLanes>
inline StringLane<kLanes> clamp(const StringLane<kLanes>& a, const StringLane<kLanes>& low,
                                const StringLane<kLanes>& high) {
  return eachPacket<kLanes>([&](int k) {
    const StringPacket raised = a.packet[k] < low.packet[k] ? low.packet[k] : a.packet[k];
    return raised > high.packet[k] ? high.packet[k] : raised;
  });
}
/// A bit per string with a ≤ b.
template <int kLanes>
inline std::uint32_t bitsNotAbove(const StringLane<kLanes>& a, const StringLane<kLanes>& b) {
  using Mask = decltype(a.packet[0] <= b.packet[0]);
  Mask bit, sum{};
  for (int j = 0; j < kPacketWidth; ++j) bit[j] = 1ll << j;
  for (int k = 0; k < StringLane<kLanes>::kPackets; ++k)
    sum |= (a.packet[k] <= b.packet[k]) & (bit << (k * kPacketWidth));
  long long bits = 0;
  for (int j = 0; j < kPacketWidth; ++j) bits |= sum[j];
  return static_cast<std::uint32_t>(bits);
}
/// Where a equals b: `then`, else `otherwise`.
template <int kLanes>
inline StringLane<kLanes> whereEqual(const StringLane<kLanes>& a, const StringLane<kLanes>& b,
                                     const StringLane<kLanes>& then, const StringLane<kLanes>& otherwise) {
  return eachPacket<kLanes>(
      [&](int k) { return a.packet[k] == b.packet[k] ? then.packet[k] : otherwise.packet[k]; });
}

/// One lane per column of a structure matrix.
template <int kLanes, int kColumns>
struct StringColumns {
  StringLane<kLanes> column[kColumns];

  /// Σ_c weight_c column_c.
  template <class Weights>
  StringLane<kLanes> combine(const Weights& weight) const {
    return eachPacket<kLanes>([&](int k) {
      StringPacket sum = column[0].packet[k] * weight[0];
      for (int c = 1; c < kColumns; ++c) sum += column[c].packet[k] * weight[c];
      return sum;
    });
  }
};

/// Smallest capacity that holds `strings`.
inline int laneCapacity(int strings) {
  return strings <= 4 ? 4 : strings <= 8 ? 8 : 16;
}

}  // namespace haptic
