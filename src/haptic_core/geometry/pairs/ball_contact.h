/// The contact volume of pairs with a ball.
///
/// Ball and polyhedron. V's boundary is the part of the faces in the ball (ball_cut.h) and the part of the sphere in the
/// polyhedron. Seen from the polyhedron's point o that is nearest to the ball's centre, or from the centre when that is
/// inside, every piece of the boundary faces outward, so that V and its moments are sums of cones over these pieces with no
/// term that cancels another: ∫ 1, y, y yᵀ dV = Σ ∫ (y·N/3, y·N/4 y, y·N/5 y yᵀ) dA. Over faces the integrals are closed
/// forms. On the sphere the direction u from the centre to o is the pole of Archimedes' coordinates, in which dA = R² ds dφ
/// with s = 1 - cos(angle to u); along s the integrals are closed forms, and Green's theorem makes them integrals along the
/// arcs of the faces' circles: closed where the circle is round about u (a ball on a face), else smooth functions of the
/// arc's angle for Gauss's rule, 16 points for each third of a turn.
/// Ball and ball: two spherical caps, closed forms.
/// The same integrals: S. Strobl, A. Formella, T. Pöschel, Exact calculation of the overlap volume of spheres and mesh
/// elements, Journal of Computational Physics 311 (2016); theirs are inclusion and exclusion of caps and wedges, whose terms
/// cancel where an overlap is small.
///
/// Error: a few 1e-13 relative, and that of the depth, some roundings of the coordinates over the depth. Cost: 0.15 µs on a
/// face, 3 µs over an edge, 10 µs on ten facets of a hull of 100 corners: 0.1 µs per face cut, 0.8 µs per arc. The force
/// changes by its derivative, to 1e-14 of itself, where one case turns into another.
#pragma once
#include "haptic_core/geometry/pairs/table.h"
#include "haptic_core/geometry/shapes/ball.h"

namespace haptic {

/// (in realtime) The three pairs of a ball; see table.h.
void ballsContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                  ContactVolume& out) noexcept;
void polyhedronBallContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                           ContactVolume& out) noexcept;  ///< see above
void halfSpaceBallContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                          ContactVolume& out) noexcept;  ///< see above: a cap, or all of the ball

}  // namespace haptic
