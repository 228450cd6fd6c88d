#include "haptic_core/world/step.h"

#include <cmath>

#include "haptic_core/stepping/advance.h"
#include "haptic_core/stepping/rest.h"
#include "haptic_core/world/applied_wrench.h"
#include "haptic_core/world/drive_paths.h"
#include "haptic_core/world/hands.h"
#include "haptic_core/world/ledger.h"
#include "haptic_core/world/runaway.h"

namespace haptic {
namespace {

/// Share of the energy of impacts that the steps may gain or lose without saying so: 2 % of the speed after an impact.
constexpr double kKeptInImpacts = 0.04;

/// Resets counters and sums of the last step; energies and stage times stay where no stage renews them.
void reset(Work& work, StepReport& report) noexcept {
  work.position_error = work.wrench_error = work.impact = 0;
  report.flags = 0;
  report.iterations = report.evaluations = report.factorisations = report.parts = 0;
  report.implicit_islands = report.standing = report.waiting = report.fallbacks = 0;
  report.lag = 0;
  report.closure = report.residual = report.wrench_error = report.budget_used = report.position_error = report.impact = 0;
}

/// Wrenches whose time is over end before the step; forces on their links jump.
void dropEnded(const Model& model, State& state, Work& work) noexcept {
  int kept = 0;
  for (int i = 0; i < state.wrench_count; ++i) {
    if (state.wrenches[i].end > state.step) {
      state.wrenches[kept++] = state.wrenches[i];
    } else {
      state.beginAnew(model.links[state.wrenches[i].link].articulation);
      work.activity.wakeAll(model, false, state, work);
    }
  }
  state.wrench_count = kept;
}

/// The pipeline.
void run(const Model& model, State& state, Work& work, StepReport& report) noexcept {
  reset(work, report);
  work.counted.begin(model.tuning.budget);
  findActing(model, state, work.hands);
  work.activity.wakeForStep(model, state, work);
  const double h = model.settings.step;
  followDrivePaths(model, state);                                    // positions that drives are asked for
  boundHands(model, state, work.placement, work.hands);
  aimMotions(model, h, state, work.hands);
  aimHeld(model, state, h, work);                                    // how far held links follow their hands
  const double external_before = state.energy.external, unaccounted_before = state.energy.unaccounted();
  noteWrenches(state, work.placement, work.wrenches);
  stepping::advance(model, h, state, work, report);                  // hands, then each island
  collectHeld(model, work.reported, work.placement, state, work.hands);  // wrenches on held links go to their hands
  bookWrenches(work.hands, h, work.wrenches, work.placement, state);
  if (model.settings.energy_ledger) report.energy = closeLedger(work.ledgerView(model), unaccounted_before, state);
  // Impacts shorter than the step are made plastic by implicit steps.
  const double lost = std::abs(state.energy.unaccounted() - unaccounted_before);
  if (work.impact > 0 && lost > kKeptInImpacts * work.impact) report.flags |= kImpactUnresolved;
  checkFinite(model, state, work, report);
  if (!work.stopped) checkRunaway(model, h, external_before, state, work, report);
  if (work.implicit) stepping::countCalm(model, work.hands, work.placement, state);
  tellHands(work.stopped, work.wrench_error, work.hands, state);
  work.activity.close(model, state, work, report);                   // islands at rest are left out from here on
  if (work.activity.waiting() > 0) report.lag = stepping::lagOf(model, state);
  report.position_error = work.position_error;
  report.impact = work.impact;
  report.work = work.counted.done;
  if (work.counted.gave_way) report.flags |= kGaveWay;
}

}  // namespace

void step(const Model& model, State& state, Work& work, StepReport& report) noexcept {
  if (work.stopped) return;
  work.clock.start(report.stages);
  dropEnded(model, state, work);
  if (work.activity.idle()) {
    report.work = 0;  // nothing would change, until somebody changes something
  } else {
    run(model, state, work, report);
  }
  work.clock.end(report.stages.motion);
  report.step = ++state.step;
  state.time = static_cast<double>(state.step) * model.settings.step;
}

}  // namespace haptic
