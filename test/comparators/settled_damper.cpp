#include "settled_damper.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/analysis/strong_damper.h"

namespace haptic::comparators {
namespace {

/// A damper at the velocity before is stable up to h λ(M⁻¹D) = 2 alone, and the springs need a part of it. A Hunt–Crossley damper k c d
/// grows with the load, so a light body pressed by a hand passes that bound however small its damping at rest. kDamperLimit is the dampers'
/// share; then springs are stable up to h² λ(M⁻¹K) = 0.6. A damper that strong stops its mode within two steps: the step does not resolve
/// more.
constexpr double kDamperLimit = 1.7;

/// Largest eigenvalue of W D from above, by at most 12 %: the sixteenth root of the trace of its sixteenth
/// power. Infinite where W or D are not finite: no damper then.
double dampingRate(const Matrix6& W, const Matrix6& D) noexcept {
  Matrix6 P = W * D;
  const double scale = P.diagonal().cwiseAbs().maxCoeff();  // trace ≤ 6 scale: no overflow below
  if (!std::isfinite(scale)) return std::numeric_limits<double>::infinity();  // an unknown one is not stable
  if (!(scale > 0)) return 0;
  P /= scale;
  for (int i = 0; i < 3; ++i) P = (P * P).eval();
  double root = std::max(0.0, P.cwiseProduct(P.transpose()).sum());
  for (int i = 0; i < 4; ++i) root = std::sqrt(root);
  return scale * root;
}

/// Factor on the damper D [N·m·s/rad … N·s/m] in a step h, with W the mobility of the contact, each body's
/// mass shared among its contacts: then all of them together stay within the limit.
double damperShare(const Matrix6& W, const Matrix6& D, double h) noexcept {
  const double rate = h * dampingRate(W, D);
  return rate > kDamperLimit ? kDamperLimit / rate : 1.0;
}

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

/// δ with (1 + s W D) δ = s u, for positive semidefinite W and D. With D = L Lᵀ: δ = s (u - W L y),
/// (1 + s Lᵀ W L) y = s Lᵀ u, symmetric and never singular.
Vector6 settledChange(const Matrix6& W, const Matrix6& D, double s, const Vector6& u) noexcept {
  const Matrix6 L = semidefiniteFactor(D);
  Matrix6 WL, S;
  WL.noalias() = W.lazyProduct(L);
  S.noalias() = L.transpose().lazyProduct(WL);
  S = s * S + Matrix6::Identity();
  Vector6 y = s * (L.transpose() * u);
  const Matrix6 C = semidefiniteFactor(S);
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < i; ++k) y[i] -= C(i, k) * y[k];
    y[i] /= C(i, i);
  }
  for (int i = 5; i >= 0; --i) {
    for (int k = i + 1; k < 6; ++k) y[i] -= C(k, i) * y[k];
    y[i] /= C(i, i);
  }
  return s * (u - WL * y);
}

/// Whether a link is moved by forces: it has a mobility.
bool isMover(const Model& model, const Work& work, int link) noexcept { return model.links[link].moves && work.hands.held_by[link] < 0; }

/// Mobility ∂V/∂F of a link at P in P's axes, angular first, as if there were nothing but its own joint: on the world by that, or
/// free. R_WL and p_WC as in kinematics.h.
Matrix6 ownMobility(const LinkModel& link, const Matrix3& R_WL, const Vector3& p_WC, const Pose& X_WP) noexcept {
  const Matrix3 R_PL = X_WP.R.transpose() * R_WL;
  const Matrix3 arm = crossMatrix(X_WP.R.transpose() * (X_WP.p - p_WC));
  Matrix6 W;
  if (link.rooted) {
    Eigen::Matrix<double, 6, 3> S;  // the joint's axes as twists of P
    S.topRows<3>() = R_PL * link.S_C.topRows<3>();
    S.bottomRows<3>() = R_PL * link.S_C.bottomRows<3>() - arm * S.topRows<3>();
    W.noalias() = S * link.joint_mobility * S.transpose();
    return W;
  }
  const Matrix3 inverse = R_PL * link.turn_mobility * R_PL.transpose();
  W.topLeftCorner<3, 3>() = inverse;
  W.topRightCorner<3, 3>() = inverse * arm;  // torque of a force at P about C: arm × f
  W.bottomLeftCorner<3, 3>() = -arm * inverse;
  W.bottomRightCorner<3, 3>() = W.bottomLeftCorner<3, 3>() * arm;
  W.bottomRightCorner<3, 3>().diagonal().array() += link.mobility;
  return W;
}

