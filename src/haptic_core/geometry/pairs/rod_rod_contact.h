/// The contact volume of two rods: cylinders and capsules in any pose, exactly (rod_integral.h).
///
/// Nothing jumps where the axes become parallel, nor where an end enters. One exception is the model's own:
/// two cylinders of equal radii, aligned end on end, have a volume whose gradient across has no value there.
/// Cost with AVX: 5000 instructions where sides cross, cylinders with an end in the contact 16 000 to 26 000, capsules 17 000 to 45 000,
/// and 100 000 where they are nearly parallel, since their outline changes at many heights.
#pragma once
#include "haptic_core/geometry/pairs/table.h"

namespace haptic {

/// (in realtime) See table.h.
void rodRodContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                   ContactVolume& out) noexcept;

}  // namespace haptic
