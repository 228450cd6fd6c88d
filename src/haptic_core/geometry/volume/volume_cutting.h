/// The readable algorithm: A cut by one plane of B after the other.
#pragma once
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic {

/// Leaves V's vertices, faces and edges in the workspace; false when nothing is left of A. `complete` is
/// cleared when the workspace was too small. (in realtime) Cost: (faces of B that cut) × (size of the
/// rest).
bool cutVolume(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
               ContactWorkspace& workspace, bool& complete) noexcept;

/// The same of what one plane leaves of a shape that lies at X_AS; its faces belong to `owner`. (in realtime)
bool cutVolume(const ConvexPolyhedron& shape, const Pose& X_AS, Owner owner, const ContactFace& plane,
               ContactWorkspace& workspace, bool& complete) noexcept;

/// The same plane by plane: begins with a box, whose faces have the index -1. (in realtime)
void startBox(const Vector3& lower, const Vector3& upper, ContactWorkspace& workspace) noexcept;
/// Cuts it by a plane; false when nothing is left. The rest is the workspace's `solid`; `complete` is cleared when that was too
/// small. (in realtime)
bool cutSolid(const ContactFace& plane, ContactWorkspace& workspace, bool& complete) noexcept;

}  // namespace haptic
