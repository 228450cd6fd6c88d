#include "haptic_core/stepping/advance.h"

#include "haptic_core/stepping/explicit_contacts.h"
#include "haptic_core/stepping/explicit_step.h"
#include "haptic_core/stepping/implicit_islands.h"

namespace haptic::stepping {
namespace {

/// All that hands lead at the part's end: there pairs are found, and contacts in which nothing moves by itself.
void lead(const Model& model, const StepPart& part, State& state, Work& work, Report& report) noexcept {
  moveHeld(model, part, state, work.hands, work.placement);
  placeTrees(model, work.visits.trees, state, work.placement);
  work.clock.end(report.step.stages.motion);
  lookForPairs(model, part.h, state, work, report.step);
  evaluateContacts(model, {part.h, true}, state, work, report);
  if (!model.settings.energy_ledger) return;
  bookVerlet(work.ledgerView(model), part.h, work.motion.v_half, work.motion.v_ahead, work.contacts.booked, state);
}

}  // namespace

void advance(const Model& model, const StepPart& part, State& state, Work& work, Report& report) noexcept {
  work.position_error = 0;
  if (model.allFlows()) {
    flowAll(model, part, state, work, report);
  } else if (model.explicit_steps) {
    velocityVerlet(model, part, state, work, report);
  } else {
    lead(model, part, state, work, report);
    stepImplicitIslands(model, part, state, work, report);
  }
  report.step.position_error += work.position_error;
  report.step.pairs = state.pair_count;
  report.step.contacts = report.contacts.size();
}

}  // namespace haptic::stepping
