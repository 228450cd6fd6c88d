/// Forces between two links, or a link and W: one form for every kind (force_kinds.h has the kinds, a row each).
///
/// A force element acts on body B at a point, and with the opposite on body A, or on W. At one instant it gives
///
///     value        F on B, the line's part apart
///     derivative   K = -∂F/∂x in position and D = -∂F/∂v in velocity, symmetric and not negative, of B relative to A
///     limit        along one line n the force is held in a range:  f = clamp(spring + damper, least, most)
///     stored       the energy of its springs [J]
///     taken        the power of its dampers, V·D V and the share of the line's damper [W]
///
/// and every stage of a step works with these alone: explicit steps add F, implicit ones solve with g² K + g D and the limit
/// (stepping/frozen_problem.h), the ledger sums the stored and the taken energy. K leaves out
/// terms that would push on, as a compressed spring does sideways: a solve stays convex, and its passes find the force itself.
#pragma once
#include <algorithm>
#include <limits>

#include "haptic_core/dynamics/kinematics.h"

namespace haptic {

/// A force along a line, held within a limit. It falls with the way and the speed of B along n.
struct LineForce {
  Vector3 n = Vector3::Zero();          ///< unit vector in W, from A to B; zero: there is none
  double spring = 0, damper = 0;        ///< on B along n, without the limit [N]
  double stiffness = 0, damping = 0;    ///< how they fall with way and speed along n [N/m], [N·s/m]
  double least = -std::numeric_limits<double>::infinity(), most = -least;  ///< range of both together: a rope's ends at 0 [N]

  double within(double force) const { return std::max(least, std::min(most, force)); }  ///< held in the range [N]
  double value() const { return within(spring + damper); }                              ///< on B along n [N]
  /// Power that the damper takes at a speed along n at which the forces are these [W]; ≥ 0.
  double taken(double speed) const { return (within(spring) - value()) * speed; }
};

/// The two ends of a force element.
struct ForceEnds {
  const LinkWork *a = nullptr, *b = nullptr;  ///< null: W
  Vector3 p_A = Vector3::Zero(), p_B = Vector3::Zero();  ///< points that the definition names, in A and in B [m]
  double size_b = 0;                          ///< reach of B from its centre of mass [m]

  Pose X_WA() const { return a ? a->X_WL : Pose(); }  ///< frame of A
};

/// A force element here and now, in W.
struct LinkForce {
  Vector3 p_WA = Vector3::Zero(), p_WB = Vector3::Zero();  ///< where it acts on A and on B [m]
  Twist V;                              ///< of B at p_WB relative to A at p_WA
  Wrench F;                             ///< on B at p_WB, without the line; its opposite on A at p_WA
  Matrix3 turn_K = Matrix3::Zero(), turn_D = Matrix3::Zero();  ///< derivatives of the torque, see above [N·m/rad], [N·m·s/rad]
  Matrix3 way_K = Matrix3::Zero(), way_D = Matrix3::Zero();    ///< of the force, without the line [N/m], [N·s/m]
  LineForce line;                       ///< the part with a limit
  double stored = 0;                    ///< [J]
  bool bends = true;                    ///< derivatives change with the pose: a solve has to look again where it has moved

  /// Sets the points and V.
  void place(const ForceEnds& ends, const Vector3& at_A, const Vector3& at_B) {
    p_WA = at_A, p_WB = at_B;
    if (ends.b) V = ends.b->twistAt(at_B);
    if (ends.a) V = V - ends.a->twistAt(at_A);
  }
  Wrench onB() const { return {F.torque, F.force + line.value() * line.n}; }  ///< on B at p_WB, all of it
  /// Power that its dampers take [W].
  double taken() const {
    return V.angular.dot(turn_D * V.angular) + V.linear.dot(way_D * V.linear) + line.taken(line.n.dot(V.linear));
  }
};

/// (in realtime) The force's opposite and itself go to the links; null: W.
inline void addForce(const LinkForce& force, LinkWork* a, LinkWork* b) noexcept {
  const Wrench F_W = force.onB();
  if (b) b->addWrench(F_W, force.p_WB);
  if (a) a->addWrench(-F_W, force.p_WA);
}

}  // namespace haptic
