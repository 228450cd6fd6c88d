#include "haptic_core/dynamics/joint_space_inertia.h"

#include <cmath>

namespace haptic {
namespace {

/// Axis k of a joint as a twist about O.
Twist axisTwist(JointType type, const LinkWork& w, int k) {
  const Vector3 zero = Vector3::Zero();
  switch (type) {
    case JointType::kPrismatic:
      return {zero, w.S.col(0)};
    case JointType::kPlanar:
      return k < 2 ? Twist{zero, w.S.col(k)} : Twist{w.S.col(2), zero};
    case JointType::kFloating:
      return k < 3 ? Twist{Vector3::Unit(k), zero} : Twist{zero, Vector3::Unit(k - 3)};
    default:
      return {w.S.col(k), zero};
  }
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
      const Twist S = axisTwist(link.type, w, k);
      Wrench F{w.A * S.angular + w.p_force.cross(S.linear), w.u[0] * S.linear + S.angular.cross(w.p_force)};
      const int row = link.v + k;
      for (int j = i; j >= 0; j = articulation.link(j).parent) {
        const LinkModel& above = articulation.link(j);
        const int last = j == i ? k + 1 : above.dof;
        for (int c = 0; c < last; ++c) {
          const double value = power(F, axisTwist(above.type, work[j], c));
          M[row * nv + above.v + c] = value;
          M[(above.v + c) * nv + row] = value;
        }
        F.torque += work[j].r.cross(F.force);
      }
    }
  }
}

bool factorLtl(const Articulation& articulation, double* M) noexcept {
  const int nv = articulation.nv();
  const int* parent = articulation.dofParent().data();
  for (int k = nv - 1; k >= 0; --k) {
    double* row = M + k * nv;
    if (!(row[k] > 0)) return false;
    row[k] = std::sqrt(row[k]);
    const double inverse = 1 / row[k];
    for (int i = parent[k]; i >= 0; i = parent[i]) row[i] *= inverse;
    for (int i = parent[k]; i >= 0; i = parent[i])
      for (int j = i; j >= 0; j = parent[j]) M[i * nv + j] -= row[i] * row[j];
  }
  return true;
}

void solveLtlHalf(const Articulation& articulation, const double* L, double* x) noexcept {
  const int nv = articulation.nv();
  const int* parent = articulation.dofParent().data();
  for (int i = nv - 1; i >= 0; --i) {
    x[i] /= L[i * nv + i];
    for (int j = parent[i]; j >= 0; j = parent[j]) x[j] -= L[i * nv + j] * x[i];
  }
}

void solveLtl(const Articulation& articulation, const double* L, double* x) noexcept {
  solveLtlHalf(articulation, L, x);
  const int nv = articulation.nv();
  const int* parent = articulation.dofParent().data();
  for (int i = 0; i < nv; ++i) {
    for (int j = parent[i]; j >= 0; j = parent[j]) x[i] -= L[i * nv + j] * x[j];
    x[i] /= L[i * nv + i];
  }
}

void inverseDynamics(const Articulation& articulation, const Vector3& gravity, const double* vdot,
                     LinkWork* work, double* tau) noexcept {
  const int n = articulation.linkCount();
  for (int i = 0; i < n; ++i) {
    const LinkModel& link = articulation.link(i);
    LinkWork& w = work[i];
    if (link.type == JointType::kFloating) {
      w.alpha.setZero();
      w.acceleration = -gravity;
    } else if (link.parent < 0) {
      w.alpha = w.bias_angular;
      w.acceleration = w.bias_linear - gravity;
    } else {
      const LinkWork& parent = work[link.parent];
      w.alpha = parent.alpha + w.bias_angular;
      w.acceleration = parent.acceleration + parent.alpha.cross(w.r) + w.bias_linear;
    }
    if (vdot)
      for (int k = 0; k < link.dof; ++k) {
        const Twist S = axisTwist(link.type, w, k);
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
    for (int k = 0; k < link.dof; ++k)
      tau[link.v + k] = power({w.p_torque, w.p_force}, axisTwist(link.type, w, k));
    if (link.parent < 0) continue;
    work[link.parent].p_torque += w.p_torque + w.r.cross(w.p_force);
    work[link.parent].p_force += w.p_force;
  }
  for (int i = 0; i < n; ++i) work[i].acceleration += gravity;
}

}  // namespace haptic
