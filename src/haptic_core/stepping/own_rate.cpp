#include "haptic_core/stepping/own_rate.h"

#include <algorithm>

#include "haptic_core/stepping/span.h"
#include "haptic_core/stepping/rest.h"
#include "haptic_core/world/applied_wrench.h"

namespace haptic::stepping {
namespace {

/// No body of the island passes in `seconds` so far that it may miss something thin: another of them, or what never moves. All else that
/// comes near brings them to the present.
bool staysInSight(const Model& model, const Island& island, double seconds, const Placement& placement) noexcept {
  double width = model.fixed_width;
  for (int n = 0; n < island.tree_count; ++n) width = std::min(width, model.own_width[model.trees[island.trees[n]].link]);
  const double way = kShareOfWidth * width, fall = seconds * model.settings.gravity.norm();
  return std::all_of(island.trees, island.trees + island.tree_count, [&](int t) {
    const int l = model.trees[t].link;
    const LinkWork& link = placement.link[l];
    const double speed = link.velocity.norm() + fall, turn = model.links[l].size * link.omega.norm();
    return 2 * seconds * seconds * (speed * speed + turn * turn) <= way * way;
  });
}

}  // namespace

bool isOfOneTurn(const Island& island, const State& state) noexcept {
  const int first = island.trees[0];
  return std::all_of(island.trees, island.trees + island.tree_count,
                     [&](int t) { return state.turn[t] == state.turn[first] && state.as_of[t] == state.as_of[first]; });
}

bool waits(const Model& model, const Island& island, const State& state) noexcept {
  if (model.turn_steps <= 1 || state.turn[island.trees[0]] <= state.step) return false;
  return isOfOneTurn(island, state) && standsAlone(model, island, state);
}

bool mayWait(const Model& model, const Island& island, const State& state, const Placement& placement) noexcept {
  const double longest = 2 * model.turn_steps * model.settings.step;
  for (int n = 0; n < island.tree_count; ++n) {
    const int t = island.trees[n];
    if (!model.isFree(model.trees[t]) || anyWrench(model, state, t)) return false;
  }
  return staysInSight(model, island, longest, placement) && standsAlone(model, island, state);
}

void wait(const Island& island, std::uint64_t as_of, std::uint64_t turn, State& state) noexcept {
  for (int n = 0; n < island.tree_count; ++n) {
    state.as_of[island.trees[n]] = as_of;
    state.turn[island.trees[n]] = turn;
  }
}

std::uint64_t firstTurn(const Model& model, const State& state, std::vector<int>& load) noexcept {
  const auto steps = static_cast<std::uint64_t>(model.turn_steps);
  std::fill(load.begin(), load.end(), 0);
  for (const std::uint64_t turn : state.turn) {
    if (turn != 0) ++load[turn % steps];
  }
  std::uint64_t best = state.step + 2;  // it is left out for one step at least
  for (std::uint64_t turn = best; turn <= state.step + 1 + steps; ++turn) {
    if (load[turn % steps] < load[best % steps]) best = turn;
  }
  return best;
}

double lagOf(const Model& model, const State& state) noexcept {
  std::uint64_t oldest = state.step + 1;  // the step has been taken, and is counted after this
  for (std::size_t t = 0; t < state.turn.size(); ++t) {
    if (state.turn[t] != 0) oldest = std::min(oldest, state.as_of[t]);
  }
  return static_cast<double>(state.step + 1 - oldest) * model.settings.step;
}

double foreseen(const Model& model, const State& state, int tree, double h) noexcept {
  if (model.turn_steps <= 1) return h;
  const std::uint64_t turn = state.turn[tree];
  const double on = model.turn_steps * model.settings.step;
  // What stands goes nowhere: it is found by whatever comes, left out or not.
  if (turn == 0) return isCommonTurn(model, state) && !isStill(model, tree, state) ? h + on : h;
  const double until = std::max(0.0, static_cast<double>(turn) - static_cast<double>(state.as_of[tree])) * model.settings.step;
  return turn > state.step ? until : until + std::max(h, on);
}

}  // namespace haptic::stepping
