/// The default row of the table of pairs: a polyhedron stands in for a shape that has no row of its own.
///
/// Of the two, the shape whose kind comes later in ShapeKind is replaced by its tessellation, and the table is asked again; the other one
/// stays true if it has a row with polyhedra. Of two of a kind the one whose tessellation is the closer is replaced; of two alike both
/// are, since their order decides nothing. So a new kind meets all others as soon as it has a support function (support_shape.h), and
/// rows of its own replace this one pair by pair.
///
/// Error: the surface in contact is off by at most `tessellationError` of each shape that is replaced; V by that times the patch's
/// area, so that shapes less deep than that may not touch. Between facets the normal changes as a polyhedron's does. Distance, time of
/// impact and bounds are those of the true shapes (`coresDistance`). libccd answers the same questions, and tests hold both against
/// each other; it is not linked here, for its bits are those of its own build (compilers fuse multiplications on some processors),
/// while a recording must replay on all. Cost: that of the row that serves. (in realtime)
#pragma once
#include "haptic_core/geometry/pairs/table.h"

namespace haptic {

/// (in realtime) See table.h.
void standInContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                    ContactVolume& out) noexcept;
/// Room for the pair with either of the two replaced.
void standInRoom(const ConvexShape& first, const ConvexShape& second, ContactWorkspace& workspace);

}  // namespace haptic
