#include "haptic_core/geometry/pairs/rod_rod_contact.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/pairs/round_contact.h"
#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/volume/rod_integral.h"

namespace haptic {

class RodRodContact : public RoundContact {
 public:
  RodRodContact(const Rod& A, const Rod& B, const Pose& X_AB, const ContactRequest& request,
                PairCache& cache, ContactWorkspace& workspace, ContactVolume& out)
      : RoundContact(request, cache, workspace, out), a_(A), b_(B), X_AB_(X_AB) {}

  void find();

 private:
  double overlapAlong(const Vector3& n) const;
  Vector3 wayOut(const RodPair& pair) const;
  void decideWithoutVolume(const Vector3& way_out);
  double depth(const RodPair& pair) const;

  const Rod &a_, &b_;
  const Pose& X_AB_;
};

/// How far B has to move along unit n, in A's frame, to leave A [m]; negative: a gap.
double RodRodContact::overlapAlong(const Vector3& n) const {
  const Vector3 n_B = X_AB_.R.transpose() * n;
  return n.dot(a_.core(n) - X_AB_.p) - n_B.dot(b_.core(-n_B)) + a_.rounding() + b_.rounding();
}

/// The shortest of the normals of sides and ends.
Vector3 RodRodContact::wayOut(const RodPair& pair) const {
  Vector3 best = Vector3::UnitZ();
  double least = INFINITY;
  for (int i = 0; i < RodPair::kDirections; ++i) {
    const RodPair::Direction way = pair.direction(i);
    if (way.overlap < least) least = way.overlap, best = pair.R_QE * way.n_E;
  }
  return best;
}

/// Overlap along n, or along the nearest of the normals of sides and ends if that is less. Where an end overhangs, n leans over it.
double RodRodContact::depth(const RodPair& pair) const {
  const Vector3 n = out_.normal(), n_E = pair.R_QE.transpose() * n;
  double nearest = 0, along_normal = INFINITY;
  for (int i = 0; i < RodPair::kDirections; ++i) {
    const RodPair::Direction way = pair.direction(i);
    const double cosine = std::abs(way.n_E.dot(n_E));
    if (cosine > nearest) nearest = cosine, along_normal = way.overlap;
  }
  return std::min(overlapAlong(n), along_normal);
}

void RodRodContact::decideWithoutVolume(const Vector3& way_out) {
  ClosestPoints near;
  closestPoints(a_, b_, X_AB_, way_out, near);
  if (near.separated) return setSeparated(near.direction, near.distance);
  setTouching(lastOr(way_out), 0.5 * (near.p_A + near.p_B));
  out_.flags |= ContactVolume::kNormalFromHistory;
}

void RodRodContact::find() {
  if (cache_.direction.squaredNorm() > 0) {
    const double overlap = overlapAlong(cache_.direction);
    if (overlap < 0) return setSeparated(Vector3(cache_.direction), -overlap);
  }
  RodPair pair;
  const bool near = pair.place(a_, b_, X_AB_);
  const Vector3 way_out = wayOut(pair);
  if (!near) return decideWithoutVolume(way_out);
  const RodIntegral integral(pair);
  if (!(integral.solid.volume > 0)) return decideWithoutVolume(way_out);
  v_.X_AQ = Pose();
  v_.sign = 1;
  v_.rod = &a_;
  v_.radius = a_.radius();
  v_.second = {&b_, X_AB_, pair, integral.breaks, false, 0};
  for (int i = 0; i < 3; ++i) v_.parts.push_back({Vector3::Unit(i), -1, 0, integral.surface[i], 0, 0});
  if (!setMoments(integral.solid, integral.origin, Vector3::Zero(), way_out)) return;
  v_.filled = true;
  out_.depth = depth(pair);
}

void rodRodContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                   ContactVolume& out) noexcept {
  RodRodContact(*pair.A().rod(), *pair.B().rod(), pair.X_AB, request, cache, workspace, out).find();
}

}  // namespace haptic
