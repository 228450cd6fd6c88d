#include "haptic_core/geometry/pairs/round_contact.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/volume/contact_moments.h"

namespace haptic {
namespace {

using Status = ContactVolume::Status;

/// The patch's axes in Q, and its origin along them from the point that moments are about.
struct SeenAcross {
  Vector3 x, y;
  double at_x, at_y;

  Vector2 first(double zeroth, const Vector3& f) const { return {f.dot(x) - zeroth * at_x, f.dot(y) - zeroth * at_y}; }
  Matrix2 second(double zeroth, const Vector3& f, const Matrix3& s) const {
    const Vector3 sx = x.x() * s.col(0) + x.y() * s.col(1) + x.z() * s.col(2), sy = y.x() * s.col(0) + y.y() * s.col(1) + y.z() * s.col(2);
    const double fx = f.dot(x), fy = f.dot(y), moved = fx - zeroth * at_x;
    const double xy = x.dot(sy) - at_x * fy - at_y * moved;
    Matrix2 out;
    out << x.dot(sx) - at_x * (fx + moved), xy, xy, y.dot(sy) - at_y * (2 * fy - zeroth * at_y);
    return out;
  }
};

Vector3 turnedBack(const Matrix3& R, const Vector3& v) { return {R.col(0).dot(v), R.col(1).dot(v), R.col(2).dot(v)}; }

}  // namespace

RoundContact::RoundContact(const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace, ContactVolume& out)
    : request_(request), given_(request.normal), cache_(cache), w_(workspace), v_(workspace.round_), out_(out) {
  if (request.rule == NormalRule::kHistory && !(given_.squaredNorm() > 0)) given_ = cache.normal;
  workspace.clear();
  v_.cut.clear();
  v_.parts.clear();
  v_.rod = v_.second.rod = nullptr;
  v_.other_radius = 0;
  v_.axial = v_.oval = false;
  v_.sampled = NAN;
  out.status = Status::kSeparated;
  out.flags = 0;
  out.covered_a = out.covered_b = {};
}

Vector3 RoundContact::lastOr(const Vector3& otherwise) const {
  return cache_.normal.squaredNorm() > 0 ? cache_.normal : otherwise;
}

void RoundContact::setSeparated(const Vector3& direction_A, double gap) {
  out_.status = Status::kSeparated;
  out_.flags = 0;
  out_.depth = std::min(0.0, -gap);
  cache_.direction = direction_A;
  if (request_.rule == NormalRule::kHistory) cache_.normal = direction_A;
}

void RoundContact::setTouching(const Vector3& normal_A, const Vector3& point_A) {
  const unsigned flags = out_.flags;
  out_ = ContactVolume{};
  out_.flags = flags;
  out_.status = Status::kTouching;
  out_.X_AP = {patchAxes(normal_A), point_A};
  cache_.normal = cache_.direction = normal_A;
}

void RoundContact::setAxial(const Vector3& normal_A, const Vector3& axis_A, const Vector3& centroid_A, double volume,
                            double across, double r2, double depth) {
  const double area = M_PI * r2, seen = area * normal_A.dot(axis_A);
  out_.status = Status::kOverlap;
  out_.X_AP = {patchAxes(normal_A), centroid_A};
  out_.area_vector_A = area * axis_A;
  out_.volume = volume;
  out_.V2 = across * Matrix2::Identity();
  out_.A0 = seen;
  out_.A1.setZero();
  out_.A2 = 0.25 * seen * r2 * Matrix2::Identity();
  out_.depth = depth;
  cache_.normal = cache_.direction = normal_A;
}

void RoundContact::setCube(const Vector3& normal_A, const Vector3& middle_A, double depth) {
  out_.flags |= ContactVolume::kCapacityExceeded;
  const double volume = depth * depth * depth, r2 = depth * depth / M_PI;
  setAxial(normal_A, normal_A, middle_A, volume, volume * r2 / 4, r2, depth);
}

bool RoundContact::setMoments(const SolidMoments& sums, const Vector3& o, const Vector3& covered_Q,
                              const Vector3& way_out_A) {
  if (!(sums.volume > 0)) {
    setTouching(way_out_A, v_.X_AQ * o);
    return false;
  }
  Vector3 area_Q = Vector3::Zero();
  double scale = 0;
  for (const RoundVolume::FacePart& part : v_.parts) {
    area_Q += part.moments.area * part.normal;
    scale += part.moments.area;
  }
  scale = std::max(scale, elementary::cbrt(sums.volume * sums.volume));  // parts of a curved surface may cancel
  const Vector3 seen_Q = area_Q - covered_Q;
  out_.area_vector_A = v_.sign * (v_.X_AQ.R * area_Q);
  // Where nothing of the faces is surface, the whole of them stands in.
  const bool seen = seen_Q.norm() > kVanishing * scale;
  CoveredArea& covered = v_.sign > 0 ? out_.covered_a : out_.covered_b;
  covered = {v_.X_AQ.R * covered_Q, covered_Q.norm(), (out_.flags & ContactVolume::kOnSeam) != 0};
  const Vector3 n = normalOf(seen ? Vector3(v_.sign * (v_.X_AQ.R * seen_Q)) : out_.area_vector_A, scale, way_out_A);
  const Vector3 centroid = sums.first / sums.volume;  // from o
  const Matrix3 R_AP = patchAxes(n);
  const Matrix3& R_AQ = v_.X_AQ.R;
  out_.status = Status::kOverlap;
  out_.X_AP = {R_AP, v_.X_AQ * (o + centroid)};
  out_.volume = sums.volume;
  const Vector3 x = turnedBack(R_AQ, R_AP.col(0)), y = turnedBack(R_AQ, R_AP.col(1)), up = turnedBack(R_AQ, n);
  const SeenAcross seen_across{x, y, centroid.dot(x), centroid.dot(y)};
  out_.V2 = seen_across.second(sums.volume, sums.first, sums.second);
  // A0, A1 and A2: the faces' parts seen along n.
  PlaneMoments faces;
  for (const RoundVolume::FacePart& part : v_.parts) {
    const double rise = v_.sign * part.normal.dot(up);
    faces.area += rise * part.moments.area;
    faces.first += rise * part.moments.first;
    faces.second += rise * part.moments.second;
  }
  out_.A0 = faces.area;
  out_.A1 = seen_across.first(faces.area, faces.first);
  out_.A2 = seen_across.second(faces.area, faces.first, faces.second);
  cache_.normal = cache_.direction = n;
  return true;
}

Vector3 RoundContact::supportNormal() const {
  const Vector3 up = v_.X_AQ.R.transpose() * out_.normal();
  Vector3 support = Vector3::Zero();
  double largest = 0;
  for (const RoundVolume::FacePart& part : v_.parts) {
    if (part.normal.cross(up).squaredNorm() < kFlush * kFlush) return Vector3::Zero();
    double area = 0;  // a capsule has up to three parts on one face
    for (const RoundVolume::FacePart& other : v_.parts) area += other.index == part.index ? other.moments.area : 0;
    const double share = std::abs(area * part.normal.dot(up));
    if (share > largest) largest = share, support = part.normal;
  }
  if (v_.rod && !v_.rod->isCapsule()) {
    // A cylinder's side has no area along its axis.
    const double end = (v_.X_AQ.R.transpose() * out_.area_vector_A).z() * up.z();
    const bool flush = up.head<2>().squaredNorm() < kFlush * kFlush;
    if (std::abs(end) > largest) support = Vector3(0, 0, flush ? 0 : 1);
  }
  return support;
}

Vector3 RoundContact::normalOf(const Vector3& surface_A, double scale, const Vector3& otherwise) {
  if (given_.squaredNorm() > 0) return given_;
  const double size = surface_A.norm();
  if (size > kVanishing * scale) return surface_A / size;
  out_.flags |= ContactVolume::kNormalFromHistory;
  return lastOr(otherwise);
}

void RoundContact::keepAbove(double side, double height) {
  LoadedVector<Vector3>& kept = w_.cut_outline_;
  kept.clear();
  for (int i = 0; i < w_.outline_.size(); ++i) {
    const Vector3 &from = w_.outline_[i], &to = w_.outline_[i + 1 < w_.outline_.size() ? i + 1 : 0];
    const double h_from = side * (from.z() - height), h_to = side * (to.z() - height);
    if (h_from >= 0) kept.push_back(from);
    if ((h_from >= 0) != (h_to >= 0)) kept.push_back(from + h_from / (h_from - h_to) * (to - from));
  }
  std::swap(w_.outline_, kept);
}

const LoadedVector<Vector3>& RoundContact::outlineBetween(const std::vector<Vector3>& outline_S, const Pose& X_QS, double low,
                                                          double high) {
  w_.outline_.clear();
  for (const Vector3& x : outline_S) w_.outline_.push_back(X_QS * x);
  keepAbove(1, low);
  keepAbove(-1, high);
  return w_.outline_;
}

void RoundContact::keep() {
  v_.filled = true;
  for (const RoundVolume::FacePart& part : v_.parts) {
    const Vector3 normal = v_.X_AQ.R * part.normal;
    w_.faces_.push_back({normal, part.offset + normal.dot(v_.X_AQ.p), part.index, v_.sign > 0 ? Owner::kA : Owner::kB});
  }
}

}  // namespace haptic
