#include "haptic_core/stepping/implicit_islands.h"

#include <algorithm>

#include "haptic_core/stepping/explicit_contacts.h"
#include "haptic_core/stepping/explicit_step.h"
#include "haptic_core/stepping/island_solve.h"
#include "haptic_core/stepping/own_rate.h"
#include "haptic_core/stepping/turns.h"
#include "haptic_core/stepping/turns_ahead.h"
#include "haptic_core/world/applied_wrench.h"
#include "haptic_core/world/link_forces.h"
#include "haptic_core/world/stability_number.h"

namespace haptic::stepping {
namespace {

/// Contacts of an island as its solve left them.
struct Contacts {
  const ImplicitContact *first, *last;
  const ImplicitContact* begin() const { return first; }
  const ImplicitContact* end() const { return last; }
};

/// Hands the virtual couplings to the solve.
void aimCouplings(const Model& model, const State& state, Work& work) noexcept {
  for (std::size_t i = 0; i < state.pointers.size(); ++i) {
    const PointerState& pointer = state.pointers[i];
    ImplicitCoupling& coupling = work.implicit->stage.forces.couplings[i];
    coupling.link = !model.holds(static_cast<int>(i)) && pointer.targeted ? pointer.link : -1;
    if (coupling.link < 0) continue;
    coupling.law = work.hands.coupling[i];
    coupling.X_WL = Pose(work.hands.goal[i].q_WL, work.hands.goal[i].p_WL);
    coupling.V_WL = work.hands.goal[i].V_WL;
    coupling.F_W = Wrench{};
  }
}

void takeCouplings(const Model& model, const StepPart& part, State& state, Work& work) noexcept {
  for (std::size_t i = 0; i < state.pointers.size(); ++i) {
    const ImplicitCoupling& coupling = work.implicit->stage.forces.couplings[i];
    if (coupling.link < 0 || state.mode[model.links[coupling.link].articulation] < TreeMode::kImplicit) continue;
    work.hands.wrench[i] += -(meanCoupling(work.implicit->books, static_cast<int>(i)) * part.share);
    state.energy.external += work.implicit->books.coupling_work[i];
  }
}

/// Wrenches of the island's force elements on its links, or on those that hands hold.
void takeForces(const Model& model, const Island& island, bool to_held, Work& work) noexcept {
  LinkWork* link = work.placement.link.data();
  const auto moves = [&](int tree) { return work.hands.movesByItself(model.trees[tree]); };
  eachForce(model, TreeRange{island.trees, island.tree_count}, moves, [&](int, const ModelForce& force) {
    const auto takes = [&](int tree) { return tree >= 0 && moves(tree) != to_held; };
    addForce(forceNow(model, force, link), takes(force.tree_a) ? link + force.link_a : nullptr,
             takes(force.tree_b) ? link + force.link_b : nullptr);
  });
}

/// Highest stability number of the island's links.
double stabilityOf(const Model& model, const Island& island, const Contacts& contacts, State& state, Work& work) noexcept {
  std::vector<double>& number = work.choice.number;
  const auto forEachLink = [&](auto&& visit) {
    for (int n = 0; n < island.tree_count; ++n) {
      const ModelTree& tree = model.trees[island.trees[n]];
      for (int l = 0; l < tree.model->linkCount(); ++l) visit(tree.link + l);
    }
  };
  forEachLink([&](int link) { number[link] = couplingNumber(model, state, work, link); });
  countForces(model, {island.trees, island.tree_count}, true, state, work);
  for (const ImplicitContact& c : contacts) {
    addStability(model, c.volume, c.force.tangent, c.X_WP, work, state.pairs[c.pair]);
  }
  double most = 0;
  forEachLink([&](int link) { most = std::max(most, number[link]); });
  return most;
}

/// What these contacts take in the first half kick of explicit steps.
void foreseeKick(const Model& model, const Contacts& contacts, double h, State& state, Work& work) noexcept {
  work.contacts.booked.clear();
  for (const ImplicitContact& c : contacts) {
    BookedContact booked;
    booked.pair = c.pair;
    booked.X_WP = c.X_WP;
    booked.F_BP_P = c.force.F_BP_P;
    booked.elastic_P = c.force.elastic();
    work.contacts.booked.push_back(booked);
  }
  noteNextKick(model, h, state, work);
}

/// Back to explicit steps where the numbers have been low for long enough, with what those need to know of the last step.
void lookForExplicit(const Model& model, const Island& island, double h, bool flew, State& state, Work& work) noexcept {
  const LoadedVector<ImplicitContact>& solved = work.implicit->stage.contacts.all();
  const Contacts contacts{solved.begin(), flew ? solved.begin() : solved.end()};
  const bool low = stabilityOf(model, island, contacts, state, work) < kLeaveImplicit * kStabilityBound;
  int steps = kDwell;
  for (int n = 0; n < island.tree_count; ++n) steps = std::min(steps, state.low[island.trees[n]] + 1);
  for (int n = 0; n < island.tree_count; ++n) state.low[island.trees[n]] = low ? steps : 0;
  if (!low || steps < kDwell) return;
  Placement& placement = work.placement;
  for (const ImplicitContact& c : contacts) {
    const LinkWork &A = placement.link[model.shapes[c.shape_a].link], &B = placement.link[model.shapes[c.shape_b].link];
    const Twist V_W = B.twistAt(c.X_WP.p) - A.twistAt(c.X_WP.p);
    state.pairs[c.pair].release = releaseOf(c.volume, V_W.rotated(c.X_WP.R.transpose()), c.X_WP, c.force);
  }
  for (const ImplicitCoupling& coupling : work.implicit->stage.forces.couplings) {
    if (flew || coupling.link < 0) continue;
    if (work.islands.of(model.links[coupling.link].articulation) != work.islands.of(island.trees[0])) continue;
    placement.link[coupling.link].addWrench(coupling.F_W, placement.link[coupling.link].X_WL.p);
  }
  work.contacts.has_kick = false;
  takeForces(model, island, false, work);
  for (int n = 0; n < island.tree_count; ++n) {
    addWrenches(model, state, island.trees[n], placement.link.data());
    keepPull(model, model.trees[island.trees[n]], state, work);
    state.mode[island.trees[n]] = TreeMode::kPrimed;
    state.low[island.trees[n]] = 0;
    state.last_step[island.trees[n]] = 0;
  }
  if (model.settings.energy_ledger && contacts.begin() != contacts.end()) foreseeKick(model, contacts, h, state, work);
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

void stepImplicitIslands(const Model& model, const StepPart& part, State& state, Work& work, Report& report) noexcept {
  ImplicitWork& implicit = *work.implicit;
  const bool may_stand = model.settings.leave_out && part.h == model.settings.step;
  bool begun = false;
  report.step.standing = report.step.waiting = 0;
  takeTurns(model, may_stand && model.turn_steps > 1, state, work, report);
  work.islands.find(state, work.visits.trees, work.hands.held_by, true);
  double reserved = reservedForAll(model, state, work);
  for (int i = 0; i < work.islands.count(); ++i) {
    const Island island = work.islands[i];
    ++report.step.implicit_islands;
    if (waits(model, island, state)) {
      const bool told = work.standing.holds(island.trees[0]);  // it has had its turn now
      if (!told && work.standing.repeats(model, island, state)) work.standing.repeat(island, report);
      if (!told && !work.standing.holds(island.trees[0])) work.standing.note(island, report.contacts.size(), report);
      work.asleep.note(island);
      report.step.waiting += island.tree_count;
      continue;
    }
    if (may_stand && work.standing.repeats(model, island, state)) {
      work.standing.repeat(island, report);
      work.asleep.note(island);
      report.step.standing += island.tree_count;
      continue;
    }
    if (!begun) {
      aimCouplings(model, state, work);
      beginIslands(model, state, work.visits.trees, work.hands, work.contacts.seams, part.h, implicit);
    }
    begun = true;
    const int first_contact = report.contacts.size();
    if (work.counted.bounded()) reserved -= reservedFor(model, island, state);
    const ImplicitReport* solved = solveIsland(model, island, part.h, work.counted.left() - reserved, state, work, report.step);
    if (solved && solved->rests && model.settings.energy_ledger) bookRest(model, island, work.placement, state.energy);
    for (int n = 0; n < island.tree_count; ++n) placeTree(model.trees[island.trees[n]], state, work.placement);
    if (solved) takeContacts(model, part.h, state, work, report);
    takeForces(model, island, true, work);
    const bool stands = solved && solved->stands && standsAlone(model, island, state);
    if (stands) report.step.standing += island.tree_count;
    const bool leaves = !stands && may_stand && isCommonTurn(model, state) && mayWait(model, island, state, work.placement);
    const bool looks = model.explicit_steps && !stands && !leaves;  // what stands costs nothing as it is
    if (looks) lookForExplicit(model, island, part.h, !solved, state, work);
    if (may_stand && stands) work.standing.note(island, first_contact, report);
    if (!leaves) continue;
    wait(island, state.step + 1, firstTurn(model, state, work.rates.load), state);
    if (work.ahead) work.ahead->give(island, state);
    work.standing.note(island, first_contact, report);
    work.asleep.note(island);
    report.step.waiting += island.tree_count;
  }
  if (!begun) return;
  report.step.closure = std::max(report.step.closure, implicit.stage.joints.closure(work.placement.link.data()));
  takeCouplings(model, part, state, work);
}

}  // namespace haptic::stepping
