#include "haptic_core/stepping/advance.h"

#include "haptic_core/stepping/flow.h"
#include "haptic_core/stepping/implicit_islands.h"
#include "haptic_core/stepping/led_contacts.h"
#include "haptic_core/world/comparator.h"

namespace haptic::stepping {
namespace {

/// All that is led goes to the part's end: there pairs are found, and contacts in which nothing moves by itself.
void lead(const Model& model, const StepPart& part, State& state, Work& work, Report& report) noexcept {
  moveHeld(model, part, state, work.hands, work.placement);
  placeTrees(model, work.visits.trees, state, work.placement);
  work.clock.end(report.step.stages.motion);
  lookForPairs(model, part.h, state, work, report.step);
  evaluateLed(model, part.h, state, work, report);
}

}  // namespace

void advance(const Model& model, const StepPart& part, State& state, Work& work, Report& report) noexcept {
  work.position_error = 0;
  if (model.allFlows()) {
    flowAll(model, part, state, work, report);
  } else if (work.comparator) {
    work.comparator->advance(model, part, state, work, report);
  } else {
    lead(model, part, state, work, report);
    stepImplicitIslands(model, part, state, work, report);
  }
  report.step.position_error += work.position_error;
  report.step.pairs = state.pair_count;
  report.step.contacts = report.contacts.size();
}

}  // namespace haptic::stepping
