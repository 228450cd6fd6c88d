/// What the port between a hand and a sampled haptic loop bears: the one bound on walls, couplings and dampers.
///
///     hand and device (B) | hold and delay (T/2 + τ) | coupling (K, b) | tool, contacts, other bodies (passive)
///
/// The force that tick n computes is held over a period and comes late: beside the scene's impedance Z the hand meets Z exp(-jωL), with
/// L = T/2 + τ. It gets no energy while Re(Z exp(-jωL)) ≥ -B at every ω, B [N·s/m] the damping of hand and device.
///
/// **A wall** that the hand meets itself, the slope S = λ_max(Σ k A0 n nᵀ) of its contacts together, with a damper b: Z = S/(jω) + b, and
///     Re = -S sin(ωL)/ω + b cos(ωL) ≥ -(S L + |b|):        B ≥ S L + |b|.
/// Colgate & Schenkel (1997) prove B > S T/2 + |b| for τ = 0 necessary and sufficient for passivity whatever the hand does; a delay acts
/// on the force like a longer hold. Deviation: passivity is sufficient for stability, not necessary; a damped hand bears more. The bench
/// `loop` measures how near the twin comes.
///
/// **A coupling** in front of a world. With C = K/(jω) + b and the world's admittance Y beyond it, Z = 1/(1/C + Y). All that is known of Y
/// is that it is passive, Re Y ≥ 0, whatever the tool weighs and touches. So Re(1/Z) ≥ r = Re(1/C) = ω² b/(K² + ω² b²): Z lies in the disc
/// about 1/(2r) of radius 1/(2r), which touches 0. The delay turns it about 0 by ωL, and its leftmost point then is
///     (cos ωL - 1)/(2r) = -(1 - cos ωL)/2 · (b + K²/(ω² b)) ≥ -(b + (K L)²/(4 b)),        1 - cos x ≤ min(2, x²/2):
///     B ≥ b + (K L)²/(4 b).                                                                              (1)
/// K is largest at b = B/2: K = B/L, as stiff as the stiffest wall. Without a damper there is no K at all: the world could answer a late
/// spring at any frequency. That holds only if the world is passive. So nothing between tick and tool may depend on where the tool was a
/// tick ago: a row that followed the depth of the contacts was a spring of the slope of a whole plate, one step late, and rang with all
/// of the device's force where S h² > m (a ball of .5 kg in a plate of 2 mm: S h²/m = 7). Couplings and contacts are stepped together.
/// The tool's mass does not enter: of a light tool the coupling is as stiff as of a heavy one.
/// Two causes take more:
///   - L' = L + T/2: an implicit step books the coupling's force against the way that led to it, so its world is passive for a port half
///     a period earlier.
///   - the damper takes a filtered velocity of the hand, b/(1 + jωσ): the disc is turned by the phase of (K + jωb/(1 + jωσ))/(K + jωb) as
///     well. For σ = 0.8 ms the left side of (1) is 1.09 B at most, at any period; `kFiltered` K makes it 0.96 B (wall_bound_test).
///
/// **Counts.** One encoder count q moves the force of a wall's or coupling's spring by S q or K q, for as long as it lasts, and that of a
/// coupling's damper by b q g/T, g the share of the filter in a period, for some periods. A hand at rest feels that, and a grip hums by it,
/// between two or three counts. S and b are each lowered until that force is `kCountForce`, K until the force is `kSpringShare` of it. Of
/// 2000 presses on thin bodies (bench `hand`) 15 hum with 0.15 N for S and 0.1 N for K and b, 3 with 0.08 N; of 2000 others none and one.
/// Lowered together, K and b leave a tool that swings at 65 Hz with a damping ratio of 0.03 at 10 kHz, where b alone is within the bound.
/// At 1 kHz that lowers the wall of the device with the coarsest counts alone, at 10 kHz from 14.5 to 4.8 N/mm where a count is 17 µm.
#pragma once
#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"

namespace haptic {

/// Damping that a relaxed hand adds to the device's own [N·s/m]; the twin's hand has it.
inline constexpr double kRelaxedHandDamping = 8;
/// And of a turn [N·m·s/rad]; likewise.
inline constexpr double kRelaxedHandTurnDamping = 0.01;
/// Share of K of (1) that the filter of the velocity leaves [1]; at 1 a world can be made that gets a tenth of B at 400 Hz.
inline constexpr double kFiltered = 0.9;
/// Most that one count may change a force [N]: three counts change it by less than 0.3 N, the least change that is a turn of a ring
/// (loop/hand_trial.h). A count of 17 µm is 0.08 N at 1 kHz in front of the stiffest wall, and would be 0.25 N at 10 kHz.
inline constexpr double kCountForce = 0.08;
/// Share of kCountForce that the spring of a coupling may have [1], behind which a tool swings. At 0.5 one thin press less rings, and the
/// coupling of a G6X3R is a third softer at 1 kHz, where 0.75 leaves it as it is.
inline constexpr double kSpringShare = 0.75;

/// Largest K [N/m] for B, b [N·s/m], T and τ [s]; 0: none, the device has no damping to spare.
inline double largestWallStiffness(double device_damping, double wall_damping, double period, double delay) {
  return std::max(0.0, (device_damping - std::fabs(wall_damping)) / (period / 2 + delay));
}

/// S [N/m] of a wall that the hand bears by damping and delay, lowered until a count of `count` [m] moves its force by no more than
/// kCountForce.
inline double stiffestWall(double borne, double count) { return std::min(borne, kCountForce / count); }

/// The port of a loop, at the grip.
struct LoopPort {
  double damping = 0;  ///< B of hand and device [N·s/m]
  double lag = 0;      ///< L = T/2 + τ [s]
  double period = 0;   ///< T [s]
  double count = 0;    ///< q: one count of a string [m]
  double filter = 0;   ///< σ, time constant of the velocity [s]
};

/// A virtual coupling that gives a hand no energy.
struct CouplingBound {
  double stiffness = 0;  ///< K [N/m]
  double damping = 0;    ///< b [N·s/m]
};

/// The stiffest coupling that the port bears, in front of any passive world.
inline CouplingBound stiffestCoupling(const LoopPort& port) {
  CouplingBound bound{kFiltered * port.damping / (port.lag + 0.5 * port.period), 0.5 * port.damping};
  const double gain = -elementary::expm1(-port.period / port.filter);
  const double most = kCountForce / port.count;
  return {std::min(bound.stiffness, kSpringShare * most), std::min(bound.damping, most * port.period / gain)};
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
