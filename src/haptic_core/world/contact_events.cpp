/// What Velocity Verlet needs at contacts beyond their force: settled dampers, and the impulses of contacts that part.
#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/world/damper_limit.h"
#include "haptic_core/world/pipeline.h"

namespace haptic {
namespace {

/// Damper strength h b A/m from which Velocity Verlet solves for the velocity [1]. Without, rocking on the friction's
/// lever multiplies it by up to four, and one is the limit.
constexpr double kStrongDamper = 0.3;

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

}  // namespace

/// Adds the mobility of a link at P in P's axes, as if it were free and its mass shared evenly among its contacts; nothing
/// for one that does not move by itself. With the mass whole, dampers that settle without regard to one another would
/// correct a body between hand and floor twice; shared out, their sum is stable however many there are (mass splitting:
/// Tonge, Benevolenski, Voroshilov, Mass splitting for jitter-free parallel rigid body simulation, 2012).
void Pipeline::addMobility(int link, const Pose& X_WP, Matrix6& W) const noexcept {
  if (!plan_.links[link].moves || heldBy(link) >= 0) return;
  const PlanLink& l = plan_.links[link];
  const double parts = std::max(1, contacts_on_[link]);
  W += parts * freeMobility(plan_.trees[l.articulation].model->link(l.local), work_[link].X_WL.R, work_[link].p_WC(), X_WP);
}

/// The contact's force, with strong dampers settled. At a predicted velocity alone Velocity Verlet would be stable only
/// up to h λ(W D) < 1, W the mobility of the bodies at P. Beyond kStrongDamper the end velocity is solved for, as far as
/// this contact moves it: δ = h/2 W (F - F_before - D δ). That makes the damper's part of the step the trapezoidal rule,
/// stable for any D, and changes the force by O(h²) only. Whether the patch yields is decided at the settled velocity.
///
/// Symplectic Euler instead takes as much of the damper as its step can (damper_limit.h).
LocatedForce Pipeline::settledForce(const ActivePair& pair, const ContactVolume& volume, const PairLaw& law,
                                    const Pose& X_WP, const Twist& V_AB_P, const Advance& advance) noexcept {
  LocatedForce first = locatedForce(volume, workspace_, V_AB_P, pair.friction, law, advance);
  const bool second_order = advance.old_share > 0;
  if (advance.time == 0 || (second_order && pair.friction.touching == 0)) return first;
  const auto damping = [&](const LocatedForce& force) {
    PatchTangent tangent = force.tangent;
    // What the friction springs take up within the step.
    if (second_order) {
      tangent.tangential_damping += advance.time * (1 - advance.old_share) * tangent.tangential_stiffness;
    }
    return tangent.combined(0, 1);
  };
  Matrix6 D = damping(first);
  const int link_a = plan_.shapes[pair.shapeA()].link, link_b = plan_.shapes[pair.shapeB()].link;
  const int parts = std::max({1, contacts_on_[link_a], contacts_on_[link_b]});
  const double stiffest = std::max({D(5, 5), D(3, 3), D(4, 4), D(0, 0) / volume.A0, D(1, 1) / volume.A0});
  if (parts * advance.time * stiffest < kStrongDamper * law.reduced_mass) return first;
  Matrix6 W = Matrix6::Zero();
  addMobility(link_a, X_WP, W);
  addMobility(link_b, X_WP, W);
  if (!second_order) {
    const double share = damperShare(W, D, advance.time);
    if (share == 1) return first;
    report_.flags |= kDamperLimited;
    PairLaw weaker = law;
    weaker.material.damping *= share;
    weaker.material.dissipation *= share;
    weaker.material.tangential_damping = share * tangentialDamping(law, volume.A0);
    return locatedForce(volume, workspace_, V_AB_P, pair.friction, weaker, advance);
  }
  if (!first.sticking && pair.friction.sliding == 0) {
    Advance elastic = advance;
    elastic.yielding = Yielding::kNever;
    first = locatedForce(volume, workspace_, V_AB_P, pair.friction, law, elastic);
    D = damping(first);
  }
  const Wrench before = Wrench{pair.release.torque_W, pair.release.force_W}.rotated(X_WP.R.transpose());
  const Vector6 delta = settledChange(W, D, 0.5 * advance.time, (first.F_BP_P - before).vector());
  const Twist V{V_AB_P.angular + delta.head<3>(), V_AB_P.linear + delta.tail<3>()};
  return locatedForce(volume, workspace_, V, pair.friction, law, advance);
}

/// What `part` needs if the bodies have come apart at the next evaluation.
void Pipeline::remember(const ContactVolume& volume, const Twist& V_AB_P, const Vector3& p_WP, const Wrench& F_BP_W,
                        ReleaseMemory& release) noexcept {
  release.p_WP = p_WP;
  release.torque_W = F_BP_W.torque;
  release.force_W = F_BP_W.force;
  release.leave = V_AB_P.linear.z() > 0 ? volume.depth / V_AB_P.linear.z() : std::numeric_limits<double>::infinity();
  release.order = std::clamp(volume.A0 * volume.depth / volume.volume, 1.0, 3.0);
}

/// The bodies parted inside the step, τ after its start, while the force fell like (τ - t)ⁿ: its impulse was
/// F τ/(n + 1), where the trapezoidal rule has taken F h/2.
void Pipeline::part(const ActivePair& pair, const Advance& advance) noexcept {
  if (!(advance.old_share > 0)) {
    if (keepsLedger()) closeLedger(pair.friction, 0, 0, 1);
    return;
  }
  const double h = advance.time, tau = std::min(pair.release.leave, h);
  if (keepsLedger()) closeLedger(pair.friction, h, tau, pair.release.order);
  const Wrench F{pair.release.torque_W, pair.release.force_W};
  addKick(plan_.shapes[pair.shapeA()].link, plan_.shapes[pair.shapeB()].link,
          F * (tau / (pair.release.order + 1) - h / 2), pair.release.p_WP);
}

/// An impulse on B, and its opposite on A, at a point of W; taken into account at the end of the step.
void Pipeline::addKick(int link_a, int link_b, const Wrench& J_W, const Vector3& p_W) noexcept {
  if (!has_kick_) {
    for (Wrench& kick : kick_) kick = Wrench{};
  }
  has_kick_ = true;
  kick_[link_b] += J_W.shifted(work_[link_b].p_WO - p_W);
  kick_[link_a] += -J_W.shifted(work_[link_a].p_WO - p_W);
}

}  // namespace haptic
