/// The rule of a step: hands and all that they lead first, then every island in its way (island_solve.h). A world in which nothing can
/// touch or pull flows as a whole; a comparator steps whole worlds.
#pragma once
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {

/// (in realtime) Advances by h [s]; hands have their goals.
void advance(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept;

}  // namespace haptic::stepping
