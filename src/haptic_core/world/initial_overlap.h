/// Shapes that overlap before the first step.
#pragma once
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"

namespace haptic {

/// Bodies that never move and overlap by more than a tenth of the thinner one: nothing could push them apart, and one of
/// them is not where it should be; what stands in a half-space may. Throws SetupError that names both.
void refuseStaticOverlaps(const Model& model, Work& work);

/// Pairs that overlap deep are marked: they are pushed out slowly. Everything is placed already. `tree`: of its pairs alone; −1: of all.
void findBuried(const Model& model, int tree, State& state, Work& work);

}  // namespace haptic
