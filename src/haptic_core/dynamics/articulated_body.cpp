#include "haptic_core/dynamics/articulated_body.h"

#include <cmath>

namespace haptic {
namespace {

/// I, p of the link alone, about O. The gyroscopic part is the rate of change of momentum at zero
/// acceleration.
void startLink(const LinkModel& link, LinkWork& w) {
  const Matrix3& R = w.X_WL.R;
  const Matrix3 RI = R * link.I_O;
  w.A.noalias() = RI * R.transpose();
  w.B = crossMatrix(link.mass * w.p_OC);
  w.M = link.mass * Matrix3::Identity();
  w.p_torque = w.omega.cross(w.A * w.omega) - w.F_ext.torque;
  w.p_force = link.mass * w.omega.cross(w.omega.cross(w.p_OC)) - w.F_ext.force;
}

/// Inverse of a symmetric positive definite matrix through its Cholesky factor: exact under any scaling of rows, where
/// cofactors lose as many digits as the condition has. Metres and radians of one joint differ in scale by nature.
Matrix3 inverseOf(const Matrix3& D) {
  const double l00 = std::sqrt(D(0, 0)), i00 = 1 / l00;
  const double l10 = D(1, 0) * i00, l20 = D(2, 0) * i00;
  const double l11 = std::sqrt(D(1, 1) - l10 * l10), i11 = 1 / l11;
  const double l21 = (D(2, 1) - l20 * l10) * i11;
  const double l22 = std::sqrt(D(2, 2) - l20 * l20 - l21 * l21), i22 = 1 / l22;
  const double i10 = -l10 * i00 * i11, i21 = -l21 * i11 * i22, i20 = -(l20 * i00 + l21 * i10) * i22;
  Matrix3 inverse;
  inverse(0, 0) = i00 * i00 + i10 * i10 + i20 * i20;
  inverse(1, 0) = inverse(0, 1) = i10 * i11 + i20 * i21;
  inverse(2, 0) = inverse(0, 2) = i20 * i22;
  inverse(1, 1) = i11 * i11 + i21 * i21;
  inverse(2, 1) = inverse(1, 2) = i21 * i22;
  inverse(2, 2) = i22 * i22;
  return inverse;
}

/// The caller gives the joint's v̇ (an infinite D).
bool prescribed(const LinkWork& w) {
  return w.D_inverse(0, 0) == 0;
}

/// D⁻¹ u: acceleration of the joint's axes by their free forces u.
Vector3 ratesOf(const LinkModel& link, const LinkWork& w, const Vector3& u) noexcept {
  return link.dof == 1 ? Vector3(w.D_inverse(0, 0) * u[0], 0, 0) : Vector3(w.D_inverse * u);
}

/// U, D⁻¹, u of one joint whose degrees turn about (`kTurns`) or slide along axes through O.
template <bool kTurns>
void factorSingle(double tau, double diag, LinkWork& w) {
  const Vector3 axis = w.S.col(0);
  if (kTurns) {
    w.U_torque.col(0).noalias() = w.A * axis;
    w.U_force.col(0).noalias() = w.B.transpose() * axis;
    w.D_inverse(0, 0) = 1 / (axis.dot(w.U_torque.col(0)) + diag);
    w.u[0] = tau - axis.dot(w.p_torque);
  } else {
    w.U_torque.col(0).noalias() = w.B * axis;
    w.U_force.col(0).noalias() = w.M * axis;
    w.D_inverse(0, 0) = 1 / (axis.dot(w.U_force.col(0)) + diag);
    w.u[0] = tau - axis.dot(w.p_force);
  }
}

/// The same of a joint with two or three axes; unused columns stay zero.
void factorSeveral(const LinkModel& link, const double* tau, const double* diag, LinkWork& w) {
  Matrix3 D = Matrix3::Identity();
  for (int k = 0; k < link.slides; ++k) {
    w.U_torque.col(k).noalias() = w.B * w.S.col(k);
    w.U_force.col(k).noalias() = w.M * w.S.col(k);
    w.u[k] = -w.S.col(k).dot(w.p_force);
  }
  for (int k = link.slides; k < link.dof; ++k) {
    w.U_torque.col(k).noalias() = w.A * w.S.col(k);
    w.U_force.col(k).noalias() = w.B.transpose() * w.S.col(k);
    w.u[k] = -w.S.col(k).dot(w.p_torque);
  }
  for (int k = 0; k < link.dof; ++k) {
    const Matrix3& U = k < link.slides ? w.U_force : w.U_torque;
    for (int j = 0; j < link.dof; ++j) D(k, j) = w.S.col(k).dot(U.col(j));
    if (tau) w.u[k] += tau[k];
  }
  if (diag && std::isinf(diag[0])) {
    w.D_inverse.setZero();
    return;
  }
  for (int k = 0; diag && k < link.dof; ++k) D(k, k) += diag[k];
  w.D_inverse = inverseOf(D);
}

/// Adds [A B; Bᵀ M] and p about O to the parent's about p_O − r: Xᵀ I X with X = [1 0; −r× 1], which is B + N
/// with N = r× M, and A + Q + Qᵀ with Q = r× (B + N/2)ᵀ. Row by row: column k of Q is r × (row k of B + N/2).
inline void shiftToParent(const Matrix3& A, const Matrix3& B, const Matrix3& M, const Vector3& torque,
                          const Vector3& force, const Vector3& r, LinkWork& parent) {
  const double x = r[0], y = r[1], z = r[2];
  double Q[3][3];
  for (int k = 0; k < 3; ++k) {
    // Row k of N = r× M; M is symmetric.
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double n0 = r[i] * M(0, j) - r[j] * M(0, i), n1 = r[i] * M(1, j) - r[j] * M(1, i),
                 n2 = r[i] * M(2, j) - r[j] * M(2, i);
    const double b0 = B(k, 0) + 0.5 * n0, b1 = B(k, 1) + 0.5 * n1, b2 = B(k, 2) + 0.5 * n2;
    Q[0][k] = y * b2 - z * b1;
    Q[1][k] = z * b0 - x * b2;
    Q[2][k] = x * b1 - y * b0;
    parent.B(k, 0) += B(k, 0) + n0;
    parent.B(k, 1) += B(k, 1) + n1;
    parent.B(k, 2) += B(k, 2) + n2;
  }
  for (int k = 0; k < 3; ++k) {
    parent.A(k, k) += A(k, k) + 2 * Q[k][k];
    for (int j = 0; j < k; ++j) {
      const double off = A(k, j) + Q[k][j] + Q[j][k];
      parent.A(k, j) += off;
      parent.A(j, k) += off;
    }
  }
  parent.M += M;
  parent.p_torque += torque + r.cross(force);
  parent.p_force += force;
}

/// Adds I and p of a link, reduced by what its joint gives way to, to its parent.
void passToParent(const LinkModel& link, const LinkWork& w, const double* vdot, LinkWork& parent) {
  Matrix3 A = w.A, B = w.B, M = w.M;
  Vector3 torque = w.p_torque + w.A * w.bias_angular + w.B * w.bias_linear;
  Vector3 force = w.p_force + w.B.transpose() * w.bias_angular + w.M * w.bias_linear;
  if (link.dof == 1) {
    const Vector3 Ut = w.U_torque.col(0), Uf = w.U_force.col(0);
    const Vector3 Ut_D = w.D_inverse(0, 0) * Ut, Uf_D = w.D_inverse(0, 0) * Uf;
    A.noalias() -= Ut_D * Ut.transpose();
    B.noalias() -= Ut_D * Uf.transpose();
    M.noalias() -= Uf_D * Uf.transpose();
    const double rest = w.u[0] - Ut.dot(w.bias_angular) - Uf.dot(w.bias_linear);
    const double rate = prescribed(w) ? vdot[0] : rest * w.D_inverse(0, 0);
    torque += rate * Ut;
    force += rate * Uf;
  } else if (link.dof > 1 && !link.floating) {
    const Matrix3 Ut_D = w.U_torque * w.D_inverse, Uf_D = w.U_force * w.D_inverse;
    A.noalias() -= Ut_D * w.U_torque.transpose();
    B.noalias() -= Ut_D * w.U_force.transpose();
    M.noalias() -= Uf_D * w.U_force.transpose();
    const Vector3 rest =
        w.u - w.U_torque.transpose() * w.bias_angular - w.U_force.transpose() * w.bias_linear;
    const Vector3 rate = prescribed(w) ? Vector3(vdot[0], vdot[1], link.dof > 2 ? vdot[2] : 0) : Vector3(w.D_inverse * rest);
    torque += w.U_torque * rate;
    force += w.U_force * rate;
  }
  shiftToParent(A, B, M, torque, force, w.r, parent);
}

/// [A B; Bᵀ M] (α, a) = (torque, force), by the Schur complement of M.
void solveSix(const LinkWork& w, const Vector3& torque, const Vector3& force, Vector3& alpha, Vector3& a) {
  const Matrix3 M_inverse = inverseOf(w.M);
  const Matrix3 BM = w.B * M_inverse;
  const Matrix3 schur = w.A - BM * w.B.transpose();
  alpha.noalias() = inverseOf(schur) * (torque - BM * force);
  a.noalias() = M_inverse * (force - w.B.transpose() * alpha);
}

/// X Ω Xᵀ: the mobility of a link fixed to its parent, a = a_parent − r × α.
Matrix6 shiftedMobility(const Eigen::Map<const Matrix6>& parent, const Vector3& r) {
  Matrix6 shifted = parent;
  for (int k = 0; k < 6; ++k) shifted.block<3, 1>(3, k) -= r.cross(shifted.block<3, 1>(0, k));
  for (int k = 0; k < 6; ++k) shifted.block<1, 3>(k, 3) -= r.cross(shifted.block<1, 3>(k, 0).transpose()).transpose();
  return shifted;
}

/// The mobility of a floating root.
Matrix6 rootMobility(const LinkWork& w) {
  Matrix6 mobility;
  for (int k = 0; k < 6; ++k) {
    const Vector6 wrench = Vector6::Unit(k);
    Vector3 alpha, a;
    solveSix(w, wrench.head<3>(), wrench.tail<3>(), alpha, a);
    mobility.col(k) << alpha, a;
  }
  return mobility;
}

/// Adds the way of a joint's own degrees to that of its link. Returns the diagonal of its block of M⁻¹.
Vector3 addJointMobility(const LinkModel& link, const LinkWork& w, Matrix6& mobility) {
  using Columns = Eigen::Matrix<double, 6, 3>;
  Columns U, S = Columns::Zero();
  U << w.U_torque, w.U_force;
  for (int k = 0; k < link.dof; ++k) S.block<3, 1>(k < link.slides ? 3 : 0, k) = w.S.col(k);
  if (link.dof == 1) {
    const double d = w.D_inverse(0, 0);
    const Vector6 s = S.col(0), way = d * (mobility * U.col(0));
    const double own = d + d * U.col(0).dot(way);
    mobility += s * (own * s - way).transpose() - way * s.transpose();
    return Vector3(own, 0, 0);
  }
  const Columns way = mobility * U * w.D_inverse;
  const Matrix3 own = w.D_inverse + w.D_inverse * (U.transpose() * way);
  mobility += S * (own * S.transpose() - way.transpose()) - way * S.transpose();
  return own.diagonal();
}

/// v̇ and the accelerations of a floating root. Gravity is left out of `w.acceleration` here, as everywhere
/// inside the recursion (the world falls upwards instead).
void solveFloating(const double* tau, const double* diag, const Vector3& gravity, bool leaf, LinkWork& w,
                   double* vdot) {
  Eigen::Map<Vector3> angular(vdot), linear(vdot + 3);
  const bool given = diag && std::isinf(diag[0]);
  w.D_inverse(0, 0) = given ? 0 : 1;  // for `prescribed`
  if (given) {
    w.alpha = angular;
    w.acceleration = linear - gravity;
    return;
  }
  Vector3 torque = -w.p_torque, force = -w.p_force;
  if (tau) {
    torque += Eigen::Map<const Vector3>(tau);
    force += Eigen::Map<const Vector3>(tau + 3);
  }
  if (diag) {
    w.A.diagonal() += Eigen::Map<const Vector3>(diag);
    w.M.diagonal() += Eigen::Map<const Vector3>(diag + 3);
    force -= Eigen::Map<const Vector3>(diag + 3).cwiseProduct(gravity);  // diag acts on v̇, not on v̇ − g
  }
  if (leaf) {
    w.alpha.noalias() = w.A.inverse() * torque;
    w.acceleration = force.cwiseQuotient(w.M.diagonal());
  } else {
    solveSix(w, torque, force, w.alpha, w.acceleration);
  }
  angular = w.alpha;
  linear = w.acceleration + gravity;
}

void solveJoint(const LinkModel& link, LinkWork& w, double* vdot) {
  if (link.dof == 1) {
    if (!prescribed(w))
      vdot[0] = w.D_inverse(0, 0) *
                (w.u[0] - w.U_torque.col(0).dot(w.alpha) - w.U_force.col(0).dot(w.acceleration));
    (link.turns ? w.alpha : w.acceleration) += vdot[0] * w.S.col(0);
  } else if (link.dof > 1) {
    if (!prescribed(w)) {
      const Vector3 rate =
          w.D_inverse * (w.u - w.U_torque.transpose() * w.alpha - w.U_force.transpose() * w.acceleration);
      for (int k = 0; k < link.dof; ++k) vdot[k] = rate[k];
    }
    for (int k = 0; k < link.dof; ++k) (k < link.slides ? w.acceleration : w.alpha) += vdot[k] * w.S.col(k);
  }
}

/// Euler's and Newton's law of one body, its inertia constant in link axes.
void solveFreeBody(const LinkModel& link, const double* tau, const double* diag, const Vector3& gravity,
                   LinkWork& w, double* vdot) {
  Eigen::Map<Vector3> angular(vdot), linear(vdot + 3);
  if (!diag) {
    Vector3 torque = w.F_ext.torque, force = w.F_ext.force;
    if (tau) {
      torque += Eigen::Map<const Vector3>(tau);
      force += Eigen::Map<const Vector3>(tau + 3);
    }
    const Matrix3& R = w.X_WL.R;
    const Vector3 omega_L = R.transpose() * w.omega;
    const Vector3 torque_L = R.transpose() * torque - omega_L.cross(link.I_O * omega_L);
    w.alpha.noalias() = R * (link.I_O_inverse * torque_L);
    w.acceleration = force * (1 / link.mass) + gravity;
    angular = w.alpha;
    linear = w.acceleration;
    return;
  }
  startLink(link, w);
  solveFloating(tau, diag, gravity, true, w, vdot);
  w.acceleration += gravity;
}

}  // namespace

void accelerations(const Articulation& articulation, const Vector3& gravity, const double* tau,
                   const double* diag, LinkWork* work, double* vdot) noexcept {
  if (articulation.isFreeBody()) {
    solveFreeBody(articulation.link(0), tau, diag, gravity, work[0], vdot);
    return;
  }
  const int n = articulation.linkCount();
  for (int i = 0; i < n; ++i) startLink(articulation.link(i), work[i]);
  for (int i = n - 1; i >= 0; --i) {
    const LinkModel& link = articulation.link(i);
    const double* joint_tau = tau ? tau + link.v : nullptr;
    const double* joint_diag = diag ? diag + link.v : nullptr;
    if (link.dof == 1) {
      (link.turns ? factorSingle<true> : factorSingle<false>)(joint_tau ? *joint_tau : 0, joint_diag ? *joint_diag : 0,
                                                             work[i]);
    } else if (link.dof > 1 && !link.floating) {
      factorSeveral(link, joint_tau, joint_diag, work[i]);
    }
    if (link.parent >= 0) passToParent(link, work[i], vdot + link.v, work[link.parent]);
  }
  for (int i = 0; i < n; ++i) {
    const LinkModel& link = articulation.link(i);
    LinkWork& w = work[i];
    if (link.floating) {
      solveFloating(tau ? tau + link.v : nullptr, diag ? diag + link.v : nullptr, gravity, false, w,
                    vdot + link.v);
      continue;
    }
    if (link.parent < 0) {
      w.alpha = w.bias_angular;
      w.acceleration = w.bias_linear - gravity;
    } else {
      const LinkWork& parent = work[link.parent];
      w.alpha = parent.alpha + w.bias_angular;
      w.acceleration = parent.acceleration + parent.alpha.cross(w.r) + w.bias_linear;
    }
    solveJoint(link, w, vdot + link.v);
  }
  for (int i = 0; i < n; ++i) work[i].acceleration += gravity;
}

void accelerationResponse(const Articulation& articulation, const double* tau, const LinkWork* work,
                          double* scratch, double* v_dot) noexcept {
  const int n = articulation.linkCount();
  using Map = Eigen::Map<Vector3>;
  // Per link: u in the first three numbers, then bias wrench p (torque, force), later (α, a), in the last
  // six.
  for (int i = 0; i < 12 * n; ++i) scratch[i] = 0;
  for (int i = n - 1; i >= 0; --i) {
    const LinkModel& link = articulation.link(i);
    const LinkWork& w = work[i];
    double* const s = scratch + 12 * i;
    Vector3 torque = Map(s + 6), force = Map(s + 9);
    if (link.dof > 0 && !link.floating) {
      for (int k = 0; k < link.dof; ++k) {
        s[k] = tau[link.v + k] - w.S.col(k).dot(k < link.slides ? force : torque);
      }
      const Vector3 rate = ratesOf(link, w, Map(s));
      for (int k = 0; k < link.dof; ++k) {
        torque += rate[k] * w.U_torque.col(k);
        force += rate[k] * w.U_force.col(k);
      }
    }
    if (link.parent < 0) continue;
    double* const above = scratch + 12 * link.parent;
    Map(above + 6) += torque + w.r.cross(force);
    Map(above + 9) += force;
  }
  for (int i = 0; i < n; ++i) {
    const LinkModel& link = articulation.link(i);
    const LinkWork& w = work[i];
    double* const s = scratch + 12 * i;
    double* const rate = v_dot + link.v;
    Vector3 alpha = Vector3::Zero(), a = Vector3::Zero();
    if (link.floating) {
      if (!prescribed(w))
        solveSix(w, Map(const_cast<double*>(tau) + link.v) - Map(s + 6),
                 Map(const_cast<double*>(tau) + link.v + 3) - Map(s + 9), alpha, a);
      for (int k = 0; k < 3; ++k) {
        rate[k] = alpha[k];
        rate[3 + k] = a[k];
      }
    } else {
      if (link.parent >= 0) {
        const double* const above = scratch + 12 * link.parent;
        alpha = Eigen::Map<const Vector3>(above + 6);
        a = Eigen::Map<const Vector3>(above + 9) + alpha.cross(w.r);
      }
      Vector3 u = Vector3::Zero();
      for (int k = 0; k < link.dof; ++k) u[k] = s[k] - w.U_torque.col(k).dot(alpha) - w.U_force.col(k).dot(a);
      const Vector3 rates = ratesOf(link, w, u);
      for (int k = 0; k < link.dof; ++k) {
        rate[k] = rates[k];
        (k < link.slides ? a : alpha) += rates[k] * w.S.col(k);
      }
    }
    Map(s + 6) = alpha;
    Map(s + 9) = a;
  }
}

void jointMobilities(const Articulation& articulation, const LinkWork* work, double* scratch, double* mobility) noexcept {
  using Map = Eigen::Map<Matrix6>;
  for (int i = 0; i < articulation.linkCount(); ++i) {
    const LinkModel& link = articulation.link(i);
    Matrix6 way = Matrix6::Zero();
    if (link.floating) {
      if (!prescribed(work[i])) way = rootMobility(work[i]);
      Eigen::Map<Vector6>(mobility + link.v) = way.diagonal();
    } else {
      if (link.parent >= 0) way = shiftedMobility(Eigen::Map<const Matrix6>(scratch + 36 * link.parent), work[i].r);
      const Vector3 own = link.dof > 0 ? addJointMobility(link, work[i], way) : Vector3::Zero();
      for (int k = 0; k < link.dof; ++k) mobility[link.v + k] = own[k];
    }
    Map(scratch + 36 * i) = way;
  }
}

Wrench jointWrench(const Articulation& articulation, const LinkWork* work, int link,
                   const Vector3& gravity) noexcept {
  const LinkWork& w = work[link];
  const Vector3 a = w.acceleration - gravity;
  if (articulation.isFreeBody()) return {};
  return {w.A * w.alpha + w.B * a + w.p_torque, w.B.transpose() * w.alpha + w.M * a + w.p_force};
}

}  // namespace haptic
