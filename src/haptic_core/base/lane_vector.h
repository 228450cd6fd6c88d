/// Vectors of three, quaternions and 3 × 3 matrices in lanes: x, y, z and one lane that is not read. What turns one body a
/// million times a second takes half the instructions of the same on three numbers each, and has the same bits in every build.
#pragma once
#include "haptic_core/base/lanes.h"
#include "haptic_core/base/spatial.h"

namespace haptic {

#if defined(__AVX__)

/// Lane `i` in all lanes.
template <int i>
Lanes spread(const Lanes& v) { return __builtin_shufflevector(v, v, i, i, i, i); }
inline Lanes yzx(const Lanes& v) { return __builtin_shufflevector(v, v, 1, 2, 0, 3); }  ///< y, z, x
inline Lanes zxy(const Lanes& v) { return __builtin_shufflevector(v, v, 2, 0, 1, 3); }  ///< z, x, y
/// Lane 0 of a, 1 of b, 2 of c.
inline Lanes pick(const Lanes& a, const Lanes& b, const Lanes& c) {
  return __builtin_shufflevector(__builtin_shufflevector(a, b, 0, 5, 2, 3), c, 0, 1, 6, 7);
}

#else

template <int i>
Lanes spread(const Lanes& v) {
  const LanePair& from = i < 2 ? v.lower : v.upper;
  const LanePair both = __builtin_shufflevector(from, from, i % 2, i % 2);
  return {both, both};
}
inline Lanes yzx(const Lanes& v) {
  return {__builtin_shufflevector(v.lower, v.upper, 1, 2), __builtin_shufflevector(v.lower, v.upper, 0, 3)};
}
inline Lanes zxy(const Lanes& v) {
  return {__builtin_shufflevector(v.upper, v.lower, 0, 2), __builtin_shufflevector(v.lower, v.upper, 1, 3)};
}
inline Lanes pick(const Lanes& a, const Lanes& b, const Lanes& c) {
  return {__builtin_shufflevector(a.lower, b.lower, 0, 3), c.upper};
}

#endif

/// Its numbers.
inline Lanes laneVector(double x, double y, double z) { return Lanes{x, y, z, 0}; }
/// a × b.
inline Lanes cross(const Lanes& a, const Lanes& b) { return yzx(a) * zxy(b) - zxy(a) * yzx(b); }
/// a·b, x and y first.
inline double dot(const Lanes& a, const Lanes& b) {
  const Lanes p = a * b;
  return (p[0] + p[1]) + p[2];
}
/// Three doubles to any address.
inline void storeVector(const Lanes& v, double* to) {
  for (int k = 0; k < 3; ++k) to[k] = v[k];
}

/// A matrix by its columns.
struct LaneMatrix {
  LaneMatrix(const Lanes& x, const Lanes& y, const Lanes& z) : column{x, y, z} {}  ///< of its columns
  /// The same numbers.
  explicit LaneMatrix(const Matrix3& m)
      : column{loadLanes(m.data()), loadLanes(m.data() + 3), laneVector(m(0, 2), m(1, 2), m(2, 2))} {}

  /// M v.
  Lanes operator*(const Lanes& v) const {
    return (column[0] * spread<0>(v) + column[1] * spread<1>(v)) + column[2] * spread<2>(v);
  }

  Lanes column[3];  ///< x, y, z
};

/// s M; all lanes of s are alike.
inline LaneMatrix operator*(const Lanes& s, const LaneMatrix& m) { return {s * m.column[0], s * m.column[1], s * m.column[2]}; }

/// A B.
inline LaneMatrix operator*(const LaneMatrix& a, const LaneMatrix& b) { return {a * b.column[0], a * b.column[1], a * b.column[2]}; }
/// Sum of two.
inline LaneMatrix operator+(const LaneMatrix& a, const LaneMatrix& b) {
  return {a.column[0] + b.column[0], a.column[1] + b.column[1], a.column[2] + b.column[2]};
}
/// Difference of two.
inline LaneMatrix operator-(const LaneMatrix& a, const LaneMatrix& b) {
  return {a.column[0] - b.column[0], a.column[1] - b.column[1], a.column[2] - b.column[2]};
}
/// Mᵀ.
inline LaneMatrix transposed(const LaneMatrix& m) {
  LaneMatrix t = m;
  transpose(m.column[0], m.column[1], m.column[2], lanes(0), t.column[0], t.column[1], t.column[2]);
  return t;
}
/// [r]× M.
inline LaneMatrix cross(const Lanes& r, const LaneMatrix& m) {
  return {cross(r, m.column[0]), cross(r, m.column[1]), cross(r, m.column[2])};
}
/// M [r]×.
inline LaneMatrix cross(const LaneMatrix& m, const Lanes& r) {
  const Lanes x = spread<0>(r), y = spread<1>(r), z = spread<2>(r);
  return {z * m.column[1] - y * m.column[2], x * m.column[2] - z * m.column[0], y * m.column[0] - x * m.column[1]};
}

/// A rotation and its inverse.
struct LaneRotation {
  LaneMatrix there, back;  ///< R, Rᵀ
};

/// w + x i + y j + z k, u = (x, y, z).
struct LaneQuaternion {
  double w;  ///< its real part
  Lanes u;   ///< the others
};

/// Hamilton's product.
inline LaneQuaternion operator*(const LaneQuaternion& a, const LaneQuaternion& b) {
  return {a.w * b.w - dot(a.u, b.u), (lanes(a.w) * b.u + lanes(b.w) * a.u) + cross(a.u, b.u)};
}

/// Of a unit quaternion. R = 1 + 2 w [u]× + 2 [u]×²: the diagonal is 1 − 2 (y² + z²) and so on, what stands beside it ±2 w u_i + 2 u_j u_k.
inline LaneRotation rotation(const LaneQuaternion& r) {
  const Lanes twice = r.u + r.u, squares = twice * r.u;
  const Lanes products = yzx(twice) * zxy(r.u), turns = lanes(r.w) * twice;
  const Lanes d = lanes(1) - (yzx(squares) + zxy(squares)), p = products + turns, m = products - turns;
  const Lanes p1 = yzx(p), p2 = zxy(p), m1 = yzx(m), m2 = zxy(m);
  return {{pick(d, p1, m2), pick(m2, d, p1), pick(p1, m2, d)}, {pick(d, m1, p2), pick(p2, d, m1), pick(m1, p2, d)}};
}

}  // namespace haptic
