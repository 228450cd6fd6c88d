#include "haptic_core/world/runaway.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/lanes.h"
#include "haptic_core/dynamics/kinematics.h"
#include "haptic_core/world/work.h"

namespace haptic {
namespace {

/// What steps may make, as a share of the supply: 1 is as much again. A stable explicit step near its limit lets the energy
/// of a mode swing by less, and comes back.
constexpr double kMostMade = 1;
/// Slower than this nothing has run away, whatever it started from [m/s].
constexpr double kSlow = 1e-2;

/// What hands could put in at once: the springs of couplings, and everything that moves thrown back at twice a hand's speed.
double ofHands(const Model& model, const Work& work, const State& state, double mass) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < state.pointers.size(); ++i) {
    const PointerState& pointer = state.pointers[i];
    if (!pointer.targeted) continue;
    const LinkWork& link = work.placement.link[pointer.link];
    const double size = model.links[pointer.link].size;
    const double speed = std::max(pointer.V_WP.linear.norm() + size * pointer.V_WP.angular.norm(),
                                  (link.velocity).norm() * model.holds(static_cast<int>(i)));
    sum += 2 * mass * speed * speed;
    if (model.holds(static_cast<int>(i))) continue;
    const PointerCoupling& c = work.hands.coupling[i];
    const Pose X_WP = link.X_WL * model.pointerFrame(static_cast<int>(i), pointer.link);
    const double turn = vectorFromRotation(pointer.q_WP * Quaternion(X_WP.R).conjugate()).norm();
    sum += 0.5 * c.stiffness * (pointer.p_WP - X_WP.p).squaredNorm() + 0.5 * c.rotational_stiffness * turn * turn;
  }
  return sum;
}

void stop(const Model& model, Work& work, StepReport& report) noexcept {
  double most = -1;
  for (const ModelTree& tree : model.trees) {
    if (!work.hands.movesByItself(tree)) continue;
    const double kinetic = kineticEnergy(*tree.model, work.placement.link.data() + tree.link);
    if (kinetic <= most) continue;
    most = kinetic;
    report.culprit = tree.link;
  }
  work.stopped = true;
  report.finite = false;
  report.flags |= kRunaway;
}

/// 0, or NaN: infinity does not survive in it either, 0·∞ = NaN.
double zeroOrNan(const double* x, int count) noexcept {
  Lanes four = lanes(0);
  int i = 0;
  for (; i + 4 <= count; i += 4) four += lanes(0) * loadLanes(x + i);
  double rest = 0;
#pragma GCC unroll 1
  for (; i < count; ++i) rest += 0 * x[i];
  return sum(four) + rest;
}

}  // namespace

void checkFinite(const Model& model, const State& state, Work& work, StepReport& report) noexcept {
  const Visits& visits = work.visits;
  const bool all = 2 * visits.trees.size() > model.trees.size();  // numbers in a row are quick to look at
  if (all && zeroOrNan(state.v.data(), model.nv) + zeroOrNan(state.q.data(), model.nq) == 0) return;
  for (const int t : visits.trees) {
    const ModelTree& tree = model.trees[t];
    const double sum = zeroOrNan(state.v.data() + tree.v, tree.model->nv()) +
                       zeroOrNan(state.q.data() + tree.q, tree.model->nq());
    if (sum == 0) continue;
    work.stopped = true;
    report.finite = false;
    report.culprit = tree.link;
    return;
  }
}

void startSupply(const Model& model, Work& work, State& state) noexcept {
  ContactWork& contacts = work.contacts;
  const ContactPlaces places{work.placement.link.data(), work.placement.X_WS.data(), work.hands.held_by.data(), nullptr,
                             work.hands.pressed.data()};
  if (contacts.seams.any()) {
    contacts.seams.find(state.pairs.data(), state.pairs.awake(), work.placement.X_WS.data(), contacts.workspace);
  }
  double springs = 0;
  for (const int i : state.pairs.awake()) {
    ActivePair pair = state.pairs[i];  // the cache of this look is not the world's
    ContactEvaluation c;
    if (!locateContact(model, contacts.seams, i, pair, places, contacts.workspace, c)) continue;
    springs += elasticEnergy(c.volume, c.law.material.stiffness, contacts.workspace);
  }
  const MechanicalEnergy now = mechanicalEnergy(model, work.hands, work.placement, state.q.data());
  state.energy.supply = now.kinetic + springs;
  state.energy.highest = state.energy.lowest = now.potential;
  state.energy.gravity = model.settings.gravity;
  state.energy.balance = now.kinetic + now.potential + springs;
  state.energy.balanced = true;
}

void renewSupply(const Model& model, const Work& work, State& state) noexcept {
  const MechanicalEnergy now = mechanicalEnergy(model, work.hands, work.placement, state.q.data());
  state.energy.supply += now.kinetic + (state.energy.highest - state.energy.lowest);
  state.energy.highest = state.energy.lowest = now.potential;
  state.energy.gravity = model.settings.gravity;
  state.energy.balanced = false;
}

void checkRunaway(const Model& model, double h, double external, State& state, Work& work, StepReport& report) noexcept {
  EnergySums& sums = state.energy;
  const bool ledger = model.settings.energy_ledger;
  const auto& sums_now = ledger ? work.sums.tree.sum() : sumEnergies(work.ledgerView(model), state);  // of the ledger that was closed
  const MechanicalEnergy now{sums_now[LedgerSums::kKinetic], sums_now[LedgerSums::kPotential]};
  const double mass = work.hands.moving_mass, fall2 = h * h * model.settings.gravity.squaredNorm();
  if (!ledger && !sums.balanced) {  // no less than what springs hold that were loaded before anybody looked
    for (const int slot : state.pairs.awake()) {
      if (work.reported.touches(slot)) sums.supply += std::abs(work.reported[slot].normal_force) * work.reported[slot].depth;
    }
    sums.balanced = true;
  }
  sums.lowest = std::min(sums.lowest, now.potential);
  sums.supply += std::abs(sums.external - external);
  const double supply = sums.supply + (sums.highest - sums.lowest) + mass * (2 * fall2 + kSlow * kSlow) +
                        2 * mass * model.belt_speed * model.belt_speed +  // a body that a belt throws off is as fast as the belt
                        (work.hands.acting.empty() ? 0.0 : ofHands(model, work, state, mass));
  // Energy that a hand presses in beyond its booked supply is no motion. A damper that gives is in no sum of losses.
  // The gain of k Vol n where n turns is the model's, not the steps': it counts once bodies move by it.
  const double made = std::max(ledger ? std::min(-(sums.still + sums.lost), now.kinetic) : 0.0, now.kinetic - supply);
  if (made > kMostMade * supply) stop(model, work, report);
}

}  // namespace haptic
