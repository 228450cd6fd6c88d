/// The energy ledger: where the energy is, where it went.
///
/// What a contact takes from its bodies is the work of its impulses: impulse times the mean of the velocities before and
/// after, which is what the bodies lose, to rounding, however much one step stops them. Velocity Verlet kicks twice
/// between two evaluations: with the last force (its work is known from that evaluation's power and the power's rate) and
/// with the new one. What the bodies lost to the springs and what the springs did not gain is dissipated; for the normal
/// springs the difference is named `turning`, for k Vol n has no potential while n turns.
#include <algorithm>

#include "haptic_core/dynamics/kinematics.h"
#include "haptic_core/geometry/contact_integrals.h"
#include "haptic_core/world/pipeline.h"

namespace haptic {

/// The energy in the contact's springs; its work is booked when the velocities at the end are known.
void Pipeline::keepLedger(int pair, const ContactVolume& volume, const PairLaw& law, const LocatedForce& force,
                          const Pose& X_WP, const FrictionMemory& before, FrictionMemory& now) noexcept {
  const double square = settings_.contact_model == ContactModel::kPoint ? volume.volume * volume.depth
                                                                        : thicknessSquared(workspace_, volume);
  now.elastic_energy = 0.5 * law.material.stiffness * square;  // square: ∫d² dA
  report_.energy.elastic += now.elastic_energy;
  report_.energy.tangential += now.energy;
  ContactWork work;
  work.pair = pair;
  work.X_WP = X_WP;
  work.F_BP_P = force.F_BP_P;
  work.elastic_force = force.elastic_force;
  work.J_BP_P = force.impulse_P;
  work.elastic_impulse = force.elastic_impulse;
  work.sticking = force.sticking;
  work.before = before;
  works_.push_back(work);
}

/// Twist at `p_W`; of a link in a hand the mean over the time h.
Twist Pipeline::twistForWork(int link, const Vector3& p_W, double h) const noexcept {
  const int pointer = heldBy(link);
  if (pointer < 0) return work_[link].twistAt(p_W);
  Twist moved = pointer_moved_[pointer].shifted(p_W - work_[link].X_WL.p);
  if (!(h > 0)) return Twist{};
  moved.angular /= h;
  moved.linear /= h;
  return moved;
}

/// Of B relative to A at P, in P's axes, at the velocities in `work_`.
Twist Pipeline::relativeTwist(const ContactWork& work, double h) const noexcept {
  const ActivePair& pair = state_.pairs[work.pair];
  const int a = plan_.shapes[pair.shapeA()].link, b = plan_.shapes[pair.shapeB()].link;
  return (twistForWork(b, work.X_WP.p, h) - twistForWork(a, work.X_WP.p, h)).rotated(work.X_WP.R.transpose());
}

void Pipeline::setLinkVelocities(const std::vector<double>& v) noexcept {
  for (const PlanTree& tree : plan_.trees) {
    if (isStepped(tree) && !tree.has_laws) forwardVelocities(*tree.model, v.data() + tree.v, work_.data() + tree.link);
  }
}

void Pipeline::book(const ContactWork& work, const ContactPower& taken) noexcept {
  const FrictionMemory& now = state_.pairs[work.pair].friction;
  const double friction = taken.friction - (now.energy - work.before.energy);
  state_.energy[0] += taken.damping + (work.sticking ? friction : 0.0);
  state_.energy[1] += work.sticking ? 0.0 : friction;
  state_.energy[3] += taken.elastic - (now.elastic_energy - work.before.elastic_energy);
}

/// After a step of symplectic Euler, with the mean velocities of the kick in half_ and old positions in `work_`.
void Pipeline::bookEuler(double h) noexcept {
  setLinkVelocities(half_);
  for (const ContactWork& work : works_) {
    book(work, contactPower(work.F_BP_P, work.elastic_force, relativeTwist(work, h)) * h);
  }
}

/// After a step of velocity Verlet: v½ in half_, v in the state and in `work_`. Leaves in the memories what the next half
/// kick will do.
void Pipeline::bookVerlet(double h) noexcept {
  notePowers(h);
  setLinkVelocities(half_);
  for (const ContactWork& work : works_) {
    const Twist V_half = relativeTwist(work, h);
    const Twist V_mean{0.5 * (V_half.angular + work.V_AB_P.angular), 0.5 * (V_half.linear + work.V_AB_P.linear)};
    const ContactPower second = contactPower(work.F_BP_P * (h / 2) + work.J_BP_P,
                                             h / 2 * work.elastic_force + work.elastic_impulse, V_mean);
    book(work, work.before.power * (h / 2) + work.before.power_rate * (h * h / 8) + second);
  }
  setLinkVelocities(state_.v);
}

/// Power of each contact's wrench at the velocities of the state, and its rate as the next kick begins.
void Pipeline::notePowers(double h) noexcept {
  for (ContactWork& work : works_) work.V_AB_P = relativeTwist(work, h);
  std::copy(state_.v.begin(), state_.v.end(), v_dot_.begin());
  for (const PlanTree& tree : plan_.trees) {
    if (isStepped(tree) && !tree.has_laws) kickTree(tree, state_.pull.data() + tree.v, h / 2);
  }
  std::swap(state_.v, v_dot_);
  setLinkVelocities(v_dot_);
  for (const ContactWork& work : works_) {
    const Twist gained = relativeTwist(work, h) - work.V_AB_P;
    FrictionMemory& memory = state_.pairs[work.pair].friction;
    memory.power = contactPower(work.F_BP_P, work.elastic_force, work.V_AB_P);
    memory.power_rate = contactPower(work.F_BP_P, work.elastic_force, gained) * (2 / h);
  }
  setLinkVelocities(state_.v);
}

/// The rest of the energy of a contact that parted `tau` after the last evaluation, while its force fell like
/// (tau - t)ⁿ: half a kick, and what corrects it (Pipeline::part).
void Pipeline::closeLedger(const FrictionMemory& last, double h, double tau, double order) noexcept {
  const ContactPower taken = last.power * (tau / (order + 1)) +
                             last.power_rate * (h * h / 8 + (tau / (order + 1) - h / 2) * h / 2);
  state_.energy[0] += taken.damping + (last.sliding != 0 ? 0.0 : taken.friction + last.energy);
  state_.energy[1] += last.sliding != 0 ? taken.friction + last.energy : 0.0;
  state_.energy[3] += taken.elastic + last.elastic_energy;
}

void Pipeline::fillLedger() noexcept {
  EnergyLedger& energy = report_.energy;
  energy.kinetic = energy.potential = 0;
  for (const PlanTree& tree : plan_.trees) {
    if (!movesByItself(tree)) continue;  // a held link's energy is the hand's
    energy.kinetic += kineticEnergy(*tree.model, work_.data() + tree.link);
    energy.potential += potentialEnergy(*tree.model, work_.data() + tree.link, settings_.gravity);
  }
  energy.damping = state_.energy[0];
  energy.friction = state_.energy[1];
  energy.external = state_.energy[2];
  energy.turning = state_.energy[3];
}

}  // namespace haptic
