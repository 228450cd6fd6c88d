/// The rule of a step: every island in its way (island_solve.h), and where one does not converge and the step is long, all in halves. A
/// world in which nothing can touch or pull flows as a whole; Attempts::kVerlet steps all by velocity Verlet.
#pragma once
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/step_parts.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {

/// (in realtime) Advances by `part`, or by a shorter beginning of it, which it becomes.
void advance(const Model& model, StepPart& part, State& state, Work& work, Report& report) noexcept;

}  // namespace haptic::stepping
