#include "haptic_core/stepping/retreat.h"

#include <algorithm>

#include "haptic_core/world/work.h"

namespace haptic::stepping {
namespace {

/// Calls visit(numbers of the state, numbers of the retreat, count) for each row of a tree that a step changes.
template <class AState, class ARetreat, class Visit>
void eachKept(const ModelTree& tree, int t, AState& state, ARetreat& retreat, Visit&& visit) noexcept {
  const auto row = [&](auto& of_state, auto& kept, int first, int count) { visit(of_state.data() + first, kept.data() + first, count); };
  const int nv = tree.model->nv();
  row(state.q, retreat.q, tree.q, tree.model->nq());
  row(state.v, retreat.v, tree.v, nv);
  row(state.pull, retreat.pull, tree.v, nv);
  row(state.a_end, retreat.a_end, tree.v, nv);
  row(state.a_mean, retreat.a_mean, tree.v, nv);
  row(state.v_mean, retreat.v_mean, tree.v, nv);
  row(state.last_step, retreat.last_step, t, 1);
  row(state.mode, retreat.mode, t, 1);
}

}  // namespace

Retreat::Retreat(const Model& model)
    : q(model.nq), v(model.nv), pull(model.nv), a_end(model.nv), a_mean(model.nv), v_mean(model.nv), last_step(model.trees.size()),
      mode(model.trees.size()), wrench(model.pointers.size()) {}

void keepForRetreat(const ModelTree& tree, int t, const State& state, Retreat& retreat) noexcept {
  eachKept(tree, t, state, retreat, [](const auto* of_state, auto* kept, int count) { std::copy_n(of_state, count, kept); });
}

void keepForRetreat(const Model& model, const Visits& visits, const State& state, const HandWork& hands, const StepReport& report,
                    Retreat& retreat) noexcept {
  for (const int t : visits.trees) keepForRetreat(model.trees[t], t, state, retreat);
  retreat.wrench = hands.wrench;
  retreat.energy = state.energy;
  retreat.pair_count = state.pair_count;
  retreat.flags = report.flags;
}

void takeBack(const Model& model, State& state, Work& work, StepReport& report) noexcept {
  const Retreat& retreat = work.retreat;
  for (const int t : work.visits.trees) {
    eachKept(model.trees[t], t, state, retreat, [](auto* of_state, const auto* kept, int count) { std::copy_n(kept, count, of_state); });
  }
  state.energy = retreat.energy;
  work.hands.wrench = retreat.wrench;
  work.position_error = 0;
  std::swap(work.search.previous, state.pairs);  // the search has swapped them once
  state.pair_count = retreat.pair_count;
  report.flags = retreat.flags;
  report.impact = 0;
  placeTrees(model, work.visits.trees, state, work.placement);
}

}  // namespace haptic::stepping
