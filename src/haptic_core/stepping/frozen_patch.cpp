#include "haptic_core/stepping/frozen_patch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/base/elementary.h"

namespace haptic {
namespace {

/// Depth that every point keeps, as a share of the mean: a point at 0 or below would answer no approach.
constexpr double kLeastDepth = 1e-3;
/// Points are split when s is at least this, and stay inside at most by the rest to 1: a face has 0, an edge
/// 0.58, a corner 0.71.
constexpr double kLeastSplit = 0.05, kMostSplit = 0.95;
/// Faces stand for a patch whose force they have within this factor; the rest of it is other faces' or clipped.
constexpr double kMostScale = 1.5;

/// Eigenpairs of a symmetric positive semidefinite 2 × 2 matrix.
struct Axes {
  double value[2];
  Vector2 axis[2];
  explicit Axes(const Matrix2& C) {
    const double mean = 0.5 * (C(0, 0) + C(1, 1)), half = 0.5 * (C(0, 0) - C(1, 1)), off = C(0, 1);
    const double radius = std::sqrt(half * half + off * off);
    value[0] = std::max(0.0, mean + radius);
    value[1] = std::max(0.0, mean - radius);
    const double angle = radius > 0 ? 0.5 * elementary::atan2(off, half) : 0.0;
    const auto [sine, cosine] = elementary::sinCos(angle);
    axis[0] << cosine, sine;
    axis[1] << -axis[0].y(), axis[0].x();
  }
};

/// The part of a patch that presses: its area's moments, volume, and ∫ r d. All of it where nothing is clipped, or nothing presses.
struct Pressing {
  PatchMoments area;
  PressedVolume volume;

