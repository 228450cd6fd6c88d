/// The contact volume of an ellipsoid with a half-space or a polyhedron.
///
/// Let M = diag(radii)/g with g³ the product of the radii. x = M y makes the ellipsoid of a ball of radius g, and of the other
/// shape's planes planes; since det M = 1, V and its moments come from those of the ball's V (ball_cut.h, solid_moments.h) by
///     V = V_y,   ∫x = M ∫y,   ∫x xᵀ = M (∫y yᵀ) M,   area vectors  S = M⁻¹ S_y.
/// A face's share of the patch goes the same way: with s = |M⁻¹ n_y| its normal is M⁻¹ n_y/s and its area s times that in y. So an
/// ellipsoid on a plane is a cap, a closed form, and on edges and corners it is computed as a ball.
///
/// Error: that of a ball, times the ratio of the largest to the least radius. Cost: that of a ball, and of mapping the polyhedron's
/// corners and planes (some 10 ns each). (in realtime)
#pragma once
#include "haptic_core/geometry/pairs/table.h"

namespace haptic {

/// (in realtime) See table.h.
void halfSpaceEllipsoidContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                               ContactVolume& out) noexcept;
void polyhedronEllipsoidContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                                ContactVolume& out) noexcept;  ///< likewise

}  // namespace haptic
