/// How near a contact brings a body to the limit of explicit steps. The choice between explicit and implicit rests
/// on it; it is cheap enough to be computed while running. The certificate has the exact, coupled limit.
///
/// An explicit step is stable while λ_max(M⁻¹(h²K + 2hD)) < 4 (certificate.h). With the island's K and D as sums over
/// contacts c, |x - y|² ≤ 2|x|² + 2|y|² between two bodies that both move, and a link of a tree moving no more easily
/// than it would alone (on its joint if that hangs on the world, else free),
///     λ_max ≤ max over links l of Σ over the contacts of l of w_c λ_max(W_lc (h²K_c + 2hD_c)),
/// W_lc the link's mobility at the patch when alone, w_c = 2 where both bodies move and 1 where one does.
/// λ_max of one contact is taken as (tr (W G)⁸)^⅛: never below it, at most 25 % above.
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/contact/located_force.h"
#include "haptic_core/dynamics/articulation.h"

namespace haptic {

/// The scale of all numbers: explicit steps are unstable from here on.
constexpr double kStabilityBound = 4;

/// Mobility ∂V/∂F of a link at P in P's axes, angular first, as if there were nothing but its own joint: on the world by that, or
/// free. R_WL and p_WC as in kinematics.h.
Matrix6 ownMobility(const LinkModel& link, const Matrix3& R_WL, const Vector3& p_WC, const Pose& X_WP) noexcept;

/// Share of one contact for one of its links of mobility W. Velocity Verlet settles strong dampers contact by contact
/// (stepping/settled_damper.h): with x = λ_max(h W D) the damper counts 2x/(1 + x/2) instead of 2x. (in realtime) 0.5 µs.
double stabilityNumber(const PatchTangent& tangent, const Matrix6& W, bool both_move, double h) noexcept;

}  // namespace haptic
