#include "haptic_core/stepping/chosen_step.h"

#include <limits>

#include "haptic_core/stepping/choice.h"
#include "haptic_core/stepping/explicit_step.h"
#include "haptic_core/stepping/implicit_islands.h"

namespace haptic::stepping {

void chosenStep(const Model& model, StepPart& part, State& state, Work& work, Report& report) noexcept {
  prime(model, part, state, work, report);
  keepForRetreat(state, report.step, work.choice.retreat);
  int attempts = static_cast<int>(model.trees.size()) + kMostParts;  // each makes a tree implicit or asks for more parts
  work.choice.decided = false;
  while (!velocityVerlet(model, part, state, work, report)) {
    takeBack(model, state, work, report.step);
    ++report.step.redone;
    work.choice.decided = --attempts == 0;
    if (!anyImplicit(state)) part = shortened(model, part, model.substep() / work.choice.parts);
  }
  if (anyImplicit(state)) {
    stepImplicitIslands(model, part, state, work, report);
    part.longest = std::numeric_limits<double>::infinity();  // parts are for what is explicit
  }
  collectHeld(model, part, state, work.hands, work.placement);
  report.step.pairs = state.pair_count;
  report.step.contacts = report.contacts.size();
}

}  // namespace haptic::stepping
