/// How far a pointer's link follows its hand: a proxy, so that no tool is swallowed and no force passes the hand's bound.
///
/// Direct coupling ties the link to the hand's target rigidly. That ends where the link would
///   - sink through the link that it presses on. h: the overlap of the two shapes along the contact's normal n; H: the lesser extent of the
///     two along n. Of pieces of a body, kOnSeam, h is V's depth, and where neighbours cover a piece's back, extent and depth are the
///     whole body's; a foot that sticks out ends at its own back. The area vector vanishes where h = H at the latest: a tool wholly
///     inside, bars that cross, a ball through a plate. There n is the last one (contact_volume.h), the force has no stiffness, and the
///     link would come out at the other side. So h ≤ η H.
///     η = 0.9: a ball carries 0.972 k Vol, a box flat on a wall 0.9 k Vol. η = 0.5 where the hand's stiffness bound weakens the
///     contact (hand_bound.h): its force K_max Vol/A0 has a slope of at most K_max only while A0 grows, up to the middle.
///   - press harder than the bound of its hand: |Σ f| ≤ F, |Σ r × f| ≤ T, f the springs' force of pressure and friction together, r from
///     the link's origin.
/// Beyond that the link stays behind and the hand goes on. With δ the link's motion [rad, m] and δ* the whole way to the target,
///     minimise (δ - δ*)ᵀ M (δ - δ*) over J_i δ ≤ c_i,   M = diag(ρ² 1, 1),
/// a row per touching contact (how much deeper it may go), and |F + J δ| ≤ F, |T + J δ| ≤ T, linear in the stiffness k A0 and, on the
/// way in, the damper over the time left; these two are balls, met by Newton's method on the Lagrangian. They take a contact with
/// friction as equally stiff along its normal and across, so the link rests where the force on it points at the target, as of a hand
/// that pulls with F: within the friction cone it sticks. With the pressure's force alone it came to rest on the normal through the
/// target, and under a hand 50 mm below a cube it went along by 50 mm times the cube's tilt, dragged the top on and made the cube rock.
/// It is the god object of Zilles & Salisbury (1995), six-dimensional as by Ortega, Redon and Coquillart (2007), with compliant surfaces:
/// the force is that of the contact where the link is, so it stays while the hand goes deeper, falls on the way back from the depth at
/// which it was reached, and rubs, for the link follows along the surface. Along a row the force is a function of the link's pose alone and
/// that is the point nearest to the target: where the contact's stiffness is at most K, the force changes by at most K times the hand's
/// way.
/// ρ is ten times the link's reach: it keeps the hand's orientation unless two contacts hold it against one another.
/// What dampers and friction add within one step, before the next rows know it, Hand bounds (loop/hand.cpp).
///
/// A virtual coupling pulls its link from the target itself, up to the hand's force F: a spring of the potential K e²/2 for K e ≤ F and
/// F (e - F/2K) beyond, e the way from the link to the target, and likewise of turns. It takes nothing from the contacts and follows
/// none of them: whatever its tool touches is then a passive world, and wall_bound.h says what a hand bears in front of one. Surfaces
/// are as firm for it as carries F beside the tool's weight (hand_bound.h); a tool that is thrown through a thin body is through.
///
/// Where no row is active the goal is the target, bit for bit. Nothing is remembered: rows are made of the contacts where the bodies are.
/// Cost: once more the geometry of each contact that touches a held link; where a row is active a few 6×6 systems.
#pragma once
#include <vector>

#include "haptic_core/geometry/volume/loaded_vector.h"
#include "haptic_core/world/state.h"

namespace haptic {

class Model;
struct Work;

/// Largest share of the lesser extent that a held link sinks into the link that it presses on, unweakened and weakened [1]. Above 0.95 the
/// area of a ball's contact changes by more than its size within a tick of 0.1 mm.
inline constexpr double kMostSunk = 0.9, kMostSunkWeakened = 0.5;

/// η of a contact of foundation k [N/m³] where a solid of `volume` [m³] has the extent H [m] along n, `bound` K_max [N/m].
double mostSunk(double bound, double k, double volume, double H) noexcept;

/// One bound on the motion of a held link: J δ ≤ room.
struct ProxyRow {
  Vector6 J = Vector6::Zero();  ///< of the link's twist at L's origin, in W
  double room = 0;              ///< [m], or [N], [N·m] for the rows of force and torque
  double weight = 0, over = 0, along = 0;  ///< of `nearestMotion`; `over` is J δ - room at the end
  double pull() const noexcept { return over > 0 ? weight * over : 0.0; }  ///< multiplier, once solved
};

/// Scratch of `aimHeld`.
struct ProxyWork {
  static constexpr int kMostRows = 34;     ///< contacts beyond 32 do not stop a link: others do
  LoadedVector<ActivePair> pairs;          ///< copies of those that touch held links
  std::vector<Pose> X_WS;                  ///< by shape, of those pairs
  LoadedVector<ProxyRow> rows;             ///< of one link

  explicit ProxyWork(const Model& model);  ///< set-up: room for all of them
};

/// (in realtime) The motion within at most kMostRows rows that is nearest to `wanted`; false: it is `wanted` itself. Exact: Newton's method
/// with the exact step along each direction, rows as springs 1e8 times as stiff as the metric, then once more with the ways that they gave.
/// Rows that exclude one another share the missing way.
bool nearestMotion(LoadedVector<ProxyRow>& rows, const Matrix6& metric, const Vector6& wanted, Vector6& motion) noexcept;

/// (in realtime) Goals of the pointers' links for the `left` seconds to the end of the step, into `work.hands.goal`.
void aimHeld(const Model& model, const State& state, double left, Work& work) noexcept;

}  // namespace haptic
