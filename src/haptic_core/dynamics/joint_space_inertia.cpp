#include "haptic_core/dynamics/joint_space_inertia.h"

namespace haptic {
namespace {

/// Degree k of a joint as a twist about O.
Twist axisTwist(const LinkModel& link, const LinkWork& w, int k) {
  const Vector3 zero = Vector3::Zero();
  if (link.floating) return k < 3 ? Twist{Vector3::Unit(k), zero} : Twist{zero, Vector3::Unit(k - 3)};
  return k < link.slides ? Twist{zero, w.S.col(k)} : Twist{w.S.col(k), zero};
}

/// Composite inertia of a subtree about O: inertia in A, first moment in p_force, mass in u[0].
void startComposite(const LinkModel& link, LinkWork& w) {
  w.A.noalias() = w.X_WL.R * link.I_O * w.X_WL.R.transpose();
  w.p_force = link.mass * w.p_OC;
  w.u[0] = link.mass;
}

void addComposite(const LinkWork& w, LinkWork& parent) {
  const Vector3& h = w.p_force;
  const Vector3& r = w.r;
  const double m = w.u[0];
  const Vector3 s = h + 0.5 * m * r;  // r hᵀ + h rᵀ + m r rᵀ = r sᵀ + s rᵀ
  const Matrix3 rs = r * s.transpose();
  parent.A += w.A - rs - rs.transpose();
  parent.A.diagonal().array() += 2 * r.dot(s);
  parent.p_force += h + m * r;
  parent.u[0] += m;
}

}  // namespace

void massMatrix(const Articulation& articulation, LinkWork* work, double* M) noexcept {
  const int n = articulation.linkCount(), nv = articulation.nv();
  for (int i = 0; i < nv * nv; ++i) M[i] = 0;
  for (int i = 0; i < n; ++i) startComposite(articulation.link(i), work[i]);
  for (int i = n - 1; i >= 0; --i)
    if (articulation.link(i).parent >= 0) addComposite(work[i], work[articulation.link(i).parent]);
  for (int i = 0; i < n; ++i) {
    const LinkModel& link = articulation.link(i);
    for (int k = 0; k < link.dof; ++k) {
      const LinkWork& w = work[i];
      const Twist S = axisTwist(link, w, k);
      Wrench F{w.A * S.angular + w.p_force.cross(S.linear), w.u[0] * S.linear + S.angular.cross(w.p_force)};
      const int row = link.v + k;
      for (int j = i; j >= 0; j = articulation.link(j).parent) {
        const LinkModel& above = articulation.link(j);
        const int last = j == i ? k + 1 : above.dof;
        for (int c = 0; c < last; ++c) {
          const double value = power(F, axisTwist(above, work[j], c));
          M[row * nv + above.v + c] = value;
          M[(above.v + c) * nv + row] = value;
        }
        F.torque += work[j].r.cross(F.force);
      }
    }
  }
}

void inverseDynamics(const Articulation& articulation, const Vector3& gravity, const double* vdot,
                     LinkWork* work, double* tau) noexcept {
  const int n = articulation.linkCount();
  for (int i = 0; i < n; ++i) {
    const LinkModel& link = articulation.link(i);
    LinkWork& w = work[i];
    if (link.floating) {
      w.alpha.setZero();
      w.acceleration = -gravity;
      if (vdot) {  // its axes are W's
        w.alpha = Eigen::Map<const Vector3>(vdot + link.v);
        w.acceleration += Eigen::Map<const Vector3>(vdot + link.v + 3);
      }
    } else if (link.parent < 0) {
      w.alpha = w.bias_angular;
      w.acceleration = w.bias_linear - gravity;
    } else {
      const LinkWork& parent = work[link.parent];
      w.alpha = parent.alpha + w.bias_angular;
      w.acceleration = parent.acceleration + parent.alpha.cross(w.r) + w.bias_linear;
    }
    for (int k = 0; vdot && !link.floating && k < link.dof; ++k) {
      const Twist S = axisTwist(link, w, k);
      w.alpha += vdot[link.v + k] * S.angular;
      w.acceleration += vdot[link.v + k] * S.linear;
    }
    const Matrix3& R = w.X_WL.R;
    const Vector3 momentum = R * (link.I_O * (R.transpose() * w.omega));
    w.p_torque = R * (link.I_O * (R.transpose() * w.alpha)) + link.mass * w.p_OC.cross(w.acceleration) +
                 w.omega.cross(momentum) - w.F_ext.torque;
    w.p_force = link.mass * (w.acceleration + w.alpha.cross(w.p_OC) + w.omega.cross(w.omega.cross(w.p_OC))) -
                w.F_ext.force;
  }
  for (int i = n - 1; i >= 0; --i) {
    const LinkModel& link = articulation.link(i);
    const LinkWork& w = work[i];
    if (link.floating) {
      Eigen::Map<Vector3>(tau + link.v) = w.p_torque;
      Eigen::Map<Vector3>(tau + link.v + 3) = w.p_force;
      continue;
    }
    for (int k = 0; k < link.dof; ++k) tau[link.v + k] = power({w.p_torque, w.p_force}, axisTwist(link, w, k));
    if (link.parent < 0) continue;
    work[link.parent].p_torque += w.p_torque + w.r.cross(w.p_force);
    work[link.parent].p_force += w.p_force;
  }
  for (int i = 0; i < n; ++i) work[i].acceleration += gravity;
}

}  // namespace haptic
