#include "haptic_core/stepping/implicit_islands.h"

#include <algorithm>

#include "haptic_core/stepping/island_solve.h"
#include "haptic_core/stepping/own_rate.h"
#include "haptic_core/stepping/rest.h"
#include "haptic_core/stepping/turns.h"
#include "haptic_core/world/applied_wrench.h"

namespace haptic::stepping {
namespace {

/// Hands the virtual couplings to the solve.
void aimCouplings(const Model& model, const State& state, Work& work) noexcept {
  for (std::size_t i = 0; i < state.pointers.size(); ++i) {
    const PointerState& pointer = state.pointers[i];
    ImplicitCoupling& coupling = work.implicit->stage.forces.couplings[i];
    coupling.link = !model.holds(static_cast<int>(i)) && pointer.targeted ? pointer.link : -1;
    if (coupling.link < 0) continue;
    coupling.law = work.hands.coupling[i];
    coupling.X_LP = model.pointerFrame(static_cast<int>(i), pointer.link);
    coupling.target = work.hands.goal[i];
    coupling.F_W = Wrench{};
  }
}

void takeCouplings(State& state, Work& work) noexcept {
  for (std::size_t i = 0; i < state.pointers.size(); ++i) {
    const ImplicitCoupling& coupling = work.implicit->stage.forces.couplings[i];
    if (coupling.link < 0) continue;
    work.hands.wrench[i] += -meanCoupling(work.implicit->books, static_cast<int>(i));
    state.energy.external += work.implicit->books.coupling_work[i];
  }
}

/// What islands that move keep of a step's budget, whatever those before them take: as many evaluations as a smooth step of second order.
double reservedFor(const Model& model, const Island& island, const State& state) noexcept {
  constexpr int kReserved = 4;
  const bool still = std::all_of(island.trees, island.trees + island.tree_count, [&](int t) { return isStill(model, t, state); });
  return still ? 0 : kReserved * evaluationUnits(model, island, state);
}

/// The same of all islands of the step but those that wait; without a budget it does not matter.
double reservedForAll(const Model& model, const State& state, const Work& work) noexcept {
  double units = 0;
  for (int i = 0; work.counted.bounded() && i < work.islands.count(); ++i) {
    const Island island = work.islands[i];
    if (!waits(model, island, state)) units += reservedFor(model, island, state);
  }
  return units;
}

}  // namespace

void stepImplicitIslands(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept {
  ImplicitWork& implicit = *work.implicit;
  const bool may_stand = model.settings.leave_out;
  report.standing = report.waiting = 0;
  takeTurns(model, may_stand && model.turn_steps > 1, state, work, report);
  work.islands.find(state, work.visits.trees, work.hands.held_by);
  double reserved = reservedForAll(model, state, work);
  aimCouplings(model, state, work);
  implicit.begun = false;
  for (int i = 0; i < work.islands.count(); ++i) {
    const Island island = work.islands[i];
    ++report.implicit_islands;
    if (waits(model, island, state)) {
      const bool told = work.visits.phase[island.trees[0]] != Phase::kMoves;  // it has had its turn now
      if (!told) work.activity.leave(island, state, work.visits);
      report.waiting += island.tree_count;
      continue;
    }
    if (work.counted.bounded()) reserved -= reservedFor(model, island, state);
    const ImplicitReport* solved = solveIsland(model, island, h, work.counted.left() - reserved, state, work, report);
    if (solved && solved->rests && model.settings.energy_ledger) bookRest(model, island, work.placement, state.energy);
    for (int n = 0; n < island.tree_count; ++n) placeTree(model.trees[island.trees[n]], state, work.placement);
    takeContacts(model, island, solved, h, state, work, report);
    const bool stands = solved && solved->stands && standsAlone(model, island, state);
    if (stands) report.standing += island.tree_count;
    const bool leaves = !stands && may_stand && isCommonTurn(model, state) && mayWait(model, island, state, work.placement);
    if (leaves) wait(island, state.step + 1, firstTurn(model, state, work.rates.load), state);
    if (leaves) report.waiting += island.tree_count;
    if (leaves || (may_stand && stands)) work.activity.leave(island, state, work.visits);
  }
  if (!implicit.begun) return;
  report.addGap(implicit.stage.joints.closure(work.placement.link.data()));
  takeCouplings(state, work);
}

}  // namespace haptic::stepping
