/// The part of a contact volume's boundary that neighbouring pieces of the same body cover.
#pragma once
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic {

/// (in realtime) Of the side of `owner`, whose piece lies at X_AS in A's frame. Exact for V in the workspace: each of its
/// faces that is covered is cut by the covers' outlines. Cost O(edges of V) where a covered face bounds it; null: nothing.
CoveredArea coveredArea(ContactWorkspace& workspace, Owner owner, const InnerFaces* inner, const Pose& X_AS) noexcept;

}  // namespace haptic
