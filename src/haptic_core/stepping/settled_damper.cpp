#include "haptic_core/stepping/settled_damper.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/world/damper_limit.h"
#include "haptic_core/world/stability_number.h"

namespace haptic::stepping {
namespace {

/// Lower L with L Lᵀ = A for a positive semidefinite A; columns without a pivot are zero.
Matrix6 semidefiniteFactor(const Matrix6& A) noexcept {
  Matrix6 L = Matrix6::Zero();
  for (int j = 0; j < 6; ++j) {
    double pivot = A(j, j);
    for (int k = 0; k < j; ++k) pivot -= L(j, k) * L(j, k);
    if (!(pivot > 1e-14 * A(j, j))) continue;
    L(j, j) = std::sqrt(pivot);
    for (int i = j + 1; i < 6; ++i) {
      double sum = A(i, j);
      for (int k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
      L(i, j) = sum / L(j, j);
    }
  }
  return L;
}

/// δ with (1 + s W D) δ = s W r, for positive semidefinite W and D. With D = L Lᵀ: δ = s W (r - L y),
/// (1 + s Lᵀ W L) y = s Lᵀ W r, symmetric and never singular.
Vector6 settledChange(const Matrix6& W, const Matrix6& D, double s, const Vector6& r) noexcept {
  const Matrix6 L = semidefiniteFactor(D);
  Matrix6 WL, S;
  WL.noalias() = W.lazyProduct(L);
  S.noalias() = L.transpose().lazyProduct(WL);
  S = s * S + Matrix6::Identity();
  Vector6 y = s * (WL.transpose() * r);
  const Matrix6 C = semidefiniteFactor(S);
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < i; ++k) y[i] -= C(i, k) * y[k];
    y[i] /= C(i, i);
  }
  for (int i = 5; i >= 0; --i) {
    for (int k = i + 1; k < 6; ++k) y[i] -= C(k, i) * y[k];
    y[i] /= C(i, i);
  }
  return s * (W * r - WL * y);
}

/// Adds the mobility of a link at P in P's axes, as if it were alone and its mass shared evenly among its contacts; nothing
/// for one that does not move by itself.
void addMobility(const Model& model, const Work& work, int link, const Pose& X_WP, Matrix6& W) noexcept {
  const ModelLink& l = model.links[link];
  if (!l.moves || work.hands.held_by[link] >= 0) return;
  const double parts = std::max(1, work.contacts.on_link[link]);
  const LinkWork& place = work.placement.link[link];
  W += parts * ownMobility(model.trees[l.articulation].model->link(l.local), place.X_WL.R, place.p_WC(), X_WP);
}

/// Velocity at p_W of the two links, the mean of those that move by themselves [m/s].
Vector3 carriedAt(const Model& model, const Work& work, int link_a, int link_b, const Vector3& p_W) noexcept {
  Vector3 sum = Vector3::Zero();
  int movers = 0;
  for (const int link : {link_a, link_b}) {
    if (!model.links[link].moves || work.hands.held_by[link] >= 0) continue;
    sum += work.placement.link[link].twistAt(p_W).linear;
    ++movers;
  }
  return movers == 2 ? Vector3(0.5 * sum) : sum;
}

PairLaw weakened(const PairLaw& law, double share, double area) noexcept {
  PairLaw weaker = law;
  weaker.material.damping *= share;
  weaker.material.dissipation *= share;
  weaker.material.tangential_damping = share * tangentialDamping(law, area);
  return weaker;
}

}  // namespace

void settleForce(const Model& model, const ActivePair& pair, const Advance& advance, Work& work, ContactEvaluation& c,
                 unsigned& flags) noexcept {
  const auto forceAt = [&](const Twist& V, const PairLaw& law, const Advance& how) {
    return locatedForce(c.volume, c.X_AB, work.contacts.workspace, V, pair.friction, law, how);
  };
  c.force = forceAt(c.V_AB_P, c.law, advance);
  if (advance.time == 0) return;
  Matrix6 D = c.force.tangent.combined(0, 1);
  const int link_a = model.shapes[pair.shapeA()].link, link_b = model.shapes[pair.shapeB()].link;
  const int parts = std::max({1, work.contacts.on_link[link_a], work.contacts.on_link[link_b]});
  if (!isStrong(D, layerArea(c.volume), parts, advance.time, c.law.reduced_mass)) return;
  Matrix6 W = Matrix6::Zero();
  addMobility(model, work, link_a, c.X_WP, W);
  addMobility(model, work, link_b, c.X_WP, W);
  // A contact that begins has no earlier wrench to settle from: its damper is bounded.
  if (pair.friction.touching == 0) {
    const double share = damperShare(W, D, advance.time);
    if (share == 1) return;
    flags |= kDamperLimited;
    c.force = forceAt(c.V_AB_P, weakened(c.law, share, layerArea(c.volume)), advance);
    return;
  }
  if (!c.force.sticking && pair.friction.sliding == 0) {
    Advance elastic = advance;
    elastic.yielding = Yielding::kNever;
    c.force = forceAt(c.V_AB_P, c.law, elastic);
    D = c.force.tangent.combined(0, 1);
  }
  // About P of now, as the bodies carried it there: where they rock, P wanders over them, and with it the moment of N.
  const Vector3 wandered = c.X_WP.p - pair.release.X_WP.p - advance.time * carriedAt(model, work, link_a, link_b, c.X_WP.p);
  const Wrench before = pair.release.F_BP_W.shifted(wandered).rotated(c.X_WP.R.transpose());
  Vector6 gained = (c.force.F_BP_P - before).vector();
  // Nothing damps what slides: all that its force gained would speed up a mass that is shared for the dampers' sake, several times,
  // until friction sees the rate on its other side and gives energy. One contact alone has the whole mass, and settles.
  if (parts > 1 && !c.force.sticking) gained.segment<3>(2).setZero();
  const Vector6 delta = settledChange(W, D, 0.5 * advance.time, gained);
  c.force = forceAt({c.V_AB_P.angular + delta.head<3>(), c.V_AB_P.linear + delta.tail<3>()}, c.law, advance);
}

}  // namespace haptic::stepping
