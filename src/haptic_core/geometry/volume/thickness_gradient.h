/// How the elastic energy of a foundation changes with the place of a body: the contact wrench that has a potential.
///
/// U = ½ k ∫ d² dA, d the thickness of V along n. With n held still, moving B's surface by u changes d by -u·N/(N·n) over a
/// face of outward normal N:
///     F_B = -k Σ_B N ∫ d dS,   T_B = -k Σ_B (∫ d p dS) × N,   sums over the faces of V that are B's.
/// These are pressures k d on B's own surface. Turning n by φ, V held still, is turning V by -φ:
///     ∂U/∂φ = -k τ,   τ = Σ_{A and B} (∫ d p dS) × N.
/// n = S/|S| follows the seam, where V's two sides meet. An edge of it along t, of length l and with its middle at p, between
/// faces of normals N_a and N_b, moves δS = Σ l N_a (u(p)·N_b)/s, s = N_b·(t × N_a). So the turn of n adds
///     k Σ (m·N_a) l/s N_b at p,   m = τ × n/|S|.
/// k V n leaves out the tilt of the faces and this turn. The two laws are one where n is the normal of a flat side that presses
/// evenly, and they differ where edges and corners cross.
///
/// U itself has a kink where a face of V stands along n: the one-sided derivatives differ by a moment of k d³ l/6 for a wall
/// of width l. The mean of the two is taken there. Walls of A and B that meet at less than 0.6 degrees count as nearly one: the turn
/// of n then adds less, for the edge would run past them within a fraction of a step.
#pragma once
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic {

/// (in realtime) -∂/∂x (½ ∫ d² dA), the wrench per k on B about P in P's axes [m⁴, m³], of the V in the workspace (kOverlap).
/// Round shapes have V n, which is the same between two balls and on faces. Cost: about twice that of `thicknessSquared`.
Wrench thicknessGradient(ContactWorkspace& workspace, const ContactVolume& contact) noexcept;

}  // namespace haptic
