/// Four doubles side by side: one AVX register where the build has AVX, two of 16 bytes elsewhere, through the
/// compilers' vector extension. The operations are the same either way, and so are the bits of the results and the layout:
/// structs that hold lanes cross the border between a library for AVX and a program for any processor. Functions that are not inline
/// take no lanes as arguments: their names would differ.
#pragma once
#include <cstdint>
#include <cstring>

#if defined(__AVX__) || defined(__SSE2__)
#include <immintrin.h>
#endif

namespace haptic {

#if defined(__AVX__)

using Lanes = double __attribute__((vector_size(32)));  ///< four doubles; the compiler brings the operators
/// What comparing two of them gives: all bits of a lane, or none.
using LaneMask = std::int64_t __attribute__((vector_size(32)));

/// |x|, lane by lane.
inline Lanes absolute(const Lanes& x) {
  return (Lanes)((LaneMask)x & LaneMask{INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX});
}
inline Lanes minimum(const Lanes& a, const Lanes& b) { return a < b ? a : b; }  ///< lane by lane
inline Lanes maximum(const Lanes& a, const Lanes& b) { return a > b ? a : b; }  ///< lane by lane

/// Bit i: lane i of a comparison's result.
inline unsigned bits(const LaneMask& m) { return static_cast<unsigned>(_mm256_movemask_pd((__m256d)m)); }
/// The inverse of `bits`.
inline LaneMask laneMask(unsigned bits) {
  const std::int64_t all = static_cast<std::int64_t>(bits);
  return (LaneMask{all, all, all, all} & LaneMask{1, 2, 4, 8}) != 0;
}
/// Lane by lane: where the mask is set that of `a`, else that of `b`.
inline Lanes select(const LaneMask& mask, const Lanes& a, const Lanes& b) { return mask ? a : b; }

/// Rows become columns.
inline void transpose(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d, Lanes& x, Lanes& y, Lanes& z,
                      Lanes& w) {
  const Lanes ab_xz = __builtin_shufflevector(a, b, 0, 4, 2, 6), ab_yw = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Lanes cd_xz = __builtin_shufflevector(c, d, 0, 4, 2, 6), cd_yw = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  x = __builtin_shufflevector(ab_xz, cd_xz, 0, 1, 4, 5);
  y = __builtin_shufflevector(ab_yw, cd_yw, 0, 1, 4, 5);
  z = __builtin_shufflevector(ab_xz, cd_xz, 2, 3, 6, 7);
  w = __builtin_shufflevector(ab_yw, cd_yw, 2, 3, 6, 7);
}

#else

// gcc takes 32-byte vectors apart through memory when there is no AVX; halves stay in registers.
using LanePair = double __attribute__((vector_size(16)));
using MaskPair = std::int64_t __attribute__((vector_size(16)));

struct alignas(32) LaneMask {
  MaskPair lower, upper;

  LaneMask operator&(const LaneMask& o) const { return {lower & o.lower, upper & o.upper}; }
  LaneMask operator|(const LaneMask& o) const { return {lower | o.lower, upper | o.upper}; }
};

struct alignas(32) Lanes {
  LanePair lower, upper;

