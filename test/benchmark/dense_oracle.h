/// Forward dynamics by body Jacobians and a dense solve, in 64-bit mantissas: the oracle of the recursion.
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "haptic_core/dynamics/kinematics.h"

namespace haptic::bench {

struct AccelerationError {
  double plain = 0;   ///< ‖v̇ − v̇'‖ / ‖v̇'‖, radians and metres as they are
  double energy = 0;  ///< the same in the norm of kinetic energy, xᵀ M x
};

/// Error of v̇ against v̇' from M = Σ Jᵀ I J and the bias forces of every link, summed in wider arithmetic from the
/// joint axes, arms and rotations in `work`; no wrenches, no joint forces.
inline AccelerationError relativeError(const Articulation& tree, const LinkWork* work, const Vector3& gravity,
                            const double* v_dot, const double* v) {
  using Real = long double;
  using V3 = Eigen::Matrix<Real, 3, 1>;
  using M3 = Eigen::Matrix<Real, 3, 3>;
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
  const int nv = tree.nv(), n = tree.linkCount();
  struct Motion {
    V3 p, omega, alpha, a;
    Matrix J;  // of O: angular rows, then linear
  };
  std::vector<Motion> motion(n);
  Matrix M = Matrix::Zero(nv, nv);
  Vector bias = Vector::Zero(nv);
  for (int i = 0; i < n; ++i) {
    const LinkModel& link = tree.link(i);
    const LinkWork& w = work[i];
    Motion& m = motion[i];
    const V3 r = w.r.cast<Real>();
    Motion root;
    root.p = root.omega = root.alpha = V3::Zero();
    root.a = -gravity.cast<Real>();
    root.J = Matrix::Zero(6, nv);
    const Motion& parent = link.parent < 0 ? root : motion[link.parent];
    m.p = parent.p + r;
    m.J = parent.J;
    for (int k = 0; k < nv; ++k)
      m.J.template block<3, 1>(3, k) += V3(parent.J.template block<3, 1>(0, k)).cross(r);
    V3 turn = V3::Zero(), slide = V3::Zero();
    for (int k = 0; k < link.dof; ++k) {
      const bool slides = link.floating ? k >= 3 : k < link.slides;
      const V3 axis = link.floating ? V3(V3::Unit(k % 3)) : V3(w.S.col(k).cast<Real>());
      m.J.template block<3, 1>(slides ? 3 : 0, link.v + k) += axis;
      (slides ? slide : turn) += static_cast<Real>(v[link.v + k]) * axis;
    }
    m.omega = parent.omega + turn;
    m.alpha = parent.alpha + parent.omega.cross(turn);
    m.a = parent.a + parent.alpha.cross(r) + parent.omega.cross(parent.omega.cross(r) + 2 * slide);

    const M3 R = w.X_WL.R.cast<Real>();
    const M3 I = R * link.I_C.cast<Real>() * R.transpose();
    const V3 c = R * link.p_OC.cast<Real>();
    const Real mass = link.mass;
    const Matrix Jw = m.J.topRows(3);
    Matrix Jv = m.J.bottomRows(3);
    for (int k = 0; k < nv; ++k) Jv.template block<3, 1>(0, k) += V3(Jw.col(k)).cross(c);
    M += mass * Jv.transpose() * Jv + Jw.transpose() * I * Jw;
    bias += Jw.transpose() * (I * m.alpha + m.omega.cross(I * m.omega)) +
            mass * Jv.transpose() * (m.a + m.alpha.cross(c) + m.omega.cross(m.omega.cross(c)));
  }
  const Vector expected = M.ldlt().solve(-bias);
  Vector error = -expected;
  for (int k = 0; k < nv; ++k) error[k] += v_dot[k];
  return {static_cast<double>(error.norm() / expected.norm()),
          static_cast<double>(std::sqrt(error.dot(M * error) / expected.dot(M * expected)))};
}

}  // namespace haptic::bench
