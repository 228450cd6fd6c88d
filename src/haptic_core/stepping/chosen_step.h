/// A step of the automatic choice (choice.h): all islands explicitly first, stiff ones again implicitly, and where that does not
/// converge and the step is long, in halves.
#pragma once
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/step_parts.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {

/// (in realtime) Advances by `part`, or by a shorter beginning of it, which it becomes. At most as many attempts as there are
/// islands, each with at least one more implicit tree, and those that found the part too long: each asks for a shorter one.
void chosenStep(const Model& model, StepPart& part, State& state, Work& work, Report& report) noexcept;

}  // namespace haptic::stepping
