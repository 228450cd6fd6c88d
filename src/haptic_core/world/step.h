/// One step of a world: the pipeline, stage by stage.
#pragma once
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"

namespace haptic {

/// (in realtime) Advances the state by the model's step. A world that has stopped (`finite` false) stays where it is.
void step(const Model& model, State& state, Work& work, StepReport& report) noexcept;

}  // namespace haptic
