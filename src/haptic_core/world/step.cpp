#include "haptic_core/world/step.h"

#include <cmath>

#include "haptic_core/base/lanes.h"
#include "haptic_core/stepping/chosen_step.h"
#include "haptic_core/stepping/explicit_step.h"
#include "haptic_core/stepping/implicit_islands.h"
#include "haptic_core/world/applied_wrench.h"
#include "haptic_core/world/drive_paths.h"
#include "haptic_core/world/runaway.h"
#include "haptic_core/world/step_parts.h"

namespace haptic {
namespace {

/// Counters and sums of the last step go; energies and stage times stay where no stage renews them.
void open(Work& work, Report& whole) noexcept {
  StepReport& report = whole.step;
  report.flags = 0;
  report.iterations = report.evaluations = report.factorisations = report.parts = 0;
  report.implicit_islands = report.standing = report.redone = report.fallbacks = report.substeps = 0;
  report.closure = report.residual = report.wrench_error = report.budget_used = report.position_error = 0;
  work.parts.any = false;
  if (work.implicit) work.standing.open(whole.contacts);
}

/// hands → placement → pairs → contacts → motion, in the order that the integrator needs.
void advance(const Model& model, StepPart& part, State& state, Work& work, Report& report) noexcept {
  switch (model.settings.integrator) {
    case Integrator::kSymplecticEuler:
      stepping::symplecticEuler(model, part, state, work, report);
      break;
    case Integrator::kVelocityVerlet:
      stepping::prime(model, part, state, work, report);
      stepping::velocityVerlet(model, part, state, work, report);
      collectHeld(model, part, state, work.hands, work.placement);
      break;
    case Integrator::kImplicitEuler:
    case Integrator::kSdirk2:
      stepping::implicitStep(model, part, state, work, report);
      break;
    case Integrator::kAutomatic:
      stepping::chosenStep(model, part, state, work, report);
      break;
  }
}

/// 0, or NaN: infinity does not survive in it either, 0·∞ = NaN.
double zeroOrNan(const double* x, int count) noexcept {
  Lanes four = lanes(0);
  int i = 0;
  for (; i + 4 <= count; i += 4) four += lanes(0) * loadLanes(x + i);
  double rest = 0;
#pragma GCC unroll 1
  for (; i < count; ++i) rest += 0 * x[i];
  return sum(four) + rest;
}

/// A world with a number that is none stops, and says which link had it first.
void checkFinite(const Model& model, const Visits& visits, const State& state, StepReport& report) noexcept {
  const bool all = 2 * visits.trees.size() > model.trees.size();  // numbers in a row are quick to look at
  if (all && zeroOrNan(state.v.data(), model.nv) + zeroOrNan(state.q.data(), model.nq) == 0) return;
  for (const int t : visits.trees) {
    const ModelTree& tree = model.trees[t];
    const double sum = zeroOrNan(state.v.data() + tree.v, tree.model->nv()) +
                       zeroOrNan(state.q.data() + tree.q, tree.model->nq());
    if (sum == 0) continue;
    report.finite = false;
    report.culprit = tree.link;
    return;
  }
}

/// Share of the energy of impacts that the steps may gain or lose without saying so: 2 % of the speed after an impact.
constexpr double kKeptInImpacts = 0.04;

/// Impacts shorter than the step are made plastic by implicit steps and thrown back by explicit ones.
void checkImpacts(double lost, StepReport& report) noexcept {
  if (report.impact > 0 && std::abs(lost) > kKeptInImpacts * report.impact) report.flags |= kImpactUnresolved;
}

/// Wrenches whose time is over end before the step; forces on their links jump.
void dropEnded(const Model& model, State& state, Work& work, Report& report) noexcept {
  int kept = 0;
  for (int i = 0; i < state.wrench_count; ++i) {
    if (state.wrenches[i].end > state.step) {
      state.wrenches[kept++] = state.wrenches[i];
    } else {
      stepping::forgetPull(state, model.links[state.wrenches[i].link].articulation);
      work.asleep.wakeAll(model, state, work, &report);
      work.standing.forget();
    }
  }
  state.wrench_count = kept;
}

/// Islands that were left out fall asleep; the report counts all that sleep.
void layAside(const Model& model, State& state, Work& work, Report& report) noexcept {
  report.step.implicit_islands += work.asleep.islands();
  report.step.standing += work.asleep.trees();
  report.step.flags |= work.asleep.flags();
  report.step.finite ? work.asleep.fall(model, state, work, report) : work.asleep.keepAwake();
  report.step.pairs = state.pair_count + work.asleep.pairs();
  report.step.contacts = report.contacts.size() + work.asleep.contacts().size();
}

void move(const Model& model, State& state, Work& work, Report& report) noexcept {
  open(work, report);
  findActing(model, state, work.hands);
  work.asleep.wakeActed(model, state, work);
  followDrivePaths(model, state);                                    // what drives are asked for
  for (StepPart part = firstPart(model, state, work, report.step); part.h > 0;
       part = nextPart(model, part, state, work, report.step)) {     // no more than hands bear; shorter where something is fast
    const double external = state.energy.external, unaccounted = state.energy.unaccounted();
    report.step.impact = 0;
    if (part.h < model.settings.step) work.asleep.wakeAll(model, state, work, nullptr);  // whole steps are left out
    noteWrenches(state, work.placement, work.wrenches);
    advance(model, part, state, work, report);                       // hands → pairs → contacts → motion
    bookWrenches(work.hands, part.h, work.wrenches, work.placement, state);
    if (model.settings.energy_ledger) closeLedger(work.ledgerView(model), unaccounted, state, report.step.energy);
    checkImpacts(state.energy.unaccounted() - unaccounted, report.step);
    checkFinite(model, work.visits, state, report.step);
    if (report.step.finite) checkRunaway(model, part.h, external, work, state, report);
    if (part.h < model.settings.step) addPart(part.h, work.parts, report);
  }
  if (work.implicit) stepping::countCalm(model, work.hands, work.placement, state);
  reportParts(model.settings.step, work.parts, report);              // mean wrenches over the step
  reportToHands(model, report.step, work.hands, state);
  work.standing.close(work.hands, work.asleep.islands() > 0);
  layAside(model, state, work, report);
}

}  // namespace

void step(const Model& model, State& state, Work& work, Report& report) noexcept {
  if (!report.step.finite) return;
  work.clock.start(report.step.stages);
  dropEnded(model, state, work, report);
  if (!work.standing.all()) move(model, state, work, report);  // else the last step's report is this one's as it is
  work.clock.end(report.step.stages.motion);
  report.step.step = ++state.step;
  state.time = static_cast<double>(state.step) * model.settings.step;
}

}  // namespace haptic
