/// Instants within a step of velocity Verlet at which a contact's force jumps or bends: it touches, yields, or stops sliding.
///
/// The velocities at both ends of the step are known, so that the instants are too. Until then the trapezoidal rule takes a force that
/// was not there: what is missing is an impulse beside it.
#pragma once
#include "haptic_core/contact/located_force.h"

namespace haptic::comparators {

/// One instant within a step, and what the trapezoidal rule errs by because of it.
struct LocatedEvent {
  double at = 1;             ///< share of the step after which the contact touched, yielded or stuck; 1: none of them
  bool has_impulse = false;  ///< `impulse_P` is not zero
  Wrench impulse_P;          ///< to be added to ∫F dt by the rule, on B at P, in P's axes [N·m·s, N·s]
  Wrench elastic_P;          ///< of it that of the spring [N·m·s, N·s]
};

/// (in realtime) As `locatedForce`, with the instants of a step of length `advance.time`: into `event`. `V_AB_P`: at its end.
LocatedForce forceWithEvents(const ContactVolume& contact, const Pose& X_AB, ContactWorkspace& workspace, const Twist& V_AB_P,
                             const FrictionMemory& memory, const PairLaw& law, const Advance& advance, LocatedEvent& event) noexcept;

}  // namespace haptic::comparators
