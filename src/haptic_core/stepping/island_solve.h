/// The solve of one implicit island, and its contacts and energies for state, hands and report.
#pragma once
#include "haptic_core/stepping/implicit_step.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {

/// (in realtime) After `beginIslands`: advances the island by h [s]. `most`: of the step's budget [units]. Null: nothing but gravity and
/// wrenches acted on it, and no contact was looked at; else the solve's report, until the next one.
const ImplicitReport* solveIsland(const Model& model, const Island& island, double h, double most, State& state, Work& work,
                                  StepReport& report) noexcept;

/// (in realtime) What moved in an island that is brought to rest is lost; the placement has its velocities still.
void bookRest(const Model& model, const Island& island, const Placement& placement, EnergySums& energy) noexcept;

/// (in realtime) After the island was placed: what its contacts did over h [s]. `solved`: of solveIsland; null: nothing touches it.
void takeContacts(const Model& model, const Island& island, const ImplicitReport* solved, double h, State& state, Work& work,
                  StepReport& report) noexcept;

}  // namespace haptic::stepping