/// Mobility of a mover at P in P's axes, as if it were alone and its mass shared evenly among its contacts.
Matrix6 sharedMobility(const Model& model, const Work& work, const std::vector<int>& on_link, int link, const Pose& X_WP) noexcept {
  const ModelLink& l = model.links[link];
  const double parts = std::max(1, on_link[link]);
  const LinkWork& place = work.placement.link[link];
  return parts * ownMobility(model.trees[l.articulation].model->link(l.local), place.X_WL.R, place.p_WC(), X_WP);
}

PairLaw weakened(const PairLaw& law, double share, double area) noexcept {
  PairLaw weaker = law;
  weaker.material.damping *= share;
  weaker.material.dissipation *= share;
  weaker.material.tangential_damping = share * tangentialDamping(law, area);
  return weaker;
}

}  // namespace

void settleForce(const Model& model, const ActivePair& pair, const ReleaseMemory& last, const std::vector<int>& on_link,
                 const Advance& advance, Work& work, ContactEvaluation& c, LocatedEvent& event) noexcept {
  const auto forceAt = [&](const Twist& V, const PairLaw& law, const Advance& how) {
    return forceWithEvents(c.volume, c.X_AB, work.contacts.workspace, V, pair.friction, law, how, event);
  };
  c.force = forceAt(c.V_AB_P, c.law, advance);
  if (advance.time == 0) return;
  Matrix6 D = c.force.tangent.combined(0, 1);
  const int link_a = model.shapes[pair.shapeA()].link, link_b = model.shapes[pair.shapeB()].link;
  const int parts = std::max({1, on_link[link_a], on_link[link_b]});
  if (!isStrong(D, layerArea(c.volume), parts, advance.time, c.law.reduced_mass)) return;
  Matrix6 W = Matrix6::Zero();
  Matrix6 W_of[2] = {Matrix6::Zero(), Matrix6::Zero()};
  const int link[2] = {link_a, link_b};
  for (int i = 0; i < 2; ++i) {
    if (isMover(model, work, link[i])) W += W_of[i] = sharedMobility(model, work, on_link, link[i], c.X_WP);
  }
  // A contact that begins has no earlier wrench to settle from: its damper is bounded.
  if (pair.friction.touching == 0) {
    const double share = damperShare(W, D, advance.time);
    if (share == 1) return;
    c.force = forceAt(c.V_AB_P, weakened(c.law, share, layerArea(c.volume)), advance);
    return;
  }
  if (!c.force.sticking && pair.friction.sliding == 0) {
    Advance elastic = advance;
    elastic.yielding = Yielding::kNever;
    c.force = forceAt(c.V_AB_P, c.law, elastic);
    D = c.force.tangent.combined(0, 1);
  }
  Vector6 gained = Vector6::Zero();  // by the velocity of B over A at P, from the wrench of the last evaluation to this one, over h/2
  for (int i = 0; i < 2; ++i) {
    if (!isMover(model, work, link[i])) continue;
    // The last wrench with the moment that it had about the body's centre of mass: where a body rocks P wanders over it, and with P the
    // moment of N; where it rolls or slides P goes along with it.
    const LinkWork& place = work.placement.link[link[i]];
    const Vector3 wandered = c.X_WP.p - last.X_WP.p - advance.time * place.twistAt(place.p_WC()).linear;
    Vector6 change = (c.force.F_BP_P - last.F_BP_W.shifted(wandered).rotated(c.X_WP.R.transpose())).vector();
    // Nothing damps what slides: all that its force gained would speed up a mass that is shared for the dampers' sake, several times,
    // until friction sees the rate on its other side and gives energy. One contact alone has the whole mass, and settles.
    if (parts > 1 && !c.force.sticking) change.segment<3>(2).setZero();
    gained += W_of[i] * change;
  }
  const Vector6 delta = settledChange(W, D, 0.5 * advance.time, gained);
  c.force = forceAt({c.V_AB_P.angular + delta.head<3>(), c.V_AB_P.linear + delta.tail<3>()}, c.law, advance);
}

}  // namespace haptic::comparators
