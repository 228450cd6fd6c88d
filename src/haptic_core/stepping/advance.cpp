#include "haptic_core/stepping/advance.h"

#include "haptic_core/stepping/activity.h"
#include "haptic_core/stepping/flow.h"
#include "haptic_core/stepping/implicit_islands.h"
#include "haptic_core/stepping/led_contacts.h"
#include "haptic_core/stepping/span.h"
#include "haptic_core/world/comparator.h"

namespace haptic::stepping {
namespace {

/// All that is led goes to the step's end: there pairs are found, and contacts in which nothing moves by itself.
void lead(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept {
  stopShort(model, state, work);
  moveHeld(model, state, work.hands, work.placement);
  placeTrees(model, work.visits.trees, state, work.placement);
  work.clock.end(report.stages.motion);
  lookForPairs(model, h, state, work, report);
  evaluateLed(model, h, state, work, report);
}

}  // namespace

void advance(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept {
  if (model.allFlows()) {
    flowAll(model, h, state, work, report);
  } else if (work.comparator) {
    work.comparator->advance(model, h, state, work, report);
  } else {
    lead(model, h, state, work, report);
    stepImplicitIslands(model, h, state, work, report);
  }
}

}  // namespace haptic::stepping
