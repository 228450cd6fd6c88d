// Two rods against an oracle, and how the wrench goes on through parallel axes and over ends.
#include <quadmath.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "figure.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "haptic_core/geometry/volume/rod_integral.h"
#include "shapes_figures.h"
#include "shapes_pairs.h"

namespace haptic::oracle {
template <class T>
T root(T);
template <class T>
T sine(T);
template <class T>
T cosine(T);
template <class T>
T arcCosine(T);
template <class T>
T arcTangent(T, T);
template <>
inline __float128 root(__float128 x) {
  return sqrtq(x);
}
template <>
inline __float128 sine(__float128 x) {
  return sinq(x);
}
template <>
inline __float128 cosine(__float128 x) {
  return cosq(x);
}
template <>
inline __float128 arcCosine(__float128 x) {
  return acosq(x);
}
template <>
inline __float128 arcTangent(__float128 y, __float128 x) {
  return atan2q(y, x);
}
}  // namespace haptic::oracle

#include "rod_oracle.h"

namespace haptic::bench {
namespace {

using Status = ContactVolume::Status;
constexpr int kDefinedPairs = 100000;  ///< of cylinders, of capsules
constexpr int kMixedPairs = 10000;     ///< of one of each, which the definition does not name
/// Share of the bound that the first look at a pair may be off by, and relative error of moments that it never exceeds. The worst pairs
/// are looked at again, to kFinest.
constexpr double kFirstLook = 1e-2, kCoarsest = 1e-4, kFinest = 1e-15;

struct Found {
  ContactVolume volume;
  ContactWorkspace workspace;

  Found(const Rod& A, const Rod& B, const Pose& X_AB) {
    workspace.reserve(A, B);
    PairCache cache;
    contactVolume(A, B, X_AB, cache, workspace, volume);
  }
  bool overlap() const { return volume.status == Status::kOverlap; }
};

/// Errors in units of a relative error at a depth of the lesser radius; NaN: the oracle finds no volume.
struct Errors {
  double volume = std::nan(""), area = 0, torque = 0, first = 0, second = 0, seen = 0;
  bool certain = false;
  double worst() const { return std::max({volume, area, torque, first, second, seen}); }
};

template <class T>
oracle::Vec<T> exact(const Vector3& v) {
  return {T(v.x()), T(v.y()), T(v.z())};
}
template <class T>
Vector3 rounded(const oracle::Vec<T>& v) {
  return {double(v.x), double(v.y), double(v.z)};
}

/// `room`: error that the oracle itself may make, in these units.
template <class T>
Errors errorsOf(const RodPose& pair, const Rod& rod_A, const Rod& rod_B, const Found& found, double room) {
  using Oracle = oracle::RodOracle<T>;
  const typename Oracle::Rod A{T(pair.radius[0]), T(pair.length[0]) / 2, pair.round[0]},
      B{T(pair.radius[1]), T(pair.length[1]) / 2, pair.round[1]};
  auto axis = exact<T>(pair.X_AB.R.col(2));
  axis = axis.times(1 / oracle::root(axis.dot(axis)));
  const ContactVolume& v = found.volume;
  const Vector3 hint = v.status == Status::kSeparated ? Vector3(0.5 * pair.X_AB.p) : v.X_AP.p;
  const double share = std::min(1.0, (found.overlap() ? v.depth : pair.depth) / pair.lesser());
  RodPair planes;
  RodBreaks breaks;
  std::optional<RodIntegral> integral;
  if (planes.place(rod_A, rod_B, pair.X_AB)) integral.emplace(planes, breaks);
  std::vector<T> heights;  // the middles of our pieces: where the oracle looks, not what it finds
  for (int i = 0; i + 1 < breaks.count; ++i) heights.push_back(T(0.5 * (breaks.over[i] + breaks.over[i + 1])));
  const Oracle oracle(A, B, axis, exact<T>(pair.X_AB.p), exact<T>(hint), T(std::min(kCoarsest, room / share)), heights);
  Errors out;
  const double V = double(oracle.volume());
  if (!(V > 0)) return out;
  out.certain = !oracle.gaveUp();
  if (!found.overlap()) {
    out.volume = share;
    return out;
  }
  const Vector3 S = rounded(oracle.areaVector()), c = rounded(oracle.centroid()), n = v.normal();
  // ∫ r × n dA about A's origin: the volume's rate as B turns about it.
  const Vector3 torque = planes.R_AE * integral->torque();
  const double surface = std::max(S.norm(), std::pow(V, 2.0 / 3));
  out.volume = share * std::abs(double(oracle.volume() - T(v.volume))) / V;
  out.area = share * (v.area_vector_A - S).norm() / surface;
  out.torque = share * (torque - rounded(oracle.torque())).norm() / (surface * (c.norm() + std::cbrt(V)));
  Matrix3 exact2, seen2;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const auto a = exact<T>(v.X_AP.R.col(i)), b = exact<T>(v.X_AP.R.col(j));
      exact2(i, j) = double(oracle.second(a, b));
      seen2(i, j) = double(oracle.surfaceSecond(exact<T>(n), a, b));
    }
  }
  out.first = share * (v.X_AP.p - c).norm() / std::sqrt(exact2.trace() / V);
  out.second = share * (v.V2 - exact2.topLeftCorner<2, 2>()).norm() / exact2.norm();
  out.seen = share * (v.A2 - seen2.topLeftCorner<2, 2>()).norm() /
             (seen2.topLeftCorner<2, 2>().norm() + surface * exact2.trace() / V);
  return out;
}

