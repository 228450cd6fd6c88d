/// Contacts in which nothing moves by itself: hands, motions and the fixed world on both sides. Evaluated where the part ends.
#pragma once
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {

/// (in realtime) Wrenches on links, memories, reports and books of such pairs over a part of h [s].
void evaluateLed(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept;

}  // namespace haptic::stepping
