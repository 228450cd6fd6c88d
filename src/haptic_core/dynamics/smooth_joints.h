/// Joints that move freely within their kinks: their laws as forces in the stages of stepRungeKutta, to its order; and rings, which hold
/// the accelerations of each stage, G v̇ + G' v = 0 (index 1; Hairer, Wanner, Solving Ordinary Differential Equations II, 1996, VII.2).
///
/// Resolved is a step h in which Σ h s_i (M⁻¹)_ii ≤ 3, s_i = d + h k of all damping and stiffness at joint i. This trace is not below the
/// largest eigenvalue of M⁻¹ (h D + h² K), so z = h λ of every motion of the joints solves z² + a z + b = 0 with a + b below it, and
/// Merson's formula is stable for all such z up to 3.5.
///
/// Nothing here allocates after construction (in realtime).
#pragma once
#include <vector>

#include "haptic_core/dynamics/joint_solver.h"
#include "haptic_core/dynamics/runge_kutta.h"

namespace haptic {

/// The laws of one articulation's joints in one step.
class SmoothJoints final : public StageJoints {
 public:
  /// Articulation and rings must outlive this object. `rings`: of the same articulation; its rows are the degrees of freedom, in order.
  SmoothJoints(const Articulation& articulation, JointSolver& rings);

  void begin(const JointCommand* commands, double h) noexcept;  ///< (in realtime) before a step h
  bool at(const double* q, const double* v, double time, double* tau) noexcept override;
  bool areResolved(const LinkWork* work) noexcept override;
  bool haveRings() const noexcept override { return rings_.hasRings(); }
  void accelerate(const Vector3& gravity, const double* q, const double* v, const double* tau, LinkWork* work,
                  double* v_dot) noexcept override;

  const JointWork& work() const { return work_; }  ///< of the step, by the quadrature of the stages
  /// Forces of the joints where the last stage was, by link: after a step, at its end.
  void readForces(JointForce* by_link) const noexcept;

 private:
  struct Law {
    JointDef joint;
    int link, q, v;       ///< indices of link, position and velocity
    SmoothForce force;    ///< at the last stage
    int side = 0;         ///< of the kinks, at the first
    double slope = 0;     ///< at the first
  };
  struct Damped {
    int v;           ///< a degree of a joint of several
    double damping;  ///< [N·m·s/rad] or [N·s/m]
  };
  const Articulation& articulation_;
  JointSolver& rings_;
  std::vector<Law> laws_;
  std::vector<Damped> damped_;
  const JointCommand* commands_ = nullptr;
  double h_ = 0;
  bool first_ = false;  ///< the next stage is the first
  JointWork work_;
  std::vector<double> scratch_, mobility_, none_;  ///< none_: zeros
};

}  // namespace haptic
