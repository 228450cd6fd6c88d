/// The contact of the seeds and of other simulators, for comparison with the volume: a spring at the most penetrating point.
#pragma once
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic::comparators {

/// (in realtime) `WorldSettings::contact_model`. Turns a contact volume into a point contact with the same normal. The point is the vertex
/// of V that lies farthest inside the other body along n, its depth d the thickness of V there. The result is a patch without extent, of
/// volume area·d: through any contact law it acts as a spring of k·area [N/m] at that point, and gives no moment about it. The area is a
/// sixth of the smaller surface; for a cube that is one face, so that it is as stiff at a point as the volume makes it on its face. The
/// workspace is emptied, since the contact no longer describes V. Ties (a face flat on a face) go to the first vertex: the point jumps
/// between corners, which is the method's known defect.
void pointContact(const ConvexShape& A, const ConvexShape& B, ContactWorkspace& workspace, ContactVolume& contact) noexcept;

}  // namespace haptic::comparators
