/// One step of a tree with everything its joints do: damping, friction, limits, drives, mimic, rings.
///
/// A tree that nothing else pulls at moves to fourth order while its joints' laws are smooth and a step resolves them
/// (smooth_joints.h); rings hold the accelerations of each stage, and at the end q on φ = 0 and v on G v = 0. Where all stand, one sticks,
/// stops, saturates or is stiffer, or a ring does not close so (a straight chain between fixed points): symplectic Euler, v₁ = v + h v̇
/// with the forces here and now, q₁ = q ⊕ h v₁, where the joints' own forces are taken at v₁ and rings hold at q₁: the equations of
/// joint_solver.h, over the inertia of the tree. A straight piece's slope joins M's diagonal in the articulated-body algorithm. Up to
/// five chord Newton steps put q₁ on φ = 0, in both.
///
/// Cost: passes × one articulated-body evaluation, twice that with rings, and a response for each of their rows; six times that to fourth
/// order, two more where that is not resolved. No heap, no exception (in realtime) after construction.
#pragma once
#include <vector>

#include "haptic_core/dynamics/smooth_joints.h"

namespace haptic {

/// Work of the joints in a step, and its cost.
struct JointReport : JointWork {
  int passes = 0;         ///< articulated-body evaluations of symplectic Euler; 0: the step was one of fourth order
  bool converged = true;  ///< false: some joint's force is not on its graph
  double closure = 0;     ///< largest gap left in a ring [m]
};

/// Steps one articulation with its joint laws and rings.
class TreeMotion {
 public:
  /// The articulation must outlive it. Throws SetupError as `Rings` does.
  explicit TreeMotion(const Articulation& articulation, std::vector<RingDef> rings = {});

  /// Nothing but inertia, gravity and wrenches acts: stepRungeKutta and stepFreeBody may move it as well.
  bool isPlain() const { return joints_.empty(); }
  /// Of positions in the last step, where it was one of fourth order: see rungeKuttaError.
  double smoothError(double h, double size) const noexcept { return rungeKuttaError(articulation_, h, size, stages_.data()); }
  /// Joint laws that are not simulated (friction, limits and drives of planar and spherical joints), one line
  /// each.
  const std::vector<std::string>& unsupported() const { return unsupported_; }

  /// (in realtime) v̇ over a step h from the poses of the last forwardKinematics and the wrenches in `work`:
  /// v + h v̇ is the velocity at its end. q and v are those of forwardKinematics. `commands`: one per link, like q
  /// and v with the caller; finite. `tau`: generalised forces besides, [nv], or null.
  const JointReport& accelerate(const Vector3& gravity, double h, const JointCommand* commands, const double* q,
                                const double* v, LinkWork* work, double* v_dot,
                                const double* tau = nullptr) noexcept;

  /// (in realtime) The whole step, v and q in place. `work` keeps the start of the step, or a stage of it; a tree with rings leaves its
  /// end there.
  const JointReport& step(const Vector3& gravity, double h, const JointCommand* commands, double* q, double* v,
                          LinkWork* work, const double* tau = nullptr) noexcept;

  /// Report of the last step.
  const JointReport& report() const { return report_; }
  /// Force of the joint's own law at the end of the last step; 0 where it has no law.
  const JointForce& forceOf(int link) const { return force_[link]; }

  /// (in realtime) Puts q on the rings and mimics (for initial states): Newton steps until the gap stays.
  /// False: the gap did not close below 1e-9 m or rad. Overwrites `work`.
  bool close(double* q, double* v, LinkWork* work) noexcept;

 private:
  bool stepSmoothly(const Vector3& gravity, double h, const JointCommand* commands, double* q, double* v, LinkWork* work) noexcept;
  double correct(int steps, double* q, const double* v, LinkWork* work) noexcept;
  bool holdVelocities(double h, const double* q, double* v, LinkWork* work) noexcept;

  const Articulation& articulation_;
  JointSolver joints_;
  SmoothJoints smooth_;
  std::vector<std::string> unsupported_;
  JointReport report_;
  // Of one step.
  std::vector<double> tau_, v_dot_, change_, v_end_, q_start_, v_start_, response_, stages_;
  std::vector<JointForce> force_;
};

}  // namespace haptic
