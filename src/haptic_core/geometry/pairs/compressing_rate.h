/// Which part of an approach rate makes the overlap of two bodies thicker: one projection from their symmetries.
///
/// Over a patch at P, of tangents x, y and normal n, a twist of B over A makes the approach rate ρ + s·r, with s = (ω·y, -ω·x). Motions
/// that leave V congruent must cost a damper nothing. Those that slide or turn along the patch have neither ρ nor s. Turns of A or B
/// about axes e through p that move their surfaces along themselves (ConvexShape::ownTurns) have
///     s_e = (e·y, -e·x),   ρ_e = -e·((P - p) × n).
/// With S = Σ s_e s_eᵀ over the axes of both, the turns w_e = s_eᵀ S⁻¹ s have the slope s: taken away they leave ρ - Σ w_e ρ_e and no
/// slope, and S⁻¹ = 0 where no axis has that slope. The projection is oblique: a coin on its edge turns about its axis, at the angle θ
/// to n, *and* about n, which costs nothing, so that a slope takes 1/sin θ of spin. A translation along n is kept as it is, whatever turns
/// there are.
///
/// Where |w| grows without bound, at eigenvalues μ → 0 of S (a coin that stands on its face, rods nearly parallel), the motion is no
/// rolling any more: the whole patch stays pressed, and rocks. With the tilt's tangent t, t² = μ/(1 - μ), mean thickness D and variance
/// σ² of V along the patch, thickness changes over the patch by less than its mean where m = t² σ²/D² < 1. There the share (1 - m)² of
/// that slope is left: 1 at rest, and smoothly 0 where the patch parts from the body's far side.
#pragma once
#include "haptic_core/geometry/volume/contact_volume.h"

namespace haptic {

/// (in realtime) Of B over A at the patch of `contact`. Cost: 150 instructions where neither or one body is a polyhedron.
CompressingRate compressingRate(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, const ContactVolume& contact) noexcept;

}  // namespace haptic
