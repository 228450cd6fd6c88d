/// How stiff the contacts of a hand's pointer may be, so that the loop around the hand does not ring.
///
/// Who moves the pointer says what its hand bears: K_max [N/m] in the world, from the loop's rate and delay
/// (spidar/wall_bound.h). A push along n at the arm r from the pointer's origin turns the hand as well: J = (r × n/ρ, n), ρ² the hand's
/// damping of a turn over that of a way. The pointer's contacts oppose M = Σ k A0 J Jᵀ.
///
/// Direct coupling. A contact in whose direction the hand meets K_i = k A0 |J|² + Jᵀ M' J/|J|² > K_max, M' of the other contacts as
/// the last step left them, is weakened by s = K_max/K_i: k, k_t, b and b_t alike. A lone contact pushes with K_max V/A0, K_max
/// times its mean thickness. The share s follows from where the bodies are now, not from time: a spring gives back
/// on the way out the energy that it took on the way in, and no other. Of the rest λ_max(M) is up to 1.21 K_max with two contacts at an
/// angle, up to 1.37 K_max with feet in a circle. With M of ways alone a ring of eight pieces rocked.
/// Friction's springs oppose Σ k_t A (1 + r²/ρ²): in a corner two of them add up.
/// Its dampers, normal and tangential, are held to ⅔ τ K_max between them and its neighbours (`kMostDamping`), arms counted as of springs:
/// the loop's bound is on K and b together, and at 6 N a dissipation of 10 s/m is a damper of 60 N·s/m, seven times a hand's own.
/// Other pairs keep their laws, and both bodies of a weakened pair feel the same force.
/// Virtual coupling. Its hand meets the coupling in front of whatever its tool touches, and bears K and b of wall_bound.h whatever that is.
/// Where the scene leaves values to be derived the coupling has those; values beyond are lowered to them, a turn's to ρ² times. They do
/// not follow contacts or time: a coupling that were weak in touch alone would be given more than it gives back at each touch.
/// Beyond the hand's greatest force F it gives F, and beyond its greatest torque that: its parts are weakened by F / |F_c|.
///
/// A surface that carries less than F and the tool's weight is firm for the tool: its foundation is stiffer by the factor that lets it.
/// What carries is the volume that two bodies share when one is pressed on through the other. Sections A(z) of a convex body have a
/// concave √A, so a body of volume Vol and length w has somewhere at least Vol t/w in a slab of thickness t ≤ w, and the force rises up
/// to there. A twentieth of that, k/20 · min(Vol t/w), over both bodies in the parts of slab and tool, with 2 bounding radii for w and
/// the least width for t, is to be F + m |g|. It depends on the two shapes alone, so the surface has a potential as any has. Without it
/// the tool hung in a plate that carries less than it weighs, and the hand felt the weight where it pressed. A tool with more energy than
/// the surface takes goes through all the same, and edges, where less is shared, give way as the penalty model says.
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

class ConvexShape;
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
  double stiffness = std::numeric_limits<double>::infinity();  ///< K_max of a wall, K of a virtual coupling [N/m]
  double force = std::numeric_limits<double>::infinity();      ///< [N]: beyond it a held link stays behind its hand, a spring gives it
  double torque = std::numeric_limits<double>::infinity();     ///< [N·m], about the pointer frame's origin: likewise
  double damping = std::numeric_limits<double>::infinity();  ///< largest damper of a virtual coupling [N·s/m]; infinite: its own
  double press = 0;              ///< greatest force ever [N], that surfaces carry under a virtual coupling's link; 0: as they are
  double lag = 0;                ///< τ of the loop [s]; less than kLeastLag steps counts as those
  double turn_of_way = 1.25e-3;  ///< ρ² [m²]: damping of a turn over that of a way, of hand and device; infinite: it does not turn
};

/// The bound of a pointer's hand, and the stiffness that it met.
struct HandBound : PointerBound {
  Matrix6 met_W = Matrix6::Zero();                             ///< M as the last step left it, of turns times ρ and ways [N/m]
};

/// (in realtime) Before each step: M of the pointers that have a bound; virtual couplings as they hold.
void boundHands(const Model& model, const State& state, const Placement& placement, HandWork& hands) noexcept;

/// (in realtime) The law of a pointer's contact, its memory that of the last step, shape A turned by R_WA, P at `arm_W` [m] from the
/// link's origin; `period` [s].
void boundLaw(const HandBound& bound, double period, const FrictionMemory& before, const Matrix3& R_WA, const Vector3& arm_W,
              const ContactVolume& contact, PairLaw& law) noexcept;

/// Factor on a foundation k [N/m³] between two shapes of these least widths [m] that lets it carry `force` [N]; 1: it does.
double firmer(double force, const ConvexShape& a, const ConvexShape& b, double width_a, double width_b, double k) noexcept;
/// (in realtime) The law of a pair on which a hand presses with `force` [N]: as firm as carries that, where it is not.
void firm(const Model& model, double force, int a, int b, PairLaw& law) noexcept;

/// (in realtime) K of pointer i, unweakened: of its contacts, or of its virtual coupling [N/m].
double stiffnessMet(const Model& model, const State& state, const Placement& placement, const HandWork& hands,
                    int pointer) noexcept;

}  // namespace haptic
