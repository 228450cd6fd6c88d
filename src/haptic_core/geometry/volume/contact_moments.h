/// Volume and area integrals of V from its edges.
#pragma once
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic {

/// |S| below this share of the seam's own area: S is a remainder of rounding (1e-16) or of opposite ends that
/// cancel, and its direction means nothing. Larger, and normals better than 1e-9 rad are thrown away.
constexpr double kVanishing = 1e-6;

/// Sine of the angle between n and a face's normal that is rounding of n.
constexpr double kFlush = 1e-12;

/// (in realtime) Fills everything of `out` from the vertices, faces and edges in the workspace, and the
/// cache's normal. False when the edges enclose no volume. A and B are asked for the shortest way out where V has no direction;
/// they may be null if the request prescribes the normal.
bool integrateContact(ContactWorkspace& workspace, const ConvexPolyhedron* A, const ConvexPolyhedron* B,
                      const Pose& X_AB, PairCache& cache, const ContactRequest& request,
                      ContactVolume& out) noexcept;

/// Rotation whose z axis is unit `n`; x and y are a function of n alone (Duff et al. 2017, smooth except
/// across the plane n.z = 0).
Matrix3 patchAxes(const Vector3& n);

/// Of all faces of two polyhedra the outward direction (from A to B) along which B has to move least to leave A.
Vector3 shortestWayOut(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB) noexcept;

}  // namespace haptic
