/// The rule of a step: all islands explicitly first, those that are too stiff for that (choice.h) again implicitly, and where that does
/// not converge and the step is long, in halves. A world that has fewer attempts (world/attempts.h) goes the same way without the others.
#pragma once
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/step_parts.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {

/// (in realtime) Advances by `part`, or by a shorter beginning of it, which it becomes. At most as many attempts as there are
/// islands, each with at least one more implicit tree, and those that found the part too long: each asks for a shorter one.
void advance(const Model& model, StepPart& part, State& state, Work& work, Report& report) noexcept;

}  // namespace haptic::stepping