  Pressing(const ContactVolume& V, const LocatedForce& force, const PairLaw& law)
      // Where the surface folds over, A0 counts parts of it negative; the volume over its extent is never more than the area.
      : area{std::max(V.A0, V.volume / V.depth), V.A1, V.A2}, volume{V.volume, Vector2::Zero()} {
    if (!force.clipped || !(force.pressed.volume > 0)) return;
    const double k = law.material.stiffness;
    const double factor = jumpsAtTouch(law.pressure) ? 1 : std::max(kLeastPressing, force.normal_force / (k * force.pressed.volume));
    const PatchMoments part = force.tangent.stiffness * (1 / (k * factor));
    if (!(part.m0 > 0)) return;
    area = part;
    volume = force.pressed;
  }
};

}  // namespace

void FrozenPatch::setLaw(const PairLaw& law, double g) noexcept {
  g_ = g;
  k_ = law.material.stiffness;
  c_ = law.material.dissipation;
  b_ = law.material.damping;
  linear_ = jumpsAtTouch(law.pressure);
  torsion_ = law.torsion;
  constant_.setZero();
  beyond_.setZero();
  load_ = 0;
  scale_ = 1;
  is_known_ = false;
  faces_.clear();
}

/// Four places, weights and depths from the moments of an area and of the `thickness` [m³] over it, V1 = ∫ r
/// d.
void FrozenPatch::layOut(const ContactVolume& volume, const PatchMoments& moments, double thickness,
                         const Vector2& V1) noexcept {
  const double area = moments.m0, depth = thickness / area;
  const Vector2 mean = moments.m1 / area, lean_to = V1 / thickness - mean;
  const Axes axes(moments.m2 / area - mean * mean.transpose());
  points_ = 4;
  weight_ = 0.25 * area;
  for (int j = 0; j < 2; ++j) {
    const double root = std::sqrt(axes.value[j]),
                 lean = root > 0 ? M_SQRT2 * lean_to.dot(axes.axis[j]) / root : 0.0;
    for (int s = 0; s < 2; ++s) {
      const double sign = s == 0 ? 1 : -1;
      const Vector2 r = volume.compressing.felt(mean + sign * M_SQRT2 * root * axes.axis[j]);
      const int i = 2 * j + s;
      x_[i] = r.x();
      y_[i] = r.y();
      depth_[i] = depth * std::max(kLeastDepth, 1 + sign * lean);
    }
  }
  place_ = volume.X_AP.p + volume.X_AP.R.leftCols<2>() * mean;
  radius_ = std::sqrt(axes.value[0] + axes.value[1]);
}

void FrozenPatch::freeze(const ContactVolume& volume, double squares, const LocatedForce& force,
                         const PairLaw& law, const Vector6& V, double g) noexcept {
  setLaw(law, g);
  friction_ = force.layer;
  const Pressing part(volume, force, law);
  layOut(volume, part.area, part.volume.volume, part.volume.first);
  double linear = 0;  // ∫ d² dA of the four
  for (int i = 0; i < 4; ++i) linear += weight_ * depth_[i] * depth_[i];
  const double split2 = squares * part.volume.volume / volume.volume / linear - 1;
  if (split2 > kLeastSplit * kLeastSplit) {
    points_ = 8;
    weight_ *= 0.5;
    const double split = std::min(kMostSplit, std::sqrt(split2));
    for (int i = 0; i < 4; ++i) {
      depth_[i + 4] = depth_[i] * (1 - split);
      depth_[i] *= 1 + split;
    }
  }
  setReach(V);
  const Wrench F = force.F_BP_P - force.beyond_P;
  beyond_ = force.beyond_P.vector();
  matchForce({force.normal_force, -F.torque.y(), F.torque.x()}, V);
}

/// Makes the force at the reference exact: scales all pressures, then shifts all places, at most by the radius; what that leaves over of
/// the moments is constant.
void FrozenPatch::matchForce(const Vector3& exact, const Vector6& V) noexcept {
  Vector3 first;
  scale_ = 1;
  constant_.setZero();
  sum(V, first);
  if (first[0] > 0 && exact[0] > 0) {
    scale_ = exact[0] / first[0];
    Vector2 shift = exact.tail<2>() / exact[0] - first.tail<2>() / first[0];
    if (shift.norm() > radius_) shift *= radius_ / shift.norm();
    if (faces_.empty()) {
      for (int i = 0; i < 4; ++i) x_[i] += shift.x(), y_[i] += shift.y();
    } else {
      faces_.shift(shift.x(), shift.y());
    }
    setReach(V);
    sum(V, first);
  }
  constant_ = exact - first;
  load_ = first[0];
  first_ = exact;
  is_known_ = true;
}

void FrozenPatch::freezeNear(const ContactVolume& near, double closer, const PairLaw& law, const Vector6& V,
                             double g) noexcept {
  setLaw(law, g);
  friction_ = FrictionLayer{};
  layOut(near, {std::max(near.A0, near.volume / near.depth), near.A1, near.A2}, near.volume, Vector2::Zero());
  for (int i = 0; i < 4; ++i) {
    const double depth = depth_[i] - closer;
    reach_[i] = depth < 0 ? depth + g * approachOf(V, i) : -std::numeric_limits<double>::infinity();
  }
}

void FrozenPatch::part(const Vector6& V) noexcept {
  is_known_ = false;
  beyond_.setZero();
  const LinearField v_n = approachField(V);
  // Where the faces would overlap still, they touch: no more than their gap is left everywhere.
  double deepest = 0;
  for (int i = 0; i < faces_.corners(); ++i) {
    deepest = std::max(deepest, faces_reach_.at(faces_.x(i), faces_.y(i)) - g_ * v_n.at(faces_.x(i), faces_.y(i)));
  }
  faces_reach_.c -= deepest;
  for (int i = 0; i < points_; ++i) reach_[i] = std::min(reach_[i], g_ * approachOf(V, i));
  constant_.setZero();
}

/// Force of a point over its weight, and how it falls with v_n, times g.
double FrozenPatch::press(double v_n, double reach, double& slope) const noexcept {
  const double open = reach - g_ * v_n;
  slope = 0;
  if (!(open > 0)) return 0;
  if (linear_) {
    const double p = k_ * open - b_ * v_n;
    if (!(p > 0)) return 0;
    slope = g_ * (k_ * g_ + b_);
    return p;
  }
  const double factor = 1 - c_ * v_n;
  if (!(factor > 0)) return 0;
  slope = g_ * k_ * (g_ * factor + c_ * open);
  return k_ * open * factor;
}

LinearField FrozenPatch::openField(const Vector6& V) const noexcept {
  const LinearField v_n = approachField(V);
  return {faces_reach_.c - g_ * v_n.c, faces_reach_.cx - g_ * v_n.cx, faces_reach_.cy - g_ * v_n.cy};
}

/// The field that has to be positive besides, where the faces press.
LinearField FrozenPatch::pressureField(const Vector6& V) const noexcept {
  const LinearField v_n = approachField(V);
  if (!linear_) return {1 - c_ * v_n.c, -c_ * v_n.cx, -c_ * v_n.cy};
  const LinearField open = openField(V);
  return {k_ * open.c - b_ * v_n.c, k_ * open.cx - b_ * v_n.cx, k_ * open.cy - b_ * v_n.cy};
}

/// Visits (x, y, weight [m²], v_n, D).
template <class Visit>
void FrozenPatch::eachPressing(const Vector6& V, Visit&& visit) const noexcept {
  if (faces_.empty()) {
    for (int i = 0; i < points_; ++i) visit(x_[i & 3], y_[i & 3], scale_ * weight_, approachOf(V, i), reach_[i]);
    return;
  }
  const LinearField v_n = approachField(V);
  faces_.integrate(openField(V), pressureField(V), [&](double x, double y, double weight) {
    visit(x, y, scale_ * weight, v_n.at(x, y), faces_reach_.at(x, y));
  });
}

void FrozenPatch::sum(const Vector6& V, Vector3& first) const noexcept {
  first.setZero();
  eachPressing(V, [&](double x, double y, double weight, double v_n, double reach) {
    double slope;
    const double p = weight * press(v_n, reach, slope);
    first += p * Vector3(1, x, y);
  });
}

void FrozenPatch::setReach(const Vector6& V) noexcept {
  for (int i = 0; i < points_; ++i) reach_[i] = depth_[i] + g_ * approachOf(V, i);
  const LinearField v_n = approachField(V), &d = faces_.thickness();
  faces_reach_ = {d.c + g_ * v_n.c, d.cx + g_ * v_n.cx, d.cy + g_ * v_n.cy};
}

bool FrozenPatch::spread(const FaceOverlay& faces, const Vector6& V) noexcept {
  const Vector3 exact = first_;
  Vector3 first;
  const FrozenPatch points = *this;
  faces_ = faces;
  scale_ = 1;
  constant_.setZero();
  setReach(V);
  sum(V, first);
  if (first[0] < kMostScale * exact[0] && kMostScale * first[0] > exact[0]) {
    matchForce(exact, V);
    return true;
  }
  *this = points;
  return false;
}

void FrozenPatch::freezeNear(const FaceOverlay& faces, const PairLaw& law, const Vector6& V, double g) noexcept {
  setLaw(law, g);
  friction_ = FrictionLayer{};
  points_ = 0;
  faces_ = faces;
  setReach(V);
}

double FrozenPatch::missedDepth(const Vector6& V, double mean_depth) const noexcept {
  double most = 0;
  if (faces_.empty()) {
    for (int i = 0; i < 4; ++i) most = std::max(most, std::abs(approachOf(V, i)));
    return g_ * most * g_ * most / mean_depth;
  }
  const LinearField v_n = approachField(V);
  for (int i = 0; i < faces_.corners(); ++i) most = std::max(most, std::abs(v_n.at(faces_.x(i), faces_.y(i))));
  return g_ * most * g_ * (V.head<3>().norm() + V.segment<2>(3).norm() / extent());
}

void FrozenPatch::evaluate(const Vector6& V, Force& out) const noexcept {
  sum(V, out.first);
  out.share = load_ > 0 ? std::clamp(out.first[0] / load_, 0.0, 1.0) : 0;
  out.first += out.share * constant_;
  out.normal = std::max(0.0, out.first[0]);
  out.friction = friction_.hold(slipRate(V), g_, out.normal);
  setForce(out);
}

bool FrozenPatch::evaluateAtReference(const Vector6& V, Force& out) const noexcept {
  if (!is_known_) return false;
  out.first = first_;
  out.share = 1;
  out.normal = std::max(0.0, out.first[0]);
  out.friction = friction_.hold(slipRate(V), g_, out.normal);
  setForce(out);
  return true;
}

void FrozenPatch::stick(const Vector6& V, Force& out) const noexcept {
  FrictionLayer stuck = friction_;
  stuck.limited = stuck.dragged = false;
  out.friction = stuck.hold(slipRate(V), g_, out.normal);
  setForce(out);
}

Vector2 FrozenPatch::missedFriction(const Vector6& V, const Vector6& F_done) const noexcept {
  return friction_.hold(slipRate(V), g_, F_done[5]).force.head<2>() - F_done.segment<2>(3);
}

/// Of the pressure's sums and of friction.
void FrozenPatch::setForce(Force& out) const noexcept {
  const Vector3& f = out.friction.force;
  out.F << out.first[2], -out.first[1], f[2], f[0], f[1], out.first[0];
  out.F += out.share * beyond_;
}

Matrix6 FrozenPatch::tangent(const Vector6& V, const Force& force) const noexcept {
  PatchMoments w;
  eachPressing(V, [&](double x, double y, double weight, double v_n, double reach) {
    double slope;
    press(v_n, reach, slope);
    const Vector2 r(x, y);
    w.m0 += weight * slope;
    w.m1 += weight * slope * r;
    w.m2 += weight * slope * (r * r.transpose());
  });
  PatchTangent t;
  t.damping = w;
  t.compliant_area = friction_.compliantArea(force.friction, force.normal);
  t.tangential_damping = g_ * (g_ * friction_.stiffness + friction_.damping);
  return t.combined(0, 1);
}

Vector6 FrozenPatch::perLoad(const Vector6& V, const Force& force) const noexcept {
  const Vector3 f = friction_.perLoad(force.friction, slipRate(V), g_, force.normal);
  Vector6 F;
  F << 0, 0, f[2], f[0], f[1], 0;
  return F;
}

/// k ∫ d dA and ½ k ∫ d² dA over faces with the thickness d.
Vector2 FrozenPatch::springsOver(const LinearField& d) const noexcept {
  Vector2 sum(0, 0);
  faces_.integrate(d, {1, 0, 0}, [&](double x, double y, double weight) {
    const double thick = d.at(x, y);
    sum += weight * thick * Vector2(1, 0.5 * thick);
  });
  return scale_ * k_ * sum;
}

/// The same at a twist, less that at the reference.
Vector2 FrozenPatch::springsGained(const Vector6& V) const noexcept {
  if (!faces_.empty()) return springsOver(openField(V)) - springsOver(faces_.thickness());
  Vector2 sum(0, 0);
  for (int i = 0; i < points_; ++i) {
    const double d = std::max(0.0, reach_[i] - g_ * approachOf(V, i));
    sum += Vector2(d - depth_[i], 0.5 * (d * d - depth_[i] * depth_[i]));
  }
  return scale_ * k_ * weight_ * sum;
}

void FrozenPatch::carry(const Vector6& V, const Force& force, const Pose& X_AP, LocatedForce& out, double& elastic) const noexcept {
  const double limit = force.normal;
  const Vector2 springs = springsGained(V);
  out.elastic_force += springs[0];
  elastic += springs[1];
  const FrictionLayer::Hold& friction = force.friction;
  const Vector3 slip = friction_.slip(friction, slipRate(V), g_, limit);
  out.F_BP_P = {force.F.head<3>(), force.F.tail<3>()};
  out.normal_force = force.normal;
  out.sticking = !friction.outside;
  FrictionMemory& m = out.memory;
  const bool yields = friction.outside || !(limit > 0);
  out.yielded = yields ? Vector3(friction_.before + g_ * slipRate(V) - slip) : Vector3::Zero();
  const auto tangents = X_AP.R.leftCols<2>();
  out.renewed |= yields;
  m.slip_M = out.toM(tangents * slip.head<2>());
  m.twist = slip[2];
  if (out.renewed) {
    m.anchor = out.trial;
    m.anchor.slip_A -= tangents * out.yielded.head<2>();
    m.anchor.twist -= out.yielded[2];
  }
  m.rate_M = out.toM(tangents * Vector2(V[3], V[4]));
  m.spin = V[2];
  m.force_M = out.toM(tangents * friction.force.head<2>());
  m.torque = friction.force[2];
  m.load = friction_.load(friction, limit);
  m.sliding = friction.outside ? 1 : 0;
  m.energy = 0.5 * friction_.stiffness * slip.cwiseProduct(friction_.area).dot(slip);
}

}  // namespace haptic
