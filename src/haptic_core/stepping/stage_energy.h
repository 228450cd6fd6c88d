/// The energy of an island in a stage, and the guard of a stage that did not converge: it adds none.
#pragma once
#include "haptic_core/stepping/stage_reference.h"

namespace haptic::stepping {

/// (in realtime) Of the island at its reference, springs of contacts and force elements included [J].
double energyAtReference(const ImplicitStage& stage) noexcept;
/// (in realtime) Work of hands and belts over a stage of length g, with the forces and velocities at its reference [J].
double supplyAtReference(const ImplicitStage& stage, double g) noexcept;

/// (in realtime) After an implicit Euler stage from the state's q, v that did not converge: looks at the exact energy of
/// v and, where it is above that of the start and what hands supply meanwhile, goes back to the last reference that was not, or slows
/// the island down until it is not. Three evaluations at most. The energy that is then lost [J]; negative: a hand supplied it.
double keepEnergy(const Model& model, State& state, double g, ImplicitStage& stage) noexcept;

}  // namespace haptic::stepping
