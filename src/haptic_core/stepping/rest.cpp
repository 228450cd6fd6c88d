#include "haptic_core/stepping/rest.h"

#include <algorithm>

#include "haptic_core/world/link_forces.h"

namespace haptic::stepping {
namespace {

/// No link of the tree is faster than `most` [m/s].
bool isSlow(const Model& model, const ModelTree& tree, double most, const Placement& placement) noexcept {
  for (int l = tree.link; l < tree.link + tree.model->linkCount(); ++l) {
    const LinkWork& link = placement.link[l];
    const double size = model.links[l].size;
    if (!(link.velocity.squaredNorm() + size * size * link.omega.squaredNorm() <= most * most)) return false;
  }
  return true;
}

}  // namespace

bool isStill(const Model& model, int tree, const State& state) noexcept {
  const double* v = state.v.data() + model.trees[tree].v;
  return std::all_of(v, v + model.trees[tree].model->nv(), [](double x) { return x == 0; });
}

bool standsAlone(const Model& model, const Island& island, const State& state) noexcept {
  const auto has = [&island](int tree) { return std::binary_search(island.trees, island.trees + island.tree_count, tree); };
  for (int n = 0; n < island.tree_count; ++n) {
    if (model.trees[island.trees[n]].has_laws) return false;
  }
  for (const PointerState& pointer : state.pointers) {
    if (pointer.targeted && has(model.links[pointer.link].articulation)) return false;
  }
  for (int i = 0; i < island.pair_count; ++i) {
    const ActivePair& pair = state.pairs[island.pairs[i]];
    for (const int tree : {model.treeOf(pair.shapeA()), model.treeOf(pair.shapeB())}) {
      if (!model.trees[tree].model->isStatic() && !has(tree)) return false;
    }
  }
  return model.forces.empty() || forcesStayWithin(model, {island.trees, island.tree_count});
}

bool isCalm(const Island& island, const State& state) noexcept {
  return std::all_of(island.trees, island.trees + island.tree_count, [&](int t) { return state.calm[t] >= kCalmSteps; });
}

void countCalm(const Model& model, const HandWork& hands, const Placement& placement, State& state) noexcept {
  const double most = restingSpeed(model.settings, model.settings.step);
  for (const ModelTree* tree : hands.movers) {
    const int t = model.indexOf(*tree);
    if (state.turn[t] != 0 && state.as_of[t] <= state.step) continue;  // it has been counted at its turn
    state.calm[t] = isSlow(model, *tree, most, placement) ? std::min(state.calm[t] + 1, kCalmSteps) : 0;
  }
  for (const PointerState& pointer : state.pointers) {
    if (pointer.link >= 0 && hands.held_by[pointer.link] >= 0) state.calm[model.links[pointer.link].articulation] = 0;
  }
}

void countCalmOver(const Model& model, const Island& island, int steps, const Placement& placement, State& state) noexcept {
  const double most = restingSpeed(model.settings, model.settings.step);
  for (int n = 0; n < island.tree_count; ++n) {
    int& calm = state.calm[island.trees[n]];
    calm = isSlow(model, model.trees[island.trees[n]], most, placement) ? std::min(calm + steps, kCalmSteps) : 0;
  }
}

}  // namespace haptic::stepping
