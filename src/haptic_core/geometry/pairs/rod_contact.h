/// The contact volume of pairs with a cylinder or a capsule.
///
/// Rod and polyhedron. A rod is the tube between the planes of its axis' ends and, of a capsule, a half ball beyond each. What
/// each piece has in common with the polyhedron is a convex solid of its own: a box around the piece is cut by the planes of the
/// polyhedron that reach it, and that by the tube (tube_cut.h) or the ball (ball_cut.h, solid_moments.h). The pieces' moments add up;
/// the faces with which they are joined are no surface. Flat ends are faces of the box. Where one plane alone reaches the rod, the
/// tube's share is a closed form and one integral (tube_on_plane.h), and a half ball's faces are two segments of discs (ball_cut.h).
/// Rod and ball: ball_rod_contact.h. Rod and rod: rod_rod_contact.h.
///
/// Error: a few 1e-13 relative, and that of the depth, some roundings of the coordinates over the depth. Cost: a cylinder 5000 to
/// 7000 instructions on a face, a capsule 13 000 to 20 000; over an edge 41 000 and 71 000. A cylinder that lies on a face and one
/// that stands on it are the same code as all between.
#pragma once
#include "haptic_core/geometry/pairs/table.h"

namespace haptic {

/// (in realtime) See table.h.
void polyhedronRodContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                          ContactVolume& out) noexcept;
void halfSpaceRodContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                         ContactVolume& out) noexcept;  ///< see above

}  // namespace haptic
