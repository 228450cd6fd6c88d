/// The contact volume of a ball and a rod.
///
/// Both are round about axes that a slice across the rod's axis meets in discs a fixed distance apart: V's slices are lenses of
/// two discs, whose moments are closed forms (circular_segment.h). Along the axis Gauss's rule integrates them, 16 points from
/// each of the heights at which a lens begins, ends or becomes a whole disc, half way to the next; they are spread so that the
/// lens, which grows like their power 3/2 there, is smooth. Where the ball lies on the tube alone, and not half in it, the slices
/// lie evenly about its centre: two to sixteen of them are exact to rounding. The area vector and the moments of the rod's surface
/// in the ball are integrals of the same slices.
///
/// Error 1e-9 relative, and that of the depth. Cost 7000 instructions on the tube, else 33 000 for each range of heights. For what
/// the moments do not tell (round_patch.h) the outline is an ellipse of the same moments: to 4 % at a cylinder's end.
#pragma once
#include "haptic_core/geometry/pairs/table.h"

namespace haptic {

/// (in realtime) See table.h.
void ballRodContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                    ContactVolume& out) noexcept;

}  // namespace haptic