  Lanes() = default;
  Lanes(double a, double b, double c, double d) : lower{a, b}, upper{c, d} {}
  Lanes(const LanePair& l, const LanePair& u) : lower(l), upper(u) {}
  double operator[](int i) const { return i < 2 ? lower[i] : upper[i - 2]; }
  double& operator[](int i) { return reinterpret_cast<double*>(this)[i]; }
  Lanes operator-() const { return {-lower, -upper}; }
  Lanes& operator+=(const Lanes& o) {
    lower += o.lower;
    upper += o.upper;
    return *this;
  }
};

inline Lanes operator+(const Lanes& a, const Lanes& b) { return {a.lower + b.lower, a.upper + b.upper}; }
inline Lanes operator-(const Lanes& a, const Lanes& b) { return {a.lower - b.lower, a.upper - b.upper}; }
inline Lanes operator*(const Lanes& a, const Lanes& b) { return {a.lower * b.lower, a.upper * b.upper}; }
inline Lanes operator/(const Lanes& a, const Lanes& b) { return {a.lower / b.lower, a.upper / b.upper}; }
inline LaneMask operator<(const Lanes& a, const Lanes& b) { return {a.lower < b.lower, a.upper < b.upper}; }
inline LaneMask operator>(const Lanes& a, const Lanes& b) { return {a.lower > b.lower, a.upper > b.upper}; }
inline LaneMask operator<=(const Lanes& a, const Lanes& b) { return {a.lower <= b.lower, a.upper <= b.upper}; }
inline LaneMask operator==(const Lanes& a, const Lanes& b) { return {a.lower == b.lower, a.upper == b.upper}; }
inline Lanes absolute(const Lanes& x) {
  const MaskPair mask{INT64_MAX, INT64_MAX};
  return {(LanePair)((MaskPair)x.lower & mask), (LanePair)((MaskPair)x.upper & mask)};
}
inline Lanes minimum(const Lanes& a, const Lanes& b) {
  return {a.lower < b.lower ? a.lower : b.lower, a.upper < b.upper ? a.upper : b.upper};
}
inline Lanes maximum(const Lanes& a, const Lanes& b) {
  return {a.lower > b.lower ? a.lower : b.lower, a.upper > b.upper ? a.upper : b.upper};
}

inline unsigned bits(const LaneMask& m) {
#if defined(__SSE2__)
  return static_cast<unsigned>(_mm_movemask_pd((__m128d)m.lower) | _mm_movemask_pd((__m128d)m.upper) << 2);
#else
  return static_cast<unsigned>((m.lower[0] & 1) | (m.lower[1] & 2) | (m.upper[0] & 4) | (m.upper[1] & 8));
#endif
}

inline LaneMask laneMask(unsigned bits) {
  // SSE2 compares no 64-bit integers.
  static constexpr MaskPair kPairs[4] = {{0, 0}, {-1, 0}, {0, -1}, {-1, -1}};
  return {kPairs[bits & 3], kPairs[bits >> 2 & 3]};
}
inline Lanes select(const LaneMask& mask, const Lanes& a, const Lanes& b) {
  return {mask.lower ? a.lower : b.lower, mask.upper ? a.upper : b.upper};
}

inline void transpose(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d, Lanes& x, Lanes& y, Lanes& z,
                      Lanes& w) {
  x = {__builtin_shufflevector(a.lower, b.lower, 0, 2), __builtin_shufflevector(c.lower, d.lower, 0, 2)};
  y = {__builtin_shufflevector(a.lower, b.lower, 1, 3), __builtin_shufflevector(c.lower, d.lower, 1, 3)};
  z = {__builtin_shufflevector(a.upper, b.upper, 0, 2), __builtin_shufflevector(c.upper, d.upper, 0, 2)};
  w = {__builtin_shufflevector(a.upper, b.upper, 1, 3), __builtin_shufflevector(c.upper, d.upper, 1, 3)};
}

#endif

/// Of four points (x, y, z, ·): x, y and z of all four.
inline void transpose(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d, Lanes& x, Lanes& y, Lanes& z) {
  Lanes unused;
  transpose(a, b, c, d, x, y, z, unused);
}

inline Lanes lanes(double x) { return Lanes{x, x, x, x}; }  ///< x in all lanes

/// √x, lane by lane, rounded correctly.
inline Lanes squareRoot(const Lanes& x) {
#if defined(__AVX__)
  return (Lanes)_mm256_sqrt_pd((__m256d)x);
#elif defined(__SSE2__)
  return {(LanePair)_mm_sqrt_pd((__m128d)x.lower), (LanePair)_mm_sqrt_pd((__m128d)x.upper)};
#else
  return {__builtin_sqrt(x[0]), __builtin_sqrt(x[1]), __builtin_sqrt(x[2]), __builtin_sqrt(x[3])};
#endif
}

/// Four doubles from any address.
inline Lanes loadLanes(const double* from) {
  Lanes v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

/// Four doubles to any address.
inline void storeLanes(const Lanes& v, double* to) { std::memcpy(to, &v, sizeof v); }

/// The largest lane.
inline double largest(const Lanes& x) {
  const double a = x[0] > x[1] ? x[0] : x[1], b = x[2] > x[3] ? x[2] : x[3];
  return a > b ? a : b;
}
/// Of the lanes, in pairs: the order is part of the result's bits.
inline double sum(const Lanes& x) { return (x[0] + x[1]) + (x[2] + x[3]); }
/// The sums of four: the same bits, at the cost of one and a half.
inline Lanes sums(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d) {
  Lanes x, y, z, w;
  transpose(a, b, c, d, x, y, z, w);
  return (x + y) + (z + w);
}

}  // namespace haptic