/// Figures of fewer pairs than the definition asks for have names of their own.
std::string suffixOf(int pairs) { return pairs == 0 || pairs == kDefinedPairs ? "" : "_of_" + std::to_string(pairs); }

/// Equal radii, aligned end on end: the gradient across has no value there.
bool alignedEnds(const RodPose& pair) {
  return !pair.round[0] && !pair.round[1] &&
         std::abs(pair.radius[0] - pair.radius[1]) < 1e-3 * pair.lesser() &&
         pair.X_AB.p.head<2>().norm() < 1e-3 * pair.lesser();
}

/// 64 bits rule out all pairs but the worst, to a share of the bound; 113 bits judge these: the largest error is among them as long as
/// the last judged has less.
void measureKind(RodKinds kinds, unsigned seed, int count, const std::string& name, double bound, int& false_empty) {
  struct Row {
    double error;
    RodPose pair;
    int index;  ///< in the sequence of poses
  };
  std::vector<Row> rows;
  RodPoses poses(kinds, seed);
  int measured = 0, aligned = 0, uncertain = 0;
  for (int i = 0; i < count; ++i) {
    const RodPose pair = poses.next();
    const Rod A = pair.rod(0), B = pair.rod(1);
    const Found found(A, B, pair.X_AB);
    const Errors e = errorsOf<long double>(pair, A, B, found, kFirstLook * bound);
    if (std::isnan(e.volume)) continue;
    ++measured;
    if (!found.overlap()) ++false_empty;
    uncertain += !e.certain;
    if (alignedEnds(pair))
      ++aligned;
    else
      rows.push_back({e.worst(), pair, i});
  }
  const int judged = std::min<int>(rows.size(), 100);
  std::partial_sort(rows.begin(), rows.begin() + judged, rows.end(),
                    [](const Row& a, const Row& b) { return !(a.error <= b.error); });
  Errors worst;
  double largest = 0;
  int where = -1;
  for (int i = 0; i < judged; ++i) {
    if (i > 0 && rows[i].error < largest) break;
    const RodPose& pair = rows[i].pair;
    const Rod A = pair.rod(0), B = pair.rod(1);
    const Errors e = errorsOf<__float128>(pair, A, B, Found(A, B, pair.X_AB), kFinest);
    if (e.worst() > largest) largest = e.worst(), worst = e, where = rows[i].index;
  }
  figure("rod_rod." + name + "_err_c" + suffixOf(count), largest, "");
  figure("rod_rod." + name + "_pairs", measured, "");
  figure("rod_rod." + name + "_aligned_pairs", aligned, "");      // left out of the error
  figure("rod_rod." + name + "_uncertain_pairs", uncertain, "");  // the oracle gave up an interval; in the error
  std::printf("worst: pair %d: volume %.1e gradient %.1e torque %.1e centroid %.1e second %.1e of the area %.1e\n", where,
              worst.volume, worst.area, worst.torque, worst.first, worst.second, worst.seen);
}

}  // namespace

