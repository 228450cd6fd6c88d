/// The energy ledger: where the energy is, where it went.
#include <algorithm>

#include "haptic_core/dynamics/kinematics.h"
#include "haptic_core/geometry/contact_integrals.h"
#include "haptic_core/world/pipeline.h"

namespace haptic {

/// Work of one contact over the step, by the same rule as its impulse: W = h (w P_old + (1 - w) P_new). What the
/// bodies lost to the springs and what the springs did not gain is dissipated; for the normal springs the difference
/// is named `turning`, for k Vol n has no potential while n turns.
void Pipeline::keepLedger(const ContactVolume& volume, const PairLaw& law, const FrictionMemory& before,
                          const LocatedForce& force, const Advance& advance, FrictionMemory& now) noexcept {
  const double square = settings_.contact_model == ContactModel::kPoint ? volume.volume * volume.depth
                                                                        : thicknessSquared(workspace_, volume);
  now.elastic_energy = 0.5 * law.material.stiffness * square;  // square: ∫d² dA
  report_.energy.elastic += now.elastic_energy;
  report_.energy.tangential += now.energy;
  if (advance.time == 0) return;
  double h = advance.time, w = advance.old_share;
  if (w > 0 && before.touching == 0 && force.event < 1) {
    // It began inside the step and its power grew like (t - t_touch)ⁿ.
    h *= 1 - force.event;
    w = 1 - 1 / (std::clamp(volume.A0 * volume.depth / volume.volume, 1.0, 3.0) + 1);
  }
  const auto work = [&](double old_power, double power) { return h * (w * old_power + (1 - w) * power); };
  const double friction = work(before.power, now.power) - (now.energy - before.energy);
  state_.energy[0] += work(before.damping_power, now.damping_power) + (force.sticking ? friction : 0.0);
  state_.energy[1] += force.sticking ? 0.0 : friction;
  state_.energy[3] += work(before.elastic_power, now.elastic_power) - (now.elastic_energy - before.elastic_energy);
}

/// The rest of the energy of a contact that ended `tau` after the last evaluation.
void Pipeline::closeLedger(const FrictionMemory& last, double tau, double order) noexcept {
  const double share = tau / (order + 1);
  state_.energy[0] += share * last.damping_power + (last.sliding != 0 ? 0.0 : share * last.power + last.energy);
  state_.energy[1] += last.sliding != 0 ? share * last.power + last.energy : 0.0;
  state_.energy[3] += share * last.elastic_power + last.elastic_energy;
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
