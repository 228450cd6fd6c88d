/// The seeds' point-based penalty, for comparison with the volume: a spring at the most penetrating point.
#pragma once
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic {

/// (in realtime) Turns a contact volume into a point contact with the same normal. The point is the vertex of
/// V that lies farthest inside the other body along n, its depth d the thickness of V there. The result is a
/// patch of `area` [m²] without extent, volume area·d: through any contact law it acts as a spring of k·area
/// [N/m] at that point, and gives no moment about it. The workspace is emptied, since the contact no longer
/// describes V. Ties (a face flat on a face) go to the first vertex: the point jumps between corners,
/// which is the method's known defect.
void concentrate(ContactWorkspace& workspace, double area, ContactVolume& contact) noexcept;

/// Area [m²] that stands for a shape in the point model: a sixth of its surface. For a cube that is one face,
/// so that it is as stiff at a point as the volume model makes it on its face. Of ground without end infinite: the other shape's counts.
double pointArea(const ConvexShape& shape);

}  // namespace haptic