/// From a pose at which an end, or the axes' being parallel, is passed within 1e-9 radii: the second difference of k V n and of its
/// moment about A's origin, over the force; k = 1. All points of the contact move by 1e-9 radii or less, so that B, which turns about
/// its centre, turns by that over its reach. A smooth wrench leaves p² (1e-9 radii / depth)² where V ∝ depthᵖ: 7e-9 where round ends
/// meet by 3e-5 radii only. The third difference leaves the cube of that, and of a jump or a kink all or twice as much.
void measureRodJumps(int moves) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> u(-1, 1);
  double jump = 0, flat_jump = 0, beyond_curvature = 0;
  int moved = 0;
  for (int i = 0; i < moves; ++i) {
    RodPose pair;
    for (int k = 0; k < 2; ++k) {
      pair.radius[k] = 0.03 * (1 + 0.5 * u(random));
      pair.length[k] = pair.radius[k] * (3 + 2 * u(random));
      pair.round[k] = (i >> k) & 1;
    }
    const double r = pair.lesser(), step = 1e-9 * r;
    pair.depth = r * std::pow(10, -2 + 2 * u(random));
    const auto noise = [&] { return Vector3(u(random), u(random), u(random)); };
    // Side on side, nearly parallel or at an angle, B's end over A's end or over its side: all within some
    // steps.
    const double angle = i % 3 == 0 ? 0 : 1.5 * u(random);
    const double lever = pair.length[0] + pair.radius[0], least_turn = step / (0.5 * pair.length[1] + pair.radius[1]);
    const Vector3 turning = 3 * least_turn * noise();
    const Matrix3 R =
        (Eigen::AngleAxisd(turning.norm(), turning.normalized()) * Eigen::AngleAxisd(angle, Vector3::UnitX()))
            .toRotationMatrix();
    const double along = i % 2 ? 0.5 * (pair.length[0] - (i % 4 == 1 ? 1 : -1) * pair.length[1])
                               : 0.4 * pair.length[0] * u(random);
    const Vector3 at = Vector3(pair.radius[0] + pair.radius[1] - pair.depth, 0, along) + 3 * step * noise();
    const Vector3 move = step * noise(), turn = least_turn * noise();
    const Rod A = pair.rod(0), B = pair.rod(1);
    Vector3 force[4], torque[4];
    bool good = true;
    double share = 1;
    for (int k = -1; k <= 2; ++k) {
      pair.X_AB = {Eigen::AngleAxisd(k * turn.norm(), turn.normalized()).toRotationMatrix() * R,
                   at + k * move};
      const Found found(A, B, pair.X_AB);
      good = good && found.overlap();
      if (!good) break;
      const ContactVolume& v = found.volume;
      share = std::min(share, v.area_vector_A.norm() / std::max(std::abs(v.A0), std::pow(v.volume, 2.0 / 3)));
      force[k + 1] = v.volume * v.normal();
      torque[k + 1] = v.X_AP.p.cross(force[k + 1]);
    }
    if (!good || share < 1e-3) continue;
    ++moved;
    const double size = force[1].norm();
    const auto second = [](const Vector3* f) { return (f[0] - 2 * f[1] + f[2]).norm(); };
    const auto third = [](const Vector3* f) { return (f[3] - 3 * f[2] + 3 * f[1] - f[0]).norm(); };
    const double change = std::max(second(force) / size, second(torque) / (size * lever));
    beyond_curvature = std::max({beyond_curvature, third(force) / size, third(torque) / (size * lever)});
    jump = std::max(jump, change);
    if (!pair.round[0] && !pair.round[1]) flat_jump = std::max(flat_jump, change);
  }
  figure("rod_rod.wrench_jump", jump, "");
  figure("rod_rod.wrench_jump_beyond_curvature", beyond_curvature, "");
  figure("rod_rod.wrench_jump_cylinders", flat_jump, "");
  figure("rod_rod.wrench_jump_moves", moved, "");
}

void measureRodAccuracy(const char* filter, int pairs) {
  int false_empty = 0;
  const auto measure = [&](RodKinds kinds, unsigned seed, const char* name, double bound, int count) {
    if (!filter || std::string("accuracy_") + name == filter) measureKind(kinds, seed, count, name, bound, false_empty);
  };
  measure(RodKinds::kCylinders, 1, "cylinder", 1e-10, pairs > 0 ? pairs : kDefinedPairs);
  measure(RodKinds::kCapsules, 2, "capsule", 1e-8, pairs > 0 ? pairs : kDefinedPairs);
  measure(RodKinds::kBoth, 3, "mixed", 1e-8, pairs > 0 ? pairs : kMixedPairs);
  figure(std::string("rod_rod.false_empty") + (filter ? filter + std::strlen("accuracy") : "") + suffixOf(pairs), false_empty, "");
}

}  // namespace haptic::bench
