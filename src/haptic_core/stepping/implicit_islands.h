/// The implicit part of a step: the islands that are stepped implicitly, one after the other.
#pragma once
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {

/// (in realtime) The islands of implicit trees alone, among pairs that were found before; leaves them placed.
void stepImplicitIslands(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept;

}  // namespace haptic::stepping
