/// The contact volume of two rods: cylinders and capsules in any pose, exactly (rod_integral.h).
///
/// Nothing jumps where the axes become parallel, nor where an end enters. One exception is the model's own:
/// two cylinders of equal radii, aligned end on end, have a volume whose gradient across has no value there.
/// Cost: 7400 instructions where sides cross; with an end in the contact some 10 000 for each piece between
/// breaks, of capsules 30 000.
#pragma once
#include "haptic_core/geometry/contact_volume.h"
#include "haptic_core/geometry/rod.h"

namespace haptic {

/// (in realtime) See round_contact.h.
void rodRodContact(const Rod& A, const Rod& B, const Pose& X_AB, PairCache& cache,
                   ContactWorkspace& workspace, ContactVolume& out, NormalRule rule) noexcept;

}  // namespace haptic
