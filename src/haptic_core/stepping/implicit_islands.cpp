#include "haptic_core/stepping/implicit_islands.h"

#include <algorithm>

#include "haptic_core/stepping/explicit_contacts.h"
#include "haptic_core/stepping/explicit_step.h"
#include "haptic_core/stepping/own_rate.h"
#include "haptic_core/world/applied_wrench.h"
#include "haptic_core/world/link_forces.h"
#include "haptic_core/world/stability_number.h"

namespace haptic::stepping {
namespace {

ImplicitOrder orderOf(Attempts attempts) noexcept {
  return attempts == Attempts::kImplicitEuler ? ImplicitOrder::kFirst
         : attempts == Attempts::kSdirk2      ? ImplicitOrder::kSecond
                                              : ImplicitOrder::kSecondMultistep;
}

/// Contacts of an island as its solve left them.
struct Contacts {
  const ImplicitContact *first, *last;
  const ImplicitContact* begin() const { return first; }
  const ImplicitContact* end() const { return last; }
};

/// A body that touches nothing and that no hand and no force element pulls moves as explicit steps move it: exactly.
bool fliesFreely(const Model& model, const Island& island, const State& state) noexcept {
  if (island.pair_count > 0 || island.tree_count > 1) return false;
  const ModelTree& tree = model.trees[island.trees[0]];
  if (!model.isFree(tree) || hasForces(model, island.trees[0])) return false;
  for (std::size_t p = 0; p < state.pointers.size(); ++p) {
    const PointerState& pointer = state.pointers[p];
    if (!model.holds(static_cast<int>(p)) && pointer.targeted && pointer.link == tree.link) return false;
  }
  return true;
}

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
    if (coupling.link < 0 || state.mode[model.links[coupling.link].articulation] != TreeMode::kImplicit) continue;
    work.hands.wrench[i] += -(meanCoupling(work.implicit->books, static_cast<int>(i)) * part.share);
    state.energy.external += work.implicit->books.coupling_work[i];
  }
}

/// A contact that began: its bodies approached at the speed that its impulse took from them.
void noteImpact(const Model& model, const ContactReport& contact, double h, const Work& work, Report& report) noexcept {
  const LinkWork &A = work.placement.link[contact.link_a], &B = work.placement.link[contact.link_b];
  const double mass = model.law(contact.shape_a, contact.shape_b, false, false).reduced_mass,
               left = (A.twistAt(contact.X_WP.p) - B.twistAt(contact.X_WP.p)).linear.dot(contact.X_WP.R.col(2));
  report.addImpact(left + h * contact.normal_force / mass, mass, h * model.settings.gravity.norm());
}

/// Wrenches of the island's contacts on its links (and on those that hands hold), and their reports.
void takeContacts(const Model& model, double h, State& state, Work& work, Report& report) noexcept {
  for (const ImplicitContact& c : work.implicit->stage.contacts.all()) {
    ActivePair& pair = state.pairs[c.pair];
    ContactReport contact = reportOf(model, pair, c.volume, c.X_WP, c.force);
    contact.sticking = pair.friction.sliding == 0;
    contact.event = work.implicit->books.event[c.pair];
    // A step that follows explicitly takes up from the force at the end; hands and readers are told the mean of the step.
    const Wrench at_end = contact.F_BP_W, mean = meanWrench(work.implicit->books, c);
    for (const int link : {contact.link_a, contact.link_b}) {
      const Wrench& F_W = work.hands.held_by[link] >= 0 ? mean : at_end;
      work.placement.link[link].addWrench(link == contact.link_b ? F_W : -F_W, c.X_WP.p);
    }
    contact.F_BP_W = mean;
    contact.normal_force = mean.force.dot(c.X_WP.R.col(2));
    if (pair.friction.began != 0) noteImpact(model, contact, h, work, report);
    if (pair.buried) pair.buried = !(c.volume.depth < model.buriedDepth(c.shape_a, c.shape_b, c.volume.A0));
    report.addContact(contact, c.force.clipped);
  }
  eachParted(work.implicit->stage, work.implicit->books, [&](int index, const Pose& X_WP, const Wrench& mean) {
    ContactReport contact = reportOf(model, state.pairs[index], ContactVolume{}, X_WP, LocatedForce{});
    contact.F_BP_W = mean;
    contact.normal_force = mean.force.dot(X_WP.R.col(2));
    if (state.pairs[index].friction.began != 0) noteImpact(model, contact, h, work, report);
    for (const int link : {contact.link_a, contact.link_b}) {
      if (work.hands.held_by[link] < 0) continue;
      work.placement.link[link].addWrench(link == contact.link_b ? mean : -mean, X_WP.p);
    }
    report.addContact(contact, false);
  });
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

/// What moved in an island that is brought to rest is lost; the placement has its velocities still.
void bookRest(const Model& model, const Island& island, const Placement& placement, EnergySums& energy) noexcept {
  double kinetic = 0;
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model.trees[island.trees[n]];
    kinetic += kineticEnergy(*tree.model, placement.link.data() + tree.link);
  }
  energy.damping += kinetic;
  energy.stilled += kinetic;
}

/// Share of a step's budget that turns of far islands may take: the rest is for what is near. More: near islands do without second
/// attempts beside a tumbling crowd; less: the crowd waits while there is time.
constexpr double kFarShare = 0.5;

