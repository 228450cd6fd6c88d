/// Stiffness and damping of a contact: what the implicit step and the stability certificate linearise with.
#pragma once
#include "haptic_core/contact/contact_law.h"

namespace haptic {

/// In P's axes about P, rows and columns angular then linear, symmetric and positive semidefinite:
///   stiffness  -∂F_BP/∂(displacement of B against A) at fixed n   [N·m/rad, N/rad, N/m]
///   damping    -∂F_BP/∂(twist of B against A)                     [N·m·s/rad, N·s/rad, N·s/m]
/// With u = (θ_x, θ_y, z) the pressure at r changes by -k (1 + c ḋ)(z + θ_x y - θ_y x): the normal part is the matrix
/// of A0, A1, A2 (of V0, V1, V2 for the damper). Left out, because it is small or would break the symmetry: the turn
/// of n with the bodies, the share of friction that follows the normal force, the slope of ḋ over the patch.
/// Friction enters with the springs while sticking; while sliding across the direction of slip only, in the ratio of
/// the limit to the trial force.
struct ContactGradient {
  Matrix6 stiffness = Matrix6::Zero();
  Matrix6 damping = Matrix6::Zero();
};

/// (in realtime) At the same arguments as `contactForce`, and its result.
ContactGradient contactGradient(const ContactVolume& contact, const Twist& V_AB_P, const FrictionMemory& memory,
                                const PairLaw& law, double h, const ContactForce& force) noexcept;

}  // namespace haptic
