/// How stiff a virtual wall may be: the bound of a sampled haptic loop.
///
/// A wall of stiffness K and damping b, sampled with period T and delayed by τ beyond the hold's T/2, gives back at
/// most as much energy as the device's viscous damping B takes while
///     B > K (T/2 + τ) + |b|.
/// Colgate & Schenkel (1997) prove B > K T/2 + |b| for τ = 0 necessary and sufficient for passivity whatever the hand
/// does; a delay acts on the force like a longer hold. Deviation: passivity is sufficient for stability, not necessary;
/// a damped hand bears more. The bench `loop` measures how near the twin comes.
#pragma once
#include <algorithm>
#include <cmath>

namespace haptic {

/// Damping that a relaxed hand adds to the device's own [N·s/m]; the twin's hand has it.
inline constexpr double kRelaxedHandDamping = 8;
/// And of a turn [N·m·s/rad]; likewise.
inline constexpr double kRelaxedHandTurnDamping = 0.01;

/// Largest K [N/m] for B, b [N·s/m], T and τ [s]; 0: none, the device has no damping to spare.
inline double largestWallStiffness(double device_damping, double wall_damping, double period, double delay) {
  return std::max(0.0, (device_damping - std::fabs(wall_damping)) / (period / 2 + delay));
}

/// The largest K [N/m] of a loop that bears `stiffness` [N/m] by damping B [N·s/m], when its delay grows by `added` [s]: B/K is T/2 + τ,
/// so 1/K' = 1/K + added/B.
inline double withAddedDelay(double stiffness, double damping, double added) {
  return damping > 0 ? stiffness / (1 + stiffness * added / damping) : 0;
}

/// τ of this loop: an exchange answers before it executes, so counts reach the strings one period later, plus the
/// wire's own delay [s].
inline double loopDelay(double period, double wire_delay) { return period + wire_delay; }

}  // namespace haptic
