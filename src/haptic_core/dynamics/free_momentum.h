/// Momentum of a floating tree on which nothing pulls but gravity: known before the step, and kept exactly.
///
/// With P and L about the centre of mass C: P(t+h) = P + h m g, L(t+h) = L, p_C(t+h) = p_C + h P/m + h² g/2,
/// whatever the joints do. An integrator of order p misses these by O(h^(p+1)) a step, which adds up; putting
/// the root's velocity and position right by the difference changes the step by no more than its own error,
/// so that the order stays.
#pragma once
#include "haptic_core/dynamics/kinematics.h"

namespace haptic {

/// What hangs on one root, as one body.
struct FreeMomentum {
  double mass = 0;                 ///< [kg]
  Vector3 p_WC = Vector3::Zero();  ///< centre of mass [m]
  Wrench H_C;                      ///< momentum about C: L [N·m·s], P [N·s]
  Matrix3 I_C = Matrix3::Zero();   ///< inertia with the joints locked, W axes [kg·m²]
};

/// (in realtime) From the poses and velocities in `work`. O(links).
FreeMomentum freeMomentum(const Articulation& articulation, const LinkWork* work, int root) noexcept;

/// (in realtime) Whether link `root` floats and carries others.
bool floatsWithOthers(const Articulation& articulation, int root) noexcept;

/// (in realtime) Puts the root's position and velocity in q, v right for a step h that began with `before`.
/// `work`: the poses and velocities of q, v; it is not changed.
void keepMomentum(const Articulation& articulation, const LinkWork* work, const FreeMomentum& before,
                  int root, const Vector3& gravity, double h, double* q, double* v) noexcept;

}  // namespace haptic
