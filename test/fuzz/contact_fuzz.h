/// One execution of the contacts' fuzz target: any bytes, taken for a pair of shapes and their pose. The
/// contact is defined, the fast path agrees with cutting, and the bodies' order does not matter.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic::fuzz {

/// Numbers from the fuzzer's bytes, drawn to the values where geometry degenerates.
class ByteSource {
 public:
  ByteSource(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  int byte() { return used_ < size_ ? data_[used_++] : 0; }
  /// In [-1, 1]: a round number, a round number and a tiny rest, or anything.
  double number() {
    const int kind = byte() % 4;
    const double round = (byte() % 9 - 4) / 4.0;
    if (kind == 0) return round;
    if (kind < 3) return round + (byte() - 127.5) / 128 * std::pow(10.0, -(byte() % 17));
    return (256 * byte() + byte()) / 32767.5 - 1;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_, used_ = 0;
};

inline const std::vector<ConvexPolyhedron>& shapes() {
  static const std::vector<ConvexPolyhedron> all = {
      makeBox(Vector3(0.1, 0.1, 0.1)),
      makeBox(Vector3(0.2, 0.2, 0.1)),
      makeBox(Vector3(0.1, 0.1, 5e-4)),
      makeBox(Vector3(1e-3, 1e-3, 0.1)),
      makeSphere(0.05, 1),
      makeCylinder(0.05, 0.1, 12),
      ConvexPolyhedron({{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}},
                       {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}})};
  return all;
}

inline double volumeOf(const ContactVolume& v) {
  return v.status == ContactVolume::Status::kOverlap ? v.volume : 0;
}

/// What is wrong with a result that must hold for any pair, or null.
inline const char* undefinedIn(const ContactVolume& v, double smaller_body) {
  if (v.flags & ContactVolume::kCapacityExceeded) return "capacity exceeded";
  if (v.status == ContactVolume::Status::kSeparated) return nullptr;
  if (!v.X_AP.p.allFinite() || !v.X_AP.R.allFinite() || !v.A2.allFinite() || !v.V2.allFinite())
    return "not finite";
  if (!(std::abs(v.normal().norm() - 1) < 1e-9)) return "normal of no unit length";
  // Volumes of these shapes are sums of coordinates below 0.3 m over 0.16 m²: rounded to 1e-17.
  if (!(v.volume >= 0 && v.volume <= smaller_body * (1 + 1e-9) + 1e-17)) return "volume out of range";
  return nullptr;
}

/// Null, or what was violated.
inline const char* contactViolation(const std::uint8_t* data, std::size_t size) {
  ByteSource source(data, size);
  const ConvexPolyhedron& a = shapes()[source.byte() % shapes().size()];
  const ConvexPolyhedron& b = shapes()[source.byte() % shapes().size()];
  Eigen::Vector4d q;
  for (int i = 0; i < 4; ++i) q[i] = source.number();
  if (!(q.norm() > 1e-3)) q = Eigen::Vector4d(1, 0, 0, 0);
  q.normalize();
  Vector3 p;
  for (int i = 0; i < 3; ++i) p[i] = 0.1 * source.number();
  const Pose X_AB(Quaternion(q[0], q[1], q[2], q[3]), p);
  thread_local ContactWorkspace workspace = [] {
    ContactWorkspace w;
    for (const auto& x : shapes())
      for (const auto& y : shapes()) w.reserve(x, y);
    return w;
  }();
  ContactVolume fast, cut, swapped;
  PairCache first, second, third;
  contactVolume(a, b, X_AB, first, workspace, fast);
  contactVolumeByCutting(a, b, X_AB, second, workspace, cut);
  contactVolume(b, a, X_AB.inverse(), third, workspace, swapped);
  for (const ContactVolume* v : {&fast, &cut, &swapped})
    if (const char* what = undefinedIn(*v, std::min(a.volume(), b.volume()))) return what;
  // Roundings of 0.3 m coordinates over the largest surface here.
  const double allowed = 6e-15 * 0.16;
  if (!(std::abs(volumeOf(fast) - volumeOf(cut)) <= allowed)) return "clipping and cutting differ";
  if (!(std::abs(volumeOf(fast) - volumeOf(swapped)) <= allowed)) return "the order of the bodies matters";
  return nullptr;
}

}  // namespace haptic::fuzz
