#include "haptic_core/geometry/pairs/ball_rod_contact.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/pairs/round_contact.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/volume/circular_segment.h"
#include "haptic_core/geometry/volume/gauss_legendre.h"

namespace haptic {
namespace {

/// ∫ 1, x, x² and y² dA, x from a point on the axis of symmetry.
struct LensMoments {
  double area = 0, x = 0, xx = 0, yy = 0;

  void addDisc(double radius, double middle) {
    const double a = M_PI * radius * radius, r2 = 0.25 * radius * radius;
    area += a, x += a * middle, xx += a * (middle * middle + r2), yy += a * r2;
  }
  /// The part of a disc within `depth` of its point at `apex`; `side` leads from there to its middle.
  void addSegment(double radius, double depth, double apex, double side) {
    const double s = depth / radius, scale = s * std::sqrt(s), r2 = radius * radius;
    const SegmentIntegrals j(s, s < SegmentIntegrals::kSeries ? 0 : 2 * elementary::asin(std::sqrt(std::min(1.0, 0.5 * s))));
    const double m0 = 2 * r2 * scale * j.j0, m1 = 2 * r2 * radius * scale * j.j1, m2 = 2 * r2 * r2 * scale * j.j2;
    area += m0, x += apex * m0 + side * m1, xx += apex * apex * m0 + 2 * side * apex * m1 + m2;
    yy += 2.0 / 3 * r2 * r2 * scale * (2 * j.j1 - j.j2);
  }
};

/// ln of the midpoint rule's error, with two digits to spare for the moments' powers of u.
constexpr double kWaistDigits = 39 / 2.0;
/// Pairs of slices beyond which the ranges' rules take over: as many as these have.
constexpr double kMostPairs = 16;

/// A slice at one height: the rod's disc of radius R about the axis, the ball's of radius r at the distance D.
struct Slice {
  LensMoments lens;
  double half_arc = 0;  ///< of the rod's outline that lies in the ball [rad]

  Slice(double R, double r, double D, double from) {
    const double depth = R + r - D;
    if (!(depth > 0) || !(R > 0) || !(r > 0)) return;
    if (D <= R - r) {
      lens.addDisc(r, D - from);
      return;
    }
    if (D <= r - R) {
      half_arc = M_PI;
      lens.addDisc(R, -from);
      return;
    }
    const double mine = std::clamp(depth * (r - R + D) / (2 * D), 0.0, 2 * R),
                 other = std::clamp(depth * (R - r + D) / (2 * D), 0.0, 2 * r);
    half_arc = 2 * elementary::asin(std::sqrt(std::min(1.0, mine / (2 * R))));
    lens.addSegment(R, mine, R - from, -1);
    lens.addSegment(r, other, D - r - from, 1);
  }
};

}  // namespace

class BallRodContact : public RoundContact {
 public:
  using RoundContact::RoundContact;
  void find(double ball_radius, const Rod& rod, bool rod_is_a, const Pose& X_AB);

 private:
  bool separate(const Rod& rod);
  bool integrateWaist(double half);
  void integrateRange(double low, double high, double end);
  void integrateSmooth(double from, double to, double end);
  void addSlice(double R, double rise, double u, double z, double z2, double weight);
  void addSurface(double R, double rise, const Slice& slice, double z, double z2, double weight);
  void addEnd(double height, double side);

