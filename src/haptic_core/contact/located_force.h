/// From a contact volume and the relative motion of its bodies to the wrench between them.
///
/// Everything in the patch frame P of the contact volume: origin at V's centroid, z = n (from A into B), on B.
/// Pressure: pressure_law.h. Friction: friction.h. Both are integrals over the patch; the wrench about P is
///     force (f, N),   torque (∫y p, -∫x p, τ).
#pragma once
#include "haptic_core/contact/friction.h"

namespace haptic {

struct LocatedForce {
  Wrench F_BP_P;              ///< on B at P, in P's axes
  double normal_force = 0;    ///< N [N]
  FrictionMemory memory;      ///< at this evaluation; the caller decides whether it becomes state
  bool sticking = false;
  bool clipped = false;       ///< the damper would pull somewhere: the pressure is held at 0 there
  double event = 1;           ///< share of the step after which it touched, yielded or stuck; 1: none of them
  bool has_impulse = false;   ///< `impulse` is not zero
  Wrench impulse_P;           ///< what the trapezoidal rule over the step misses because of that [N·m·s, N·s]
};

/// ∂F/∂V of a patch: F(V + δ) ≈ F(V) - D δ, about P in P's axes, angular first [N·m·s/rad … N·s/m]. Dampers, and the
/// springs' share that the velocity moves within the step (advance.time · (1 - old_share) k_t).
Matrix6 contactDamping(const ContactVolume& contact, const PairLaw& law, bool sticking, const Advance& advance) noexcept;

/// ∂F/∂x likewise: F ≈ F - K x for a small displacement x of B against A with the normal held [N·m/rad … N/m].
Matrix6 contactStiffness(const ContactVolume& contact, const PairLaw& law, bool sticking) noexcept;

/// (in realtime) A pure function: nothing is stored. `workspace` holds the V that `contact` was computed from; it is
/// scratch where the pressure changes sign inside the patch. `V_AB_P` is the twist of B relative to A at P, in P's
/// axes.
LocatedForce locatedForce(const ContactVolume& contact, ContactWorkspace& workspace, const Twist& V_AB_P,
                          const FrictionMemory& memory, const PairLaw& law, const Advance& advance) noexcept;

}  // namespace haptic
