/// Where the links of a tree are and how they move; wrenches on links; energy and momentum.
///
/// Every routine works on `LinkWork work[articulation.linkCount()]` and the caller's q, v; nothing here
/// allocates, throws or blocks (in realtime). Vectors in `LinkWork` are in W axes, about the reference point
/// O of the link (see articulation.h). Call order of a step: forwardKinematics, addWrench..., accelerations.
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/dynamics/articulation.h"

namespace haptic {

/// What one link's computation needs and leaves behind. The block names the routine that fills it.
struct LinkWork {
  // forwardKinematics
  Pose X_WL;                           ///< link frame
  Vector3 p_WO = Vector3::Zero();      ///< reference point [m]
  Vector3 omega = Vector3::Zero();     ///< angular velocity of L [rad/s]
  Vector3 velocity = Vector3::Zero();  ///< velocity of O [m/s]
  // addWrench; forwardKinematics clears it
  Wrench F_ext;  ///< external wrench about O
  // forwardKinematics
  Vector3 p_OC = Vector3::Zero();  ///< centre of mass from O [m]
  Vector3 r = Vector3::Zero();     ///< O from the parent's O [m]
  Matrix3 S = Matrix3::Zero();     ///< joint axes: column 0 for one degree, J's axes for spherical, planar
  Vector3 bias_angular = Vector3::Zero();  ///< acceleration over the parent's at v̇ = 0 [rad/s²]
  Vector3 bias_linear = Vector3::Zero();   ///< of O, likewise [m/s²]
  // accelerations
  Vector3 alpha = Vector3::Zero();                                        ///< angular acceleration [rad/s²]
  Vector3 acceleration = Vector3::Zero();                                 ///< acceleration of O [m/s²]
  Matrix3 A = Matrix3::Zero(), B = Matrix3::Zero(), M = Matrix3::Zero();  ///< articulated inertia [A B; Bᵀ M]
  Vector3 p_torque = Vector3::Zero(), p_force = Vector3::Zero();          ///< articulated bias wrench
  Matrix3 U_torque = Matrix3::Zero(), U_force = Matrix3::Zero();          ///< [A B; Bᵀ M] S, by column
  Matrix3 D_inverse = Matrix3::Zero();  ///< (Sᵀ U + h slope)⁻¹ of the joint's degrees, padded with zeros
  Vector3 u = Vector3::Zero();          ///< τ − Sᵀ p by degree: what accelerates the joint [N·m] or [N]

  Vector3 p_WC() const { return p_WO + p_OC; }  ///< centre of mass [m]
  /// Twist at a point of W that moves with the link.
  Twist twistAt(const Vector3& p_W) const { return {omega, velocity + omega.cross(p_W - p_WO)}; }
  Twist twistAtOrigin() const { return twistAt(X_WL.p); }  ///< V_WL
  /// Adds a wrench about the point p_W [N·m, N], in W axes.
  void addWrench(const Wrench& F_W, const Vector3& p_W) {
    F_ext.torque += F_W.torque + (p_W - p_WO).cross(F_W.force);
    F_ext.force += F_W.force;
  }
};

/// Poses, velocities and velocity-dependent accelerations of all links from q and v; clears the external
/// wrenches. O(links).
void forwardKinematics(const Articulation& articulation, const double* q, const double* v,
                       LinkWork* work) noexcept;

/// The same of a free body whose X_WL.R is that of q already.
inline void placeTurned(const LinkModel& link, const double* q, const double* v, LinkWork& work) noexcept {
  work.p_WO = work.r = Vector3(q[0], q[1], q[2]);
  work.X_WL.p = work.p_WO - work.X_WL.R * link.p_LO;
  work.p_OC.setZero();
  work.omega = Vector3(v[0], v[1], v[2]);
  work.velocity = Vector3(v[3], v[4], v[5]);
  work.F_ext = Wrench{};
}

/// Velocities and velocity-dependent accelerations alone, for the poses of the last forwardKinematics. Keeps
/// the external wrenches.
void forwardVelocities(const Articulation& articulation, const double* v, LinkWork* work) noexcept;

/// q ⊕ h v: exact for v constant in the frame it is given in; quaternions stay of unit length.
void integratePositions(const Articulation& articulation, double* q, const double* v, double h) noexcept;

/// generalised += Jᵀ F for a wrench about the point p_W on the link, in W [N·m, N]. O(depth).
void addGeneralisedForce(const Articulation& articulation, const LinkWork* work, int link, const Wrench& F_W,
                         const Vector3& p_W, double* generalised) noexcept;

/// J v: the twist at the point p_W of the link that the generalised velocity (any vector of nv numbers)
/// gives, at the poses of the last forwardKinematics. O(depth).
Twist pointTwist(const Articulation& articulation, const LinkWork* work, int link, const Vector3& p_W,
                 const double* v) noexcept;

/// J as 6 × nv, rows angular then linear, row-major with `stride` numbers a row; only the degrees that carry
/// the link are written (the caller zeroes the rest once: the pattern is constant). O(depth).
void pointJacobian(const Articulation& articulation, const LinkWork* work, int link, const Vector3& p_W,
                   double* J, int stride) noexcept;

double kineticEnergy(const Articulation& articulation, const LinkWork* work) noexcept;  ///< [J]
/// −Σ m g·p_WC [J]; links on the world by fixed joints only count as well (a constant).
double potentialEnergy(const Articulation& articulation, const LinkWork* work,
                       const Vector3& gravity) noexcept;
/// Momentum: angular about `p_W` [N·m·s] and linear [N·s].
Wrench momentum(const Articulation& articulation, const LinkWork* work, const Vector3& p_W) noexcept;

}  // namespace haptic
