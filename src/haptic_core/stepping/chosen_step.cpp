#include "haptic_core/stepping/chosen_step.h"

#include "haptic_core/stepping/choice.h"
#include "haptic_core/stepping/explicit_step.h"
#include "haptic_core/stepping/implicit_islands.h"

namespace haptic::stepping {

void chosenStep(const Model& model, StepPart& part, State& state, Work& work, Report& report) noexcept {
  prime(model, part, state, work, report);
  keepForRetreat(state, report.step, work.choice.retreat);
  while (!velocityVerlet(model, part, state, work, report)) {
    takeBack(model, state, work, report.step);
    ++report.step.redone;
    if (work.choice.cuts && work.choice.parts > 1) part = shortened(model, part, model.substep() / work.choice.parts);
  }
  if (anyImplicit(state)) stepImplicitIslands(model, part, state, work, report);
  collectHeld(model, part, state, work.hands, work.placement);
  report.step.pairs = state.pair_count;
  report.step.contacts = report.contacts.size();
}

}  // namespace haptic::stepping
