/// The joint-space inertia M(q) and inverse dynamics, for implicit steps in generalised velocities. All
/// routines work at the poses of the last forwardKinematics and none allocates (in realtime).
///
/// Sources: Featherstone 2008, table 6.2 (composite rigid bodies) and section 5.3 (recursive Newton–Euler), in W axes
/// about each link's O as in articulated_body.h.
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/dynamics/kinematics.h"

namespace haptic {

/// M(q), nv × nv, row-major, full and symmetric [kg·m², kg·m, kg]. Overwrites what `accelerations` left in
/// `work` (A, p_force, u: they hold the composites). O(nv · depth).
void massMatrix(const Articulation& articulation, LinkWork* work, double* M) noexcept;

/// τ [nv] that gives v̇ (null: v̇ = 0, so that τ is the bias c(q, v)) under gravity and the external wrenches:
/// τ = M v̇ + c(q, v) − Σ Jᵀ F_ext. Overwrites p_torque, p_force, alpha and acceleration in `work`. O(links).
void inverseDynamics(const Articulation& articulation, const Vector3& gravity, const double* vdot,
                     LinkWork* work, double* tau) noexcept;

}  // namespace haptic
