/// Residuals of the rigid law of contact, as ContactBench (Le Lidec and others, 2023) counts them, and the force of a contact from the
/// motion of the bodies that it carries, which no engine is asked for.
///
/// n: normal, from the lower body to the upper one; F: force on the upper body; v: velocity of the upper body over the lower one at the
/// contact, after the step. F = N n + T, v = v_n n + u.
#pragma once
#include <algorithm>
#include <cmath>

#include "haptic_core/world/definition.h"
#include "report_scene.h"

namespace haptic::report {

/// All zero for the rigid law.
struct RigidResiduals {
  double signorini = 0;    ///< |N v_n| [W]: a force where the bodies part or approach
  double gap_work = 0;     ///< |N gap| [J]: a force at a distance, or in a depth (gap < 0)
  double coulomb = 0;      ///< distance of F from the cone |T| ≤ μ N [N]; of a pull too
  double dissipation = 0;  ///< μ N |u| + T·u [W], N ≥ 0: what friction of the largest power would take beyond what this takes
};

/// Distance of (N, |T|) from the cone |T| ≤ μ N [N]: 0 within, the length within the polar cone μ |T| ≤ -N, else that from the edge.
inline double distanceFromCone(double normal, double tangential, double mu) {
  if (tangential <= mu * normal) return 0;
  if (mu * tangential <= -normal) return std::hypot(normal, tangential);
  return (tangential - mu * normal) / std::hypot(1, mu);
}

inline RigidResiduals rigidResiduals(const Vector3& n, const Vector3& F, const Vector3& v, double gap, double mu) {
  const double N = n.dot(F), v_n = n.dot(v);
  const Vector3 T = F - N * n, u = v - v_n * n;
  RigidResiduals out;
  out.signorini = std::abs(N * v_n);
  out.gap_work = std::abs(N * gap);
  out.coulomb = distanceFromCone(N, T.norm(), mu);
  out.dissipation = std::abs(mu * std::max(N, 0.0) * u.norm() + T.dot(u));
  return out;
}

/// Linear and angular momentum of a body about W's origin, in W [N·s], [N·m·s].
struct BodyMomentum {
  Vector3 p_WC, linear, angular;

  BodyMomentum(const LinkInertia& m, const BodyState& s) {
    const Vector3 arm = s.X_WL.R * m.p_LC;
    p_WC = s.X_WL.p + arm;
    linear = m.mass * (s.V_WL.linear + s.V_WL.angular.cross(arm));
    angular = s.X_WL.R * (m.I_C * (s.X_WL.R.transpose() * s.V_WL.angular)) + p_WC.cross(linear);
  }
};

/// Mean wrench on a body in a step of h [s], its weight left out, about W's origin, in W: the change of its momenta. Exact for the force;
/// for the torque if the centre of mass moves by the mean of its speeds.
inline Wrench beyondWeight(const LinkInertia& m, const BodyState& before, const BodyState& after, const Vector3& gravity, double h) {
  const BodyMomentum from(m, before), to(m, after);
  const Vector3 weight = m.mass * gravity;
  Wrench F;
  F.force = (to.linear - from.linear) / h - weight;
  F.torque = (to.angular - from.angular) / h - (0.5 * (from.p_WC + to.p_WC)).cross(weight);
  return F;
}

/// Where a wrench about W's origin pierces the plane through q across n: there it turns about n alone. q where it presses by less than
/// `least` [N].
inline Vector3 centreOfPush(const Wrench& F, const Vector3& n, const Vector3& q, double least) {
  const double N = n.dot(F.force);
  return N > least ? Vector3(q + n.cross(F.shifted(q).torque) / N) : q;
}

/// Velocity of a body's point p_W [m/s].
inline Vector3 velocityAt(const BodyState& s, const Vector3& p_W) {
  return s.V_WL.linear + s.V_WL.angular.cross(p_W - s.X_WL.p);
}

}  // namespace haptic::report
