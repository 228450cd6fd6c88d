/// How stiff the contacts of a hand's pointer may be, so that the loop around the hand does not ring.
///
/// Who moves the pointer says what its hand bears: K_max [N/m] in the world, from the loop's rate and delay
/// (spidar/wall_bound.h). The pointer's contacts oppose K = λ_max(M), M = Σ k A0 n nᵀ.
///
/// Direct coupling. A contact in whose direction the hand meets K_i = k A0 + nᵀ M' n > K_max, M' of the other contacts as
/// the last step left them, is weakened by s = K_max/K_i: k, k_t, b and b_t alike. A lone contact pushes with K_max V/A0, K_max
/// times its mean thickness. The share s follows from where the bodies are now, not from time: a spring gives back
/// on the way out the energy that it took on the way in, and no other. With two contacts at an angle λ_max of the rest is up to 1.21 K_max.
/// A push beside the link's origin, at the arm r from it, turns the hand as well: its stiffness against both is k A0 (1 + |r × n|²/ρ²),
/// ρ² the hand's damping of a turn over that of a way, and of friction's springs Σ k_t A (1 + r²/ρ²): in a corner two of them add up.
/// Its dampers, normal and tangential, are held to ⅔ τ K_max between them and its neighbours (`kMostDamping`): the loop's bound is
/// on K and b together, and at 6 N a dissipation of 10 s/m is a damper of 60 N·s/m, seven times a hand's own.
/// Other pairs keep their laws, and both bodies of a weakened pair feel the same force.
/// Virtual coupling. Fast motion meets the coupling itself, whatever its link touches, because the link's mass stands still:
/// a spring beyond K_max is weakened to it, its damper with it and to ⅔ τ K_max in any case; its turns are held to ρ² times that.
/// It does not follow the contacts either: a coupling that were weak in touch alone would be given more than it gives back at each
/// touch.
///
/// Beyond the hand's greatest force F a virtual coupling gives F, and beyond its greatest torque that: both of its parts are
/// weakened by F / |F_c|, the same for turns. A held link stays behind its hand instead (held_proxy.h).
///
/// Where a tool is wholly inside or through a body, A0 is 0. A damper acts on the layer's area then (friction.h, layerArea),
/// and has the share of a contact of that area.
///
/// A pair within the bound is not touched: same bits.
#pragma once
#include <limits>

#include "haptic_core/base/spatial.h"
#include "haptic_core/world/definition.h"

namespace haptic {

class Model;
struct ContactVolume;
struct FrictionMemory;
struct HandWork;
struct PairLaw;
struct Placement;
struct State;

/// Largest damper over K_max τ [1]. A hand that takes as much as a damper K_max τ bears spring and damper, felt τ late, where
///     K sin(ωτ)/(ωτ) + b (ωσ sin(ωτ) - cos(ωτ)) / (τ (1 + (ωσ)²)) ≤ K_max,
/// σ the time constant of the filter of the velocity. For K = K_max that holds at every ω if b ≤ 0.67 K τ, whatever σ. With three times
/// as much a ball held against a wall hummed at 80 Hz by newtons; with less the grip swings on K_max, where it has no other damper.
inline constexpr double kMostDamping = 2.0 / 3;
/// Least τ in steps [1]: half a period of the hold and one of the exchange.
inline constexpr double kLeastLag = 1.5;
/// Rate at which the force on a hand at rest may change [N/s]: 0.1 N in a tick of 1 kHz, a third of the least that is felt as a stroke. A
/// stroke of 10 N takes 0.1 s; a tool that comes free 30 mm behind its hand follows within two seconds.
inline constexpr double kForceRate = 100;

/// Most that a pointer may oppose to its hand, in the world's measures. Not part of the state: who moves the pointer tells it.
struct PointerBound {
  double stiffness = std::numeric_limits<double>::infinity();  ///< K_max [N/m]
  double force = std::numeric_limits<double>::infinity();      ///< [N]: beyond it the link stays behind its hand
  double torque = std::numeric_limits<double>::infinity();     ///< [N·m], about the link frame's origin: likewise
  double lag = 0;                ///< τ of the loop [s]; less than kLeastLag steps counts as those
  double turn_of_way = 1.25e-3;  ///< ρ² [m²]: damping of a turn over that of a way, of hand and device; infinite: it does not turn
};

/// The bound of a pointer's hand, and the stiffness that it met.
struct HandBound : PointerBound {
  Matrix3 met_W = Matrix3::Zero();                             ///< M as the last step left it [N/m]
};

/// (in realtime) Before each substep and each piece of one: M of the pointers that have a bound; virtual couplings as they hold.
void boundHands(const Model& model, const State& state, const Placement& placement, HandWork& hands) noexcept;

/// (in realtime) The law of a pointer's contact, its memory that of the last step, shape A turned by R_WA, P at `arm_W` [m] from the
/// link's origin; `period` [s].
void boundLaw(const HandBound& bound, double period, const FrictionMemory& before, const Matrix3& R_WA, const Vector3& arm_W,
              const ContactVolume& contact, PairLaw& law) noexcept;

/// (in realtime) K of pointer i, unweakened: of its contacts, or of its virtual coupling [N/m].
double stiffnessMet(const Model& model, const State& state, const Placement& placement, const HandWork& hands,
                    int pointer) noexcept;

}  // namespace haptic
