#include "haptic_core/stepping/turns.h"

#include <algorithm>

#include "haptic_core/stepping/island_solve.h"
#include "haptic_core/stepping/own_rate.h"
#include "haptic_core/stepping/rest.h"

namespace haptic::stepping {
namespace {

/// Share of a step's budget that turns of far islands may take: the rest is for what is near. More: near islands do without second
/// attempts beside a tumbling crowd; less: the crowd waits while there is time.
constexpr double kFarShare = 0.5;

/// True: the island, whose turn it is, waits one step more, for those before it leave no room for it in the share of the budget.
bool waitsOn(const Model& model, const Island& island, State& state, Work& work) noexcept {
  if (!work.counted.bounded()) return false;
  constexpr int kEvaluations = 2;  // most turns go on as before
  const std::uint64_t as_of = state.as_of[island.trees[0]], latest = as_of + 2 * static_cast<std::uint64_t>(model.turn_steps);
  const double after = work.counted.done + kEvaluations * evaluationUnits(model, island, state);
  if (after <= kFarShare * work.counted.most || state.step >= latest || !standsAlone(model, island, state)) return false;
  work.counted.gave_way = true;
  wait(island, as_of, state.step + 1, state);
  return true;
}

/// The island is where its turn left it, and waits no longer.
void endTurn(const Model& model, const Island& island, State& state, Work& work) noexcept {
  for (int n = 0; n < island.tree_count; ++n) {
    placeTree(model.trees[island.trees[n]], state, work.placement);
  }
  wait(island, 0, 0, state);
}

/// An island whose turn has come goes over the time that it is `late` [s]. `goes_on`: it may wait again, and where it
/// does its contacts are reported. `most`: of the step's budget [units].
void takeTurn(const Model& model, const Island& island, double late, bool goes_on, double most, State& state, Work& work,
              StepReport& report) noexcept {
  const ImplicitReport* solved = late > 0 ? solveIsland(model, island, late, most, state, work, report) : nullptr;
  if (solved && solved->rests && model.settings.energy_ledger) bookRest(model, island, work.placement, state.energy);
  const int steps = static_cast<int>(state.step - state.as_of[island.trees[0]]);
  endTurn(model, island, state, work);
  countCalmOver(model, island, steps, work.placement, state);
  if (!goes_on || (solved && solved->stands) || !mayWait(model, island, state, work.placement)) return;
  if (late > 0) takeContacts(model, island, solved, late, state, work, report);
  wait(island, state.step, state.step + static_cast<std::uint64_t>(model.turn_steps), state);
  work.activity.leave(island, state, work.visits);
}

}  // namespace

void takeTurns(const Model& model, bool may_wait, State& state, Work& work, StepReport& report) noexcept {
  const std::vector<int>& trees = work.visits.trees;
  if (std::none_of(trees.begin(), trees.end(), [&](int t) { return state.turn[t] != 0; })) return;
  std::vector<char>& alone = work.rates.alone;
  work.islands.find(state, trees, work.hands.held_by);
  for (int i = 0; i < work.islands.count(); ++i) {
    const Island island = work.islands[i];
    if (waits(model, island, state)) continue;
    const bool goes_on = may_wait && isDue(state, island.trees[0]) && isOfOneTurn(island, state) && standsAlone(model, island, state);
    for (int n = 0; n < island.tree_count; ++n) {
      const int t = island.trees[n];
      alone[t] = goes_on;
      if (state.turn[t] != 0) state.turn[t] = std::min(state.turn[t], state.step);
    }
  }
  bool any = false;  // one has its turn in any case: what is never taken would all be taken when it can wait no longer
  for (;;) {  // by age, the oldest first; each takes its trees off the list
    std::uint64_t as_of = state.step + 1;
    for (const int t : trees) {
      if (isDue(state, t)) as_of = std::min(as_of, state.as_of[t]);
    }
    if (as_of > state.step) return;
    const double late = static_cast<double>(state.step - as_of) * model.settings.step;
    for (ImplicitCoupling& coupling : work.implicit->stage.forces.couplings) coupling.link = -1;
    work.implicit->begun = false;
    work.islands.findDue(state, trees, as_of);
    for (int i = 0; i < work.islands.count(); ++i) {
      const Island island = work.islands[i];
      const bool goes_on = alone[island.trees[0]] != 0;
      if (goes_on && any && waitsOn(model, island, state, work)) continue;
      const double most = kFarShare * work.counted.left();
      takeTurn(model, island, late, goes_on, most, state, work, report);
      any = true;
    }
  }
}

void bringToPresent(const Model& model, State& state, Work& work, StepReport& report) noexcept {
  bool any = false;
  for (std::uint64_t& turn : state.turn) {
    if (turn == 0) continue;
    turn = std::min(turn, state.step);
    any = true;
  }
  if (any) takeTurns(model, false, state, work, report);
}

}  // namespace haptic::stepping