/// Null: nothing but gravity and wrenches acted on the island, and no contact was looked at. `most`: of the step's budget [units].
const ImplicitReport* solve(const Model& model, const Island& island, double h, double most, State& state, Work& work,
                            StepReport& report) noexcept {
  if (fliesFreely(model, island, state)) {
    fly(model, island.trees[0], h, state, work);
    work.counted.done += units::kLink;
    state.last_step[island.trees[0]] = 0;
    return nullptr;
  }
  const ImplicitReport& solved = advanceIsland(model, island, h, orderOf(model.settings.attempts), most, state, *work.implicit);
  if (!solved.stands) work.counted.done += solved.units;
  work.counted.gave_way |= solved.cut && !solved.stands;
  report.iterations = std::max(report.iterations, solved.iterations);
  report.evaluations = std::max(report.evaluations, solved.evaluations);
  report.factorisations = std::max(report.factorisations, solved.factorisations);
  if (!solved.stands || !standsAlone(model, island, state)) {  // else nothing of it goes into a motion
    report.wrench_error = std::max(report.wrench_error, solved.wrench_error);
    report.residual = std::max(report.residual, solved.residual);
  }
  report.fallbacks += solved.fell_back;
  report.parts = std::max(report.parts, solved.parts);
  report.budget_used = std::max(report.budget_used, solved.budget_used);
  work.choice.position_error = std::max(work.choice.position_error, solved.position_error);
  if (!solved.converged) report.flags |= kNotConverged;
  if (!solved.joints_converged) report.flags |= kJointsNotConverged;
  return &solved;
}

/// Every velocity is zero, as of all that stands.
bool isStill(const Model& model, const Island& island, const State& state) noexcept {
  return std::all_of(island.trees, island.trees + island.tree_count, [&](int t) {
    const double* v = state.v.data() + model.trees[t].v;
    return std::all_of(v, v + model.trees[t].model->nv(), [](double x) { return x == 0; });
  });
}

/// What islands that move keep of a step's budget, whatever those before them take: as many evaluations as a smooth step of second order.
double reservedFor(const Model& model, const Island& island, const State& state) noexcept {
  constexpr int kReserved = 4;
  return isStill(model, island, state) ? 0 : kReserved * evaluationUnits(model, island, state);
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

/// An island whose turn has come goes over the time that it is late. `goes_on`: it may wait again, and then its contacts are reported.
void takeTurn(const Model& model, const Island& island, double late, bool goes_on, State& state, Work& work, Report& report) noexcept {
  const int first_contact = report.contacts.size();
  const ImplicitReport* solved = late > 0 ? solve(model, island, late, kFarShare * work.counted.left(), state, work, report.step) : nullptr;
  if (solved && solved->rests && model.settings.energy_ledger) bookRest(model, island, work.placement, state.energy);
  for (int n = 0; n < island.tree_count; ++n) {
    placeTree(model.trees[island.trees[n]], state, work.placement);
    work.standing.drop(island.trees[n]);
  }
  countCalm(model, island, static_cast<int>(state.step - state.as_of[island.trees[0]]), work.placement, state);
  wait(island, 0, 0, state);
  if (!goes_on || (solved && solved->stands) || !mayWait(model, island, state, work.placement)) return;
  if (solved) takeContacts(model, late, state, work, report);
  work.standing.note(island, first_contact, report);
  wait(island, state.step, state.step + static_cast<std::uint64_t>(model.turn_steps), state);
}

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

}  // namespace

void takeTurns(const Model& model, bool may_wait, State& state, Work& work, Report& report) noexcept {
  const std::vector<int>& trees = work.visits.trees;
  if (std::none_of(trees.begin(), trees.end(), [&](int t) { return state.turn[t] != 0; })) return;
  std::vector<char>& alone = work.rates.alone;
  work.islands.find(state, trees, work.hands.held_by, true);
  for (int i = 0; i < work.islands.count(); ++i) {
    const Island island = work.islands[i];
    if (waits(model, island, state)) continue;
    const auto same = [&](int t) {
      return isDue(state, t) && state.as_of[t] == state.as_of[island.trees[0]] && state.turn[t] == state.turn[island.trees[0]];
    };
    const bool goes_on = may_wait && std::all_of(island.trees, island.trees + island.tree_count, same);
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
    beginIslands(model, state, trees, work.hands, work.contacts.seams, late, *work.implicit);
    work.islands.findDue(state, trees, as_of);
    for (int i = 0; i < work.islands.count(); ++i) {
      const Island island = work.islands[i];
      const bool goes_on = alone[island.trees[0]] != 0;
      if (goes_on && any && waitsOn(model, island, state, work)) continue;
      takeTurn(model, island, late, goes_on, state, work, report);
      any = true;
    }
  }
}

void bringToPresent(const Model& model, State& state, Work& work, Report& report) noexcept {
  bool any = false;
  for (std::uint64_t& turn : state.turn) {
    if (turn == 0) continue;
    turn = std::min(turn, state.step);
    any = true;
  }
  if (any) takeTurns(model, false, state, work, report);
}

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
    const ImplicitReport* solved = solve(model, island, part.h, work.counted.left() - reserved, state, work, report.step);
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
    work.standing.note(island, first_contact, report);
    work.asleep.note(island);
    report.step.waiting += island.tree_count;
  }
  if (!begun) return;
  report.step.closure = std::max(report.step.closure, implicit.stage.joints.closure(work.placement.link.data()));
  takeCouplings(model, part, state, work);
}

}  // namespace haptic::stepping
