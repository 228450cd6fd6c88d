/// The contacts of an explicit step, evaluated here and now: wrenches on links, memories, impulses of events, the books.
#pragma once
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {

/// (in realtime) Of all pairs of which neither body is stepped implicitly. Velocity Verlet: second order; see Advance.
void evaluateContacts(const Model& model, const Advance& advance, State& state, Work& work, Report& report) noexcept;

/// Data of a contact for the next step.
ReleaseMemory releaseOf(const ContactVolume& volume, const Twist& V_AB_P, const Pose& X_WP, const LocatedForce& force) noexcept;

}  // namespace haptic::stepping
