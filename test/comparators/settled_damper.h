/// Dampers that are strong for an explicit step.
///
/// At a predicted velocity alone velocity Verlet would be stable only up to h λ(W D) < 1, W the mobility of the bodies at P.
/// Beyond kStrongDamper the end velocity is solved for, as far as this contact moves it: δ = h/2 W (F - F_before - D δ).
/// That makes the damper's part of the step the trapezoidal rule, stable for any D, and changes the force by O(h²) only.
/// Whether the patch yields is decided at the settled velocity. Where a contact begins there is no force before, and the step takes as
/// much of the damper as it can.
#pragma once
#include "haptic_core/world/contact_evaluation.h"
#include "haptic_core/world/work.h"
#include "located_events.h"
#include "verlet_memory.h"

namespace haptic::comparators {

/// (in realtime) Fills the force of a located contact, and its event within the step. `on_link` counts the contacts that share a body's
/// mass: with the mass whole, dampers that settle without regard to one another would correct a body between hand and
/// floor twice; shared out, their sum is stable however many there are (mass splitting: Tonge, Benevolenski, Voroshilov,
/// Mass splitting for jitter-free parallel rigid body simulation, 2012).
void settleForce(const Model& model, const ActivePair& pair, const ReleaseMemory& last, const std::vector<int>& on_link,
                 const Advance& advance, Work& work, ContactEvaluation& contact, LocatedEvent& event) noexcept;

}  // namespace haptic::comparators
