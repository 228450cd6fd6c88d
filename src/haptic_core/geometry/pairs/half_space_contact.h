/// The contact volume of pairs with a half-space: what its plane cuts off.
///
/// n is the plane's normal, however deep the other shape lies. A polyhedron is cut by the plane (volume_cutting.h), a ball is a cap
/// or all of it (ball_contact.h), a rod is cut as by a face (rod_contact.h). Errors are those of these; cost of a polyhedron: that of
/// going through its corners and faces.
#pragma once
#include "haptic_core/geometry/pairs/table.h"

namespace haptic {

/// (in realtime) See table.h.
void halfSpacePolyhedronContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                                ContactVolume& out) noexcept;

}  // namespace haptic