  double R_ = 0, r_ = 0, D_ = 0, c_ = 0;   ///< of rod and ball, and the ball's centre across and along the axis [m]
  Vector3 o_ = Vector3::Zero();            ///< in Q, about which all is summed
  SolidMoments sums_;
  PlaneMoments surface_[3];                ///< of the rod's surface in the ball, weighed with its normal's components
};

/// True: apart. Else `o_` is about where they meet, and the cache's direction leads from A to B.
bool BallRodContact::separate(const Rod& rod) {
  const double half = rod.halfLength(), near = std::clamp(c_, -half, half);
  // From the nearest point of the core, in the plane of axis and centre.
  Vector2 way(rod.isCapsule() ? D_ : std::max(0.0, D_ - R_), c_ - near);
  double distance = way.norm(), gap = distance - r_ - rod.rounding();
  if (!(distance > 0)) {
    const double out = R_ - D_, along = half - std::abs(c_);
    const bool sideways = rod.isCapsule() || out < along;
    way = sideways ? Vector2(1, 0) : Vector2(0, c_ < 0 ? -1 : 1);
    gap = -std::max(0.0, rod.isCapsule() ? R_ : std::min(out, along)) - r_;
    distance = 1;
  }
  way /= distance;
  cache_.direction = v_.sign * (v_.X_AQ.R * Vector3(way.x(), 0, way.y()));
  o_ = Vector3(std::max(0.0, D_ - way.x() * r_), 0, c_ - way.y() * r_);
  if (gap <= 0) return false;
  setSeparated(Vector3(cache_.direction), gap);
  return true;
}

void BallRodContact::find(double ball_radius, const Rod& rod, bool rod_is_a, const Pose& X_AB) {
  v_.rod = &rod;
  v_.radius = R_ = rod.radius();
  v_.other_radius = r_ = ball_radius;
  v_.sign = rod_is_a ? 1 : -1;
  // Q is the rod's frame, turned about its axis so that the ball's centre has no y.
  const Pose X_AR = rod_is_a ? Pose() : X_AB;
  const Vector3 p_RC = rod_is_a ? X_AB.p : Vector3(-(X_AB.R.transpose() * X_AB.p));
  D_ = p_RC.head<2>().norm();
  c_ = p_RC.z();
  const Vector2 across = D_ > 0 ? Vector2(p_RC.head<2>() / D_) : Vector2(Vector2::UnitX());
  Matrix3 R_RQ = Matrix3::Identity();
  R_RQ.topLeftCorner<2, 2>() << across.x(), -across.y(), across.y(), across.x();
  v_.X_AQ = {X_AR.R * R_RQ, X_AR.p};
  v_.other_Q = Vector3(D_, 0, c_);
  if (separate(rod)) return;
  const Vector3 way_out_A = cache_.direction;
  const double half = rod.halfLength();
  if (integrateWaist(half)) {
    // All of V is there.
  } else if (rod.isCapsule()) {
    integrateRange(-half, half, 0);
    integrateRange(half, half + R_, half);
    integrateRange(-half - R_, -half, -half);
  } else {
    integrateRange(-half, half, 0);
    addEnd(half, 1);
    addEnd(-half, -1);
  }
  for (int i = 0; i < 3; ++i) v_.parts.push_back({Vector3::Unit(i), -1, 0, surface_[i], 0, 0});
  if (!setMoments(sums_, o_, Vector3::Zero(), way_out_A)) return;
  v_.filled = true;
  const Vector3 up = v_.sign * (v_.X_AQ.R.transpose() * out_.normal());
  out_.depth = std::min(2 * r_, up.dot(rod.core(up) - v_.other_Q) + rod.rounding() + r_);
}

/// Where the ball meets the tube alone, from outside: the lenses lie evenly about the ball's centre, at u = H cos φ. They begin
/// and end with the power 3/2, the arcs with 1/2: even functions of φ, for which the midpoint rule's error falls like ρ^(-2N), ρ of
/// the ellipse through the nearest u that is singular: the ball's poles, or where all of the rod would be inside. False: elsewhere.
bool BallRodContact::integrateWaist(double half) {
  const double square = (r_ - D_ + R_) * (r_ + D_ - R_), rest = (D_ + R_ - r_) * (D_ + R_ + r_);
  if (!(D_ > R_) || !(square > 0) || !(rest > 0)) return false;
  const double H = std::sqrt(square);
  if (c_ + H > half || c_ - H < -half) return false;
  const double pole = r_ / H, across = std::sqrt(rest) / H;
  const double ellipse = std::min(pole + std::sqrt(std::max(0.0, pole * pole - 1)), across + std::sqrt(across * across + 1));
  const double pairs = 0.5 * kWaistDigits / elementary::log(ellipse) + 1;
  if (!(pairs <= kMostPairs)) return false;
  const int n = static_cast<int>(pairs) + 1;
  for (int i = 0; i < n; ++i) {
    const auto [sine, cosine] = elementary::sinCos((i + 0.5) * M_PI / (2 * n));
    const double u = H * cosine;
    addSlice(R_, 0, u, 0, u * u, M_PI / n * H * sine);  // with -u
  }
  return true;
}

/// Heights from `low` to `high`: of the tube, or of the half ball about the axis' end at `end`.
void BallRodContact::integrateRange(double low, double high, double end) {
  double turn[6] = {low, high, low, low, low, low};
  const auto about = [&](double middle, double square, int i) {
    if (!(square > 0)) return;
    turn[i] = middle - std::sqrt(square);
    turn[i + 1] = middle + std::sqrt(square);
  };
  if (end == 0) {
    // Where the ball's disc touches the rod's, from outside or from within.
    about(c_, (r_ - D_ + R_) * (r_ + D_ - R_), 2);
    about(c_, (r_ - D_ - R_) * (r_ + D_ + R_), 4);
  } else {
    // The circle in which the two spheres meet.
    const double along = c_ - end, distance2 = D_ * D_ + along * along;
    if (distance2 > 0) {
      const double share = 0.5 * (1 + (R_ - r_) * (R_ + r_) / distance2);
      about(end + share * along, (R_ * R_ - share * share * distance2) * D_ * D_ / distance2, 2);
    }
  }
  low = std::max(low, c_ - r_), high = std::min(high, c_ + r_);
  if (!(low < high)) return;
  for (double& z : turn) z = std::clamp(z, low, high);
  std::sort(turn, turn + 6);
  for (int i = 0; i < 5; ++i) {
    if (!(turn[i] < turn[i + 1])) continue;
    const double middle = 0.5 * (turn[i] + turn[i + 1]);
    integrateSmooth(turn[i], middle, end);
    integrateSmooth(turn[i + 1], middle, end);
  }
}

/// From a turning point at `from`, z = from + (to - from) s²: what goes with the power 3/2 or 1/2 of the way from there is smooth in s.
void BallRodContact::integrateSmooth(double from, double to, double end) {
  integrate(kGauss16, 0, 1, [&](double s, double w) {
    const double z = from + (to - from) * s * s, weight = 2 * w * std::abs(to - from) * s;
    const double t = z - end, u = z - c_;
    const double R = end == 0 ? R_ : std::sqrt(std::max(0.0, (R_ - t) * (R_ + t)));
    addSlice(R, end == 0 ? 0 : t, u, z - o_.z(), (z - o_.z()) * (z - o_.z()), weight);
  });
}

/// The lens of the rod's disc of radius R and the ball's at u over its centre, at z from `o_`, of which `z2` is the mean square.
void BallRodContact::addSlice(double R, double rise, double u, double z, double z2, double weight) {
  const Slice slice(R, std::sqrt(std::max(0.0, (r_ - u) * (r_ + u))), D_, o_.x());
  const LensMoments& lens = slice.lens;
  if (!(lens.area > 0)) return;
  sums_.volume += weight * lens.area;
  sums_.first += weight * Vector3(lens.x, 0, z * lens.area);
  sums_.second.diagonal() += weight * Vector3(lens.xx, lens.yy, z2 * lens.area);
  sums_.second(0, 2) += weight * z * lens.x;
  sums_.second(2, 0) += weight * z * lens.x;
  if (slice.half_arc > 0) addSurface(R, rise, slice, z, z2, weight);
}

/// The rod's outline in the ball, R (cos φ, sin φ), |φ| ≤ half_arc; its normal times the area is (R cos φ, R sin φ, `rise`) dφ dz.
void BallRodContact::addSurface(double R, double rise, const Slice& slice, double z, double z2, double weight) {
  const double f = slice.half_arc;
  const auto [s, c] = elementary::sinCos(f);
  // ∫ 1, cos, cos², cos³ and sin², cos sin² over the arc, by which the rest goes.
  const double i0 = 2 * f, i1 = 2 * s, i2 = f + s * c, i3 = 2 * (s - s * s * s / 3), j2 = f - s * c, j12 = 2 * s * s * s / 3;
  const double a = R, b = -o_.x();  // x = a cos φ + b, y = a sin φ
  const auto add = [&](PlaneMoments& m, double k0, double kx, double kxx, double ky, double kyy, double kxy) {
    m.area += weight * k0;
    m.first += weight * Vector3(kx, ky, z * k0);
    Matrix3 second;
    second << kxx, kxy, z * kx, kxy, kyy, z * ky, z * kx, z * ky, z2 * k0;
    m.second += weight * second;
  };
  add(surface_[0], R * i1, R * (a * i2 + b * i1), R * (a * a * i3 + 2 * a * b * i2 + b * b * i1), 0, R * a * a * j12, 0);
  add(surface_[1], 0, 0, 0, R * a * j2, 0, R * (a * a * j12 + a * b * j2));
  if (rise == 0) return;
  const double xx = a * a * i2 + 2 * a * b * i1 + b * b * i0;
  add(surface_[2], rise * i0, rise * (a * i1 + b * i0), rise * xx, 0, rise * a * a * j2, 0);
}

/// A cylinder's flat end.
void BallRodContact::addEnd(double height, double side) {
  const double u = height - c_;
  if (!(std::abs(u) < r_)) return;
  const LensMoments lens = Slice(R_, std::sqrt((r_ - u) * (r_ + u)), D_, o_.x()).lens;
  const double z = height - o_.z();
  PlaneMoments& m = surface_[2];
  m.area += side * lens.area;
  m.first += side * Vector3(lens.x, 0, z * lens.area);
  m.second.diagonal() += side * Vector3(lens.xx, lens.yy, z * z * lens.area);
  m.second(0, 2) += side * z * lens.x;
  m.second(2, 0) += side * z * lens.x;
}

void ballRodContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                    ContactVolume& out) noexcept {
  BallRodContact(request, cache, workspace, out).find(pair.first.ball()->radius(), *pair.second.rod(), pair.turned, pair.X_AB);
}

}  // namespace haptic
