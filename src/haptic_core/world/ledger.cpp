#include "haptic_core/world/ledger.h"

#include "haptic_core/dynamics/kinematics.h"
#include "haptic_core/world/link_forces.h"

namespace haptic {
namespace {

/// B's relative to A's, of what `of` says of a link, in P's axes.
template <class Of>
Twist relative(const Model& model, const ActivePair& pair, const Pose& X_WP, Of&& of) noexcept {
  const int a = model.shapes[pair.shapeA()].link, b = model.shapes[pair.shapeB()].link;
  return (of(b) - of(a)).rotated(X_WP.R.transpose());
}

/// How hands and belts moved B's surface relative to A's at P in this part, in P's axes [rad], [m]. `share`: of that motion of hands
/// that is over at P.
Twist led(const LedgerView& view, double h, const ActivePair& pair, const Pose& X_WP, double share) noexcept {
  const Twist belt = beltTwist(view.model, pair.shapeA(), pair.shapeB(), view.placement.link.data(), X_WP);
  return relative(view.model, pair, X_WP, [&](int link) {
    const int lead = view.hands.held_by[link];
    if (lead < 0) return Twist{};
    const Twist& moved = view.hands.moved[lead];
    return moved.shifted(X_WP.p - (view.placement.link[link].X_WL.p - (1 - share) * moved.linear));
  }) + Twist{h * belt.angular, h * belt.linear};
}

/// Energy that a led contact's force took along a way, by causes.
ContactPower alongWay(const LedForce& force, const Twist& way_P, const Matrix3& R_PW) noexcept {
  return contactPower(force.F_W.rotated(R_PW), force.elastic_W.rotated(R_PW), way_P);
}

}  // namespace

void bookLed(const LedgerView& view, double h, const ActivePair& pair, const FrictionMemory& before, const LedForce& last,
             const Pose& X_WP, State& state) noexcept {
  const Matrix3 R_PW = X_WP.R.transpose();
  ContactPower taken;
  if (pair.friction.touching != 0) taken = alongWay(pair.led, led(view, h, pair, X_WP, 1), R_PW) * 0.5;
  if (before.touching != 0) {
    const Pose X_WLast(X_WP.R, last.p_W);
    taken = taken + alongWay(last, led(view, h, pair, X_WLast, 0), R_PW) * 0.5;
  }
  state.energy.external += taken.elastic + taken.damping + taken.friction;
  const FrictionMemory& now = pair.friction;
  const bool sticking = (now.touching != 0 ? now : before).sliding == 0;
  const double friction = taken.friction - (now.energy - before.energy);
  const double beyond = taken.elastic - (now.elastic_energy - before.elastic_energy);
  if (!sticking) state.energy.friction += friction;
  state.energy.bookPressure(taken.damping + (sticking ? friction : 0.0), beyond, before, now, pair.buried);
}

namespace {

MechanicalEnergy energyOf(const Model& model, const ModelTree& tree, const Placement& placement, const double* q) noexcept {
  const LinkWork* link = placement.link.data() + tree.link;
  MechanicalEnergy sum{kineticEnergy(*tree.model, link), potentialEnergy(*tree.model, link, model.settings.gravity)};
  for (int i = 0; tree.has_laws && i < tree.model->linkCount(); ++i) {
    if (tree.model->link(i).dof != 1) continue;
    sum.potential += springEnergy(tree.model->def().links[i].joint, q[tree.q + tree.model->link(i).q]);
  }
  return sum;
}

}  // namespace

const SumTree<LedgerSums::kColumns>::Row& sumEnergies(const LedgerView& view, const State& state) noexcept {
  for (const int t : view.visits.trees) {
    const ModelTree& tree = view.model.trees[t];
    MechanicalEnergy energy;  // a held link's is the hand's
    if (view.hands.movesByItself(tree)) energy = energyOf(view.model, tree, view.placement, state.q.data());
    view.sums.now[t] = {energy.kinetic, energy.potential, 0, 0};
  }
  if (!view.model.forces.empty()) {
    for (const int t : view.visits.trees) {
      view.sums.now[t][LedgerSums::kPotential] += springsOf(view.model, t, view.hands, view.placement);
    }
  }
  for (const int i : state.pairs.awake()) {
    const ActivePair& pair = state.pairs[i];
    if (pair.friction.touching == 0) continue;
    const int a = view.model.treeOf(pair.shapeA());
    auto& row = view.sums.now[view.model.trees[a].model->isStatic() ? view.model.treeOf(pair.shapeB()) : a];
    row[LedgerSums::kElastic] += pair.friction.elastic_energy;
    row[LedgerSums::kTangential] += pair.friction.energy;
  }
  for (const int t : view.visits.trees) view.sums.tree.set(static_cast<std::size_t>(t), view.sums.now[t]);
  return view.sums.tree.sum();
}

MechanicalEnergy mechanicalEnergy(const Model& model, const HandWork& hands, const Placement& placement, const double* q) noexcept {
  MechanicalEnergy sum;
  for (const ModelTree* tree : hands.movers) {
    const MechanicalEnergy energy = energyOf(model, *tree, placement, q);
    sum.kinetic += energy.kinetic;
    sum.potential += energy.potential;
    if (!model.forces.empty()) sum.potential += springsOf(model, model.indexOf(*tree), hands, placement);
  }
  return sum;
}

EnergyLedger closeLedger(const LedgerView& view, double unaccounted, State& state) noexcept {
  const auto& now = sumEnergies(view, state);
  EnergyLedger energy;
  energy.kinetic = now[LedgerSums::kKinetic];
  energy.potential = now[LedgerSums::kPotential];
  energy.elastic = now[LedgerSums::kElastic];
  energy.tangential = now[LedgerSums::kTangential];
  energy.damping = state.energy.damping;
  energy.friction = state.energy.friction;
  energy.external = state.energy.external;
  energy.turning = state.energy.turning;
  energy.stilled = state.energy.stilled;
  const double balance = energy.balance();
  if (state.energy.balanced) {
    state.energy.lost += state.energy.balance - balance;
  } else {
    state.energy.lost += unaccounted - state.energy.unaccounted();
    state.energy.supply += energy.elastic + energy.tangential;
  }
  state.energy.balance = balance;
  state.energy.balanced = true;
  energy.numerical = state.energy.lost + state.energy.still;
  return energy;
}

}  // namespace haptic
