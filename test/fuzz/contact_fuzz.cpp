// libFuzzer target: any pair of shapes in any pose has a defined contact, the fast path agrees with cutting,
// and neither body's order matters. Built by CMakeLists.txt beside with clang; bounded by -max_total_time.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "haptic_core/geometry/contact_volume.h"
#include "haptic_core/geometry/contact_workspace.h"
#include "haptic_core/geometry/shapes.h"

namespace {

using namespace haptic;

/// Numbers from the fuzzer's bytes, drawn to the values where geometry degenerates.
class Source {
 public:
  Source(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
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

const std::vector<ConvexPolyhedron>& shapes() {
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

void require(bool held, const char* what) {
  if (held) return;
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

double volumeOf(const ContactVolume& v) {
  return v.status == ContactVolume::Status::kOverlap ? v.volume : 0;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Source source(data, size);
  const ConvexPolyhedron& a = shapes()[source.byte() % shapes().size()];
  const ConvexPolyhedron& b = shapes()[source.byte() % shapes().size()];
  Eigen::Vector4d q;
  for (int i = 0; i < 4; ++i) q[i] = source.number();
  if (!(q.norm() > 1e-3)) q = Eigen::Vector4d(1, 0, 0, 0);
  q.normalize();
  const Pose X_AB(Quaternion(q[0], q[1], q[2], q[3]),
                  0.1 * Vector3(source.number(), source.number(), source.number()));
  static ContactWorkspace workspace = [] {
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
  for (const ContactVolume* v : {&fast, &cut, &swapped}) {
    require(!(v->flags & ContactVolume::kCapacityExceeded), "capacity exceeded");
    if (v->status == ContactVolume::Status::kSeparated) continue;
    require(v->X_AP.p.allFinite() && v->X_AP.R.allFinite() && v->A2.allFinite() && v->V2.allFinite(),
            "not finite");
    require(std::abs(v->normal().norm() - 1) < 1e-9, "normal of no unit length");
    require(v->volume >= 0 && v->volume <= std::min(a.volume(), b.volume()) * (1 + 1e-9) + 1e-17,
            "volume out of range");
  }
  // Roundings of 0.3 m coordinates over the largest surface here.
  const double allowed = 6e-15 * 0.16;
  require(std::abs(volumeOf(fast) - volumeOf(cut)) <= allowed, "clipping and cutting differ");
  require(std::abs(volumeOf(fast) - volumeOf(swapped)) <= allowed, "the order of the bodies matters");
  return 0;
}
