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
  void decideWithoutVolume(const Vector3& way_out);
  double depth(const RodPair::Directions& directions, const RodPair& pair) const;

  const Rod &a_, &b_;
  const Pose& X_AB_;
};

/// Overlap along n, or along the nearest of the normals of sides and ends if that is less. Where an end overhangs, n leans over it.
double RodRodContact::depth(const RodPair::Directions& directions, const RodPair& pair) const {
  const Vector3 n_E = pair.intoE(out_.normal());
  double nearest = 0, along_normal = INFINITY;
  for (const RodPair::Direction& way : directions) {
    const double cosine = std::abs(way.n_E.dot(n_E));
    if (cosine > nearest) nearest = cosine, along_normal = way.overlap;
  }
  return std::min(pair.overlapAlong(n_E), along_normal);
}

void RodRodContact::decideWithoutVolume(const Vector3& way_out) {
  ClosestPoints near;
  closestPoints(a_, b_, X_AB_, way_out, near);
  if (near.separated) return setSeparated(near.direction, near.distance);
  setTouching(lastOr(way_out), 0.5 * (near.p_A + near.p_B));
  out_.flags |= ContactVolume::kNormalFromHistory;
}

void RodRodContact::find() {
  RodPair& pair = v_.second.pair;
  const bool near = pair.place(a_, b_, X_AB_);
  if (cache_.direction.squaredNorm() > 0) {
    const double overlap = pair.overlapAlong(pair.intoE(cache_.direction));
    if (overlap < 0) return setSeparated(Vector3(cache_.direction), -overlap);
  }
  const RodPair::Directions directions = pair.directions();
  const RodPair::Direction* shortest = &directions[0];
  for (const RodPair::Direction& way : directions) {
    if (way.overlap < shortest->overlap) shortest = &way;
  }
  const Vector3 way_out = pair.R_AE * shortest->n_E;
  if (!near) return decideWithoutVolume(way_out);
  const RodIntegral integral(pair, v_.second.breaks);
  if (!(integral.solid.volume > 0)) return decideWithoutVolume(way_out);
  v_.X_AQ = Pose(pair.R_AE, Vector3::Zero());
  v_.sign = 1;
  v_.rod = &a_;
  v_.radius = a_.radius();
  v_.second.rod = &b_;
  v_.second.outlined = false;
  for (int i = 0; i < 3; ++i) v_.parts.push_back({Vector3::Unit(i), -1, 0, integral.surface[i], 0, 0});
  if (!setMoments(integral.solid, integral.origin, Vector3::Zero(), way_out)) return;
  v_.filled = true;
  out_.depth = depth(directions, pair);
}

void rodRodContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                   ContactVolume& out) noexcept {
  RodRodContact(*pair.A().rod(), *pair.B().rod(), pair.X_AB, request, cache, workspace, out).find();
}

}  // namespace haptic
