/// From a contact volume and the relative motion of its bodies to the wrench between them: the smooth form that the
/// implicit step differentiates. The explicit steps use located_force.h.
///
/// All in the patch frame P of the contact volume: origin at V's centroid, z = n (from A into B). With
/// r = (x, y), thickness d(r), and V the twist of B relative to A at P, the approach rate is
///     ḋ(r) = -(v_z + ω_x y - ω_y x).
/// Normal pressure, never negative:
///     linear          p = k d + b ḋ  where positive              (jumps at touch: the seeds' law)
///     Hunt–Crossley   p = k d (1 + c ḋ)  where positive          (continuous at touch)
/// Force ∫p dA and moment ∫ r × p n dA are sums over the moments of the volume: exact.
///
/// Friction (memory: elastic slip s and twist φ since the surfaces stuck). Two springs from one foundation k_t:
///     f = -(k_t A0 s + b_t A0 v),  τ = -(k_t J φ + b_t J ω_z),  J = ∫|r - r̄|² dA,
/// projected back on the limit surface (|f|/(μ N))² + (τ/(μ N r_τ))² ≤ 1 when outside, the anchors following
/// (elastoplastic return mapping); μ0 while stuck, μ while sliding, stuck again when the projection is not needed.
/// r_τ = ∫p|r|/N is taken as ⅔√2 of p's radius of gyration: exact for uniform pressure on a disc, 0.2 % off on a
/// square, 4 % on a line.
#pragma once
#include "haptic_core/contact/friction.h"

namespace haptic {

struct ContactForce {
  Wrench F_BP_P;              ///< on B at P, in P's axes
  double normal_force = 0;    ///< N [N]
  double damping_power = 0;   ///< dissipated by pressure and tangential dampers [W]
  double friction_power = 0;  ///< dissipated by sliding [W]
  FrictionMemory memory;      ///< at the end of the step; the caller decides whether it becomes state
  bool sticking = false;
};

/// (in realtime) A pure function: nothing is stored. `workspace` holds the V that `contact` was computed from; it is
/// scratch where the pressure changes sign inside the patch. `V_AB_P` is the twist of B relative to A at P, in P's
/// axes; `h` [s] the time over which the memory advances.
ContactForce contactForce(const ContactVolume& contact, ContactWorkspace& workspace, const Twist& V_AB_P,
                          const FrictionMemory& memory, const PairLaw& law, double h) noexcept;

}  // namespace haptic
