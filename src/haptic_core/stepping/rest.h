/// When an island is at rest.
///
/// At rest is an island whose step would begin and end slower than a bound: such a step is not taken, positions and the memory of the
/// contacts stay, velocities become zero, and the energy of their motion is booked as a loss (ImplicitReport::rests). The bound is the
/// solve's rounding; for an island that stands alone and whose bodies have been slow for `kCalmSteps` it is a share of the error that a
/// step may make (`restingSpeed`). So what comes to rest by itself does so to rounding, and what would rock on for seconds stops. No
/// force out of balance moves an island at rest unless it is more than kOfAccuracy · accuracy of its weight, and of a motion of circular
/// frequency ω it keeps no more than
///
///     restingSpeed max(1/ω, 2/(kCalmSteps h ω²))
///
/// from its equilibrium: 60 nm at 10 rad/s and 1 ms. An unstable equilibrium is kept as well, where no more than that pulls it away.
///
/// A step is a function of its start. Where it has found an island at rest, and changed nothing, the next one would find and change the
/// same; so no step visits it until something comes near (activity.h).
#pragma once
#include "haptic_core/world/hands.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/placement.h"
#include "haptic_core/world/state.h"

namespace haptic::stepping {

/// Speed that rounding of coordinates makes in a step of length h at a distance from W's origin, beside bodies of this speed [m/s].
inline double roundingSpeed(double speed, double distance, double h) noexcept {
  // Smaller shares: solves iterate on rounding, and nothing ever stands; larger: what creeps stands.
  constexpr double kFinest = 1e-13, kRounding = 4 * 2.2e-16;
  return kFinest * speed + kRounding * distance / h;
}
/// Speeds below this many times that are rounding: coordinates of several bodies add up. Larger: what creeps slower than that
/// stands; smaller: heaps never come to rest, and cost as much as if they moved.
constexpr double kOfRounding = 4;
/// Share of the error that a step may make, WorldSettings::accuracy, that is left out of an island that stands alone. Larger: a body
/// pulled by more than 3e-5 of its weight stays where it is, farther from its equilibrium; smaller: a body that rocks by the solve's
/// tolerance, at 1e-7 m/s at 1 ms, does so for longer.
constexpr double kOfAccuracy = 1e-3;

/// Steps in a row in which a body has to be slower than that. Fewer: what approaches its rest in a tenth of a second is stopped short
/// of it; more: what rocks is computed for longer.
constexpr int kCalmSteps = 100;

/// Speed below which a body is slow, in a step of length h [m/s]: 3e-7 at 1 ms.
inline double restingSpeed(const WorldSettings& settings, double h) noexcept {
  return kOfAccuracy * settings.accuracy * h * settings.gravity.norm();
}

/// (in realtime) Every velocity of the tree is zero, as of all that stands.
bool isStill(const Model& model, int tree, const State& state) noexcept;

/// (in realtime) No hand pulls at it, no joint has a law of its own, and what its pairs know beside it never moves.
bool standsAlone(const Model& model, const Island& island, const State& state) noexcept;

/// (in realtime) All bodies of the island have been slow for long enough.
bool isCalm(const Island& island, const State& state) noexcept;
/// (in realtime) After a whole step: how long its bodies have been slow.
void countCalm(const Model& model, const HandWork& hands, const Placement& placement, State& state) noexcept;
/// (in realtime) The same of one island that has gone over so many steps at once.
void countCalmOver(const Model& model, const Island& island, int steps, const Placement& placement, State& state) noexcept;

}  // namespace haptic::stepping
