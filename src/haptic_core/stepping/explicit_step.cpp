#include "haptic_core/stepping/explicit_step.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/dynamics/free_body.h"
#include "haptic_core/dynamics/runge_kutta.h"
#include "haptic_core/stepping/explicit_contacts.h"
#include "haptic_core/world/applied_wrench.h"
#include "haptic_core/world/link_forces.h"

namespace haptic::stepping {
namespace {

/// Kinematics of the trees in hands, which startVerlet does not move.
void placeHeldTrees(const Model& model, const State& state, Work& work) noexcept {
  for (const int t : work.visits.trees) {
    if (!work.hands.movesByItself(model.trees[t])) placeTree(model.trees[t], state, work.placement);
  }
}

/// A tree in the arrays of state and work. `half`: v½ by world velocity index, or null.
SteppedTree inPlace(const Model& model, const ModelTree& tree, double* half, State& state, Work& work) noexcept {
  SteppedTree stepped;
  stepped.model = tree.model.get();
  stepped.motion = work.joints[model.indexOf(tree)].get();
  stepped.commands = state.commands.data() + tree.command;
  stepped.q = state.q.data() + tree.q;
  stepped.v = state.v.data() + tree.v;
  stepped.pull = state.pull.data() + tree.v;
  stepped.half = half ? half + tree.v : nullptr;
  stepped.work = work.placement.link.data() + tree.link;
  return stepped;
}

void book(const JointReport* joints, State& state, StepReport& report) noexcept {
  if (!joints) return;
  state.energy.damping += joints->damping;
  state.energy.friction += joints->friction;
  state.energy.external += joints->drives;
  report.closure = std::max(report.closure, joints->closure);
  if (!joints->converged) report.flags |= kJointsNotConverged;
}

/// The velocities after the next half kick.
void lookAhead(const Model& model, double h, State& state, Work& work) noexcept {
  std::vector<double>& v_ahead = work.motion.v_ahead;
  std::copy(state.v.begin(), state.v.end(), v_ahead.begin());
  for (const ModelTree* tree : work.hands.movers) {
    if (tree->has_laws) continue;
    SteppedTree ahead = inPlace(model, *tree, nullptr, state, work);
    ahead.v = v_ahead.data() + tree->v;
    kick(ahead, h / 2);
  }
}

/// Contacts and pulls here and now, of a part or, with time 0, of the first one's start.
void evaluate(const Model& model, const StepPart& part, bool advances, State& state, Work& work, Report& report) noexcept {
  work.clock.end(report.step.stages.motion);
  lookForPairs(model, 0, state, work, report.step);
  evaluateContacts(model, {advances ? part.h : 0, true}, state, work, report);
  pullCoupled(model, part, advances, state, work.hands, work.placement);
  if (!model.forces.empty()) pullExplicit(model, work.visits, work.hands, work.placement);
  pushExplicit(state, work.hands, work.placement);
}

/// What pulls at trees whose last step was not one of velocity Verlet.
void prime(const Model& model, const StepPart& part, State& state, Work& work, Report& report) noexcept {
  const auto unprimed = [&](const ModelTree* tree) { return state.mode[model.indexOf(*tree)] == TreeMode::kUnprimed; };
  const std::vector<const ModelTree*>& movers = work.hands.movers;
  if (std::none_of(movers.begin(), movers.end(), unprimed)) return;
  placeTrees(model, work.visits.trees, state, work.placement);
  for (const ModelTree* tree : movers) work.counted.done += units::kLink * tree->model->linkCount();
  evaluate(model, part, false, state, work, report);
  for (const ModelTree* tree : movers) {
    if (!unprimed(tree)) continue;
    keepPull(model, *tree, state, work);
    state.mode[model.indexOf(*tree)] = TreeMode::kPrimed;
  }
  if (!model.settings.energy_ledger) return;
  lookAhead(model, part.h, state, work);
  notePowers(work.ledgerView(model), part.h, work.motion.v_ahead, work.contacts.booked, state);
}

}  // namespace

void velocityVerlet(const Model& model, const StepPart& part, State& state, Work& work, Report& report) noexcept {
  prime(model, part, state, work, report);
  const double h = part.h;
  const Vector3& gravity = model.settings.gravity;
  double* v_half = work.motion.v_half.data();
  const bool books_forces = model.settings.energy_ledger && !model.forces.empty();
  if (books_forces) noteForces(model, work.visits, work.hands, work.placement, work.forces);
  for (const ModelTree* tree : work.hands.movers) {
    work.counted.done += units::kLink * tree->model->linkCount();
    book(startVerlet(inPlace(model, *tree, v_half, state, work), gravity, h, work.motion.scratch), state, report.step);
  }
  moveHeld(model, part, state, work.hands, work.placement);
  placeHeldTrees(model, state, work);
  evaluate(model, part, true, state, work, report);
  for (const ModelTree* tree : work.hands.movers) {
    const Wrench* events = work.contacts.has_kick ? work.contacts.kick.data() + tree->link : nullptr;
    finishVerlet(inPlace(model, *tree, v_half, state, work), gravity, h, events, work.motion.scratch);
  }
  if (!model.settings.energy_ledger) return;
  if (books_forces) bookForces(model, h, 0.5, work.visits, work.hands, work.placement, work.forces, state);
  if (!work.contacts.booked.empty()) lookAhead(model, h, state, work);
  bookVerlet(work.ledgerView(model), h, work.motion.v_half, work.motion.v_ahead, work.contacts.booked, state);
}

/// Of a tree that has flowed: of the drift by its stages, of what pulls as velocity Verlet's, of laws that are not smooth as symplectic
/// Euler's, h/2 |v₁ - v₀| [m].
double flowError(const Model& model, const ModelTree& tree, double h, bool pulled, const State& state, const Work& work) noexcept {
  const double size = model.links[tree.link].size;
  const TreeMotion* laws = work.joints[model.indexOf(tree)].get();
  const bool euler = laws && laws->report().passes > 0;
  double stages = 0;
  if (laws && !euler) stages = laws->smoothError(h, size);
  if (!laws && !tree.model->isFreeBody()) stages = rungeKuttaError(*tree.model, h, size, work.motion.scratch.stages.data());
  if (!euler && !pulled) return stages;
  double turn2 = 0, way2 = 0;
  for (int l = 0; l < tree.model->linkCount(); ++l) {
    const LinkModel& link = tree.model->link(l);
    for (int d = 0; d < link.dof; ++d) {
      const int i = link.v + d, k = tree.v + i;
      const double v0 = work.motion.v_start[k], v1 = state.v[k];
      const double bent = euler ? 0.5 * (v1 - v0) : 5.0 / 6 * (v1 - 2 * work.motion.v_half[k] + v0);
      (i >= link.v_slide && i < link.v_slide + link.slides ? way2 : turn2) += bent * bent;
    }
  }
  return stages + h * std::sqrt(way2 + size * size * turn2);
}

void flow(const Model& model, int t, double h, State& state, Work& work, StepReport& report) noexcept {
  const ModelTree& tree = model.trees[t];
  const Vector3& gravity = model.settings.gravity;
  const bool pulled = anyWrench(model, state, t);
  work.counted.done += units::kLink * tree.model->linkCount();
  if (!pulled && model.isFree(tree)) return stepFreeBody(tree.model->link(0), gravity, h, state.q.data() + tree.q, state.v.data() + tree.v);
  const SteppedTree stepped = inPlace(model, tree, work.motion.v_half.data(), state, work);
  LinkWork* links = work.placement.link.data();
  placeTree(tree, state, work.placement);
  if (pulled) addWrenches(model, state, t, links);
  readPull(stepped, gravity, work.motion.scratch);
  book(startVerlet(stepped, gravity, h, work.motion.scratch), state, report);
  if (pulled) addWrenches(model, state, t, links);
  finishVerlet(stepped, gravity, h, nullptr, work.motion.scratch);
  work.position_error = std::max(work.position_error, flowError(model, tree, h, pulled, state, work));
}

void keepFlow(const Model& model, int t, double h, const std::vector<double>& v_start, State& state) noexcept {
  const ModelTree& tree = model.trees[t];
  for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) state.a_end[i] = (state.v[i] - v_start[i]) / h;
  state.last_step[t] = 0;
  state.mode[t] = TreeMode::kFlowed;
}

void flowAll(const Model& model, const StepPart& part, State& state, Work& work, Report& report) noexcept {
  moveHeld(model, part, state, work.hands, work.placement);
  for (const int t : work.visits.trees) {
    const ModelTree& tree = model.trees[t];
    if (work.hands.movesByItself(tree)) {
      std::copy_n(state.v.begin() + tree.v, tree.model->nv(), work.motion.v_start.begin() + tree.v);
      flow(model, t, part.h, state, work, report.step);
      keepFlow(model, t, part.h, work.motion.v_start, state);
    }
    placeTree(tree, state, work.placement);
  }
}

void keepPull(const Model& model, const ModelTree& tree, State& state, Work& work) noexcept {
  readPull(inPlace(model, tree, nullptr, state, work), model.settings.gravity, work.motion.scratch);
}

void forgetPull(State& state, int tree) noexcept {
  if (state.mode[tree] == TreeMode::kPrimed) state.mode[tree] = TreeMode::kUnprimed;
  state.last_step[tree] = 0;
}

void forgetPull(State& state) noexcept {
  for (int t = 0; t < static_cast<int>(state.mode.size()); ++t) forgetPull(state, t);
}

}  // namespace haptic::stepping
