/// The contact volume of pairs with a half-space: what its plane cuts off.
///
/// n is the plane's normal, however deep the other shape lies. A polyhedron is cut by the plane (volume_cutting.h), a ball is a cap
/// or all of it (ball_contact.h), a rod is cut as by a face (rod_contact.h). Errors are those of these; cost of a polyhedron: that of
/// going through its corners and faces.
#pragma once
#include "haptic_core/geometry/contact_volume.h"

namespace haptic {

/// (in realtime) One of the two is a half-space. Two of them never touch: neither moves.
void halfSpaceContact(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, PairCache& cache, ContactWorkspace& workspace,
                      ContactVolume& out, NormalRule rule, const InnerSides& inner) noexcept;

}  // namespace haptic
