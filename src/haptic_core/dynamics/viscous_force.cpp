/// A viscous fluid that rests in A, in a box of A's axes or everywhere: Stokes' drag of a ball of B's reach r about its centre of mass,
///     f = -6 π μ r v,   τ = -8 π μ r³ ω,
/// times the share of the ball's extent along each axis that lies within the box: a ball that dips in halfway feels half. No added mass, no
/// lift; Stokes' law holds for a Reynolds number ρ v r/μ below 1.
#include "haptic_core/dynamics/force_kinds.h"

namespace haptic {

void actAsViscousField(const double* parameter, const ForceEnds& ends, LinkForce& force) noexcept {
  const double *lower = parameter + kViscousLowerX, *upper = parameter + kViscousUpperX, r = ends.size_b;
  const Pose X_WA = ends.X_WA();
  const Vector3 p_WC = ends.b->p_WC();
  force.place(ends, p_WC, p_WC);
  const Vector3 p_AC = X_WA.R.transpose() * (p_WC - X_WA.p);
  double share = 1;
  force.bends = ends.a != nullptr;  // A's lever to B's centre changes
  for (int i = 0; i < 3; ++i) {
    const double from = std::max(lower[i], p_AC[i] - r), to = std::min(upper[i], p_AC[i] + r);
    if (from == p_AC[i] - r && to == p_AC[i] + r) continue;  // wholly within
    share *= std::max(0.0, to - from) / (2 * r);
    force.bends = true;
  }
  const double drag = 6 * M_PI * parameter[kViscosity] * r * share, brake = 8 * M_PI * parameter[kViscosity] * r * r * r * share;
  force.way_D.diagonal().setConstant(drag);
  force.turn_D.diagonal().setConstant(brake);
  force.F.force = -drag * force.V.linear;
  force.F.torque = -brake * force.V.angular;
}

}  // namespace haptic
