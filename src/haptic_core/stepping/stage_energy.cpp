#include "haptic_core/stepping/stage_energy.h"

#include <algorithm>

namespace haptic::stepping {
namespace {

/// Share of v that is left where no reference had little enough energy. Then nothing is left: what stands has
/// none.
constexpr double kSlower = 0.3;

/// Of the island at the start of the stage [J]. Leaves the links there.
double energyAtBase(const Model& model, ImplicitStage& stage) noexcept {
  const Island& island = stage.island;
  double sum = 0;
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model.trees[island.trees[n]];
    std::copy_n(stage.base.q.begin() + tree.q, tree.model->nq(), stage.places.q.begin() + tree.q);
    placeInStage(model, island.trees[n], stage.base.v, stage.places);
    sum += energyOf(model, island.trees[n], stage.places);
  }
  sum = addStored(model, stage.problem, stage.places.link.data(), stage.forces, sum);
  for (int i = 0; i < island.pair_count; ++i) {
    const FrictionMemory& memory = stage.base.memory[island.pairs[i]];
    sum += memory.elastic_energy + memory.energy;
  }
  return sum;
}

/// v = share · from, of which everything is evaluated anew.
void evaluateAt(const Model& model, const std::vector<double>& from, double share, double g, bool may_limit, State& state,
                ImplicitStage& stage) noexcept {
  eachVelocity(model, stage.island, [&](int i) { stage.v[i] = share * from[i]; });
  for (int n = 0; n < stage.island.tree_count; ++n) stage.reference.moved[stage.island.trees[n]] = 1;
  forgetContacts(g, stage);
  evaluate(model, state, g, may_limit, stage);
}

}  // namespace

double energyAtReference(const ImplicitStage& stage) noexcept {
  double sum = 0;
  for (int n = 0; n < stage.island.tree_count; ++n) sum += stage.reference.tree_energy[stage.island.trees[n]];
  return sum + stage.contacts.springEnergy() + stage.forces.stored;
}

double supplyAtReference(const ImplicitStage& stage, double g) noexcept {
  const double of_contacts = stage.contacts.supply(stage.held);
  return g * addSupply(stage.problem, stage.held, stage.places.link.data(), stage.forces, of_contacts);
}

double keepEnergy(const Model& model, State& state, double g, ImplicitStage& stage) noexcept {
  const double most = energyAtBase(model, stage), calm = stage.pass.calm_energy;
  const auto isTooMuch = [&] { return !(energyAtReference(stage) - supplyAtReference(stage, g) <= most); };
  evaluateAt(model, stage.v, 1, g, true, state, stage);
  if (isTooMuch()) evaluateAt(model, stage.pass.calm, calm <= most ? 1.0 : kSlower, g, false, state, stage);
  if (isTooMuch()) evaluateAt(model, stage.pass.calm, 0, g, false, state, stage);
  const double lost = most - energyAtReference(stage);
  carryToEnd(model, g, stage);
  return lost;
}

}  // namespace haptic::stepping
