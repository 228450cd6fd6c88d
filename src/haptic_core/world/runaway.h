/// Whether a world has to stop: a number of it is none, or its steps have made energy.
///
/// There is so much energy to draw on: the motion at the start, the energy of springs when they were first looked at, the bodies'
/// fall, and the work of hands and drives, all counted without the losses to friction and dampers since. Steps that
/// have made as much again have run away: they are too long for the contacts that they met. With the ledger their gain is
/// known (EnergySums::unaccounted); in any case the kinetic energy is held against the supply.
///
/// Cost: a few operations per step; without the ledger the kinetic and the potential energy, 20 ns for each body.
#pragma once
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"

namespace haptic {

class Model;
struct Work;

/// At load, everything placed and the pairs found: motion, and springs of what overlaps already.
void startSupply(const Model& model, Work& work, State& state) noexcept;

/// (in realtime) Where bodies changed hands or values changed between two steps: the present energy can be drawn on.
void renewSupply(const Model& model, const Work& work, State& state) noexcept;

/// (in realtime) After a part of a step: a number of what it visited that is none stops the world (`Work::stopped`), `culprit` is the link
/// that had it first.
void checkFinite(const Model& model, const State& state, Work& work, StepReport& report) noexcept;

/// (in realtime) After a part of a step of length h [s]; `external`: the hands' and drives' work before it [J]. After the
/// ledger was closed. Stops the world; `culprit` is the link that moves with the most energy, and kRunaway is flagged.
void checkRunaway(const Model& model, double h, double external, State& state, Work& work, StepReport& report) noexcept;

/// Of a world that is not `finite` any more, for people.
inline const char* whyStopped(const StepReport& report) noexcept {
  return report.flags & kRunaway ? "its steps made energy (shorten the step, or take implicit ones)" : "a number was lost";
}

}  // namespace haptic
