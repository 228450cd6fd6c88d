/// Turns of the islands that wait (own_rate.h): each comes to the present in one implicit step over the time that it is late.
#pragma once
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {

/// (in realtime) Within the implicit part of a step, once the pairs are known: those visited trees whose turn has come, and those that can
/// wait no longer, come to the present. Those that `may_wait` and do are set to their next turn, their contacts reported.
void takeTurns(const Model& model, bool may_wait, State& state, Work& work, StepReport& report) noexcept;

/// (in realtime) Between two steps: all trees come to the present.
void bringToPresent(const Model& model, State& state, Work& work, StepReport& report) noexcept;

}  // namespace haptic::stepping
