/// Motion of a tree on which nothing pulls but gravity, its own joints and its rings, to fourth order. Nothing here allocates (in
/// realtime).
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/dynamics/articulated_body.h"

namespace haptic {

/// What joints and rings do that are smooth while a step lasts (smooth_joints.h).
class StageJoints {
 public:
  /// (in realtime) τ [nv] at (q, v), [N·m] or [N]; `time` [s]: the share of the step that this stage stands for, by which its power
  /// counts as work. False: a force bends or jumps between the first stage and here.
  virtual bool at(const double* q, const double* v, double time, double* tau) noexcept = 0;
  /// (in realtime) Whether a step resolves them: asked once, after the accelerations of the first stage, which `work` holds.
  virtual bool areResolved(const LinkWork* work) noexcept = 0;
  /// Links are held together in rings: the momentum of what floats may change.
  virtual bool haveRings() const noexcept = 0;
  /// (in realtime) v̇ of the stage whose kinematics `work` holds, under τ and the forces of rings. Fills `work` as `accelerations` does.
  virtual void accelerate(const Vector3& gravity, const double* q, const double* v, const double* tau, LinkWork* work,
                          double* v_dot) noexcept = 0;

 protected:
  ~StageJoints() = default;
};

/// Doubles of scratch that stepRungeKutta needs.
int rungeKuttaScratch(const Articulation& articulation);

/// One step h of a tree by Merson's formula: order 4, five evaluations (Proc. Symp. Data Processing, Salisbury 1957).
/// Energy drift of a chain of 10 links over 5 s at 1 ms, of m g L n²/2: 4e-6; the classical formula with its four
/// evaluations 1.3e-5. Explicit: nothing stiff in it. Floating trees without rings keep their momentum exactly (free_momentum.h). On
/// return `work` belongs to a stage, not to the new state, and holds no wrenches. `joints`: forces besides, or null; with them `work` has
/// to hold the kinematics of q and v, and no wrenches. False: they are not smooth in this step, or not resolved; q, v and the kinematics
/// are as before.
bool stepRungeKutta(const Articulation& articulation, const Vector3& gravity, double h, double* q, double* v,
                    LinkWork* work, double* scratch, StageJoints* joints = nullptr) noexcept;

/// Merson's estimate of the error of the last step's positions [m], by its stages in `scratch`: h/30 |2 k₁ - 9 k₃ + 8 k₄ - k₅|, exact for
/// linear equations and too much for others. Turns count at `size` [m].
double rungeKuttaError(const Articulation& articulation, double h, double size, const double* scratch) noexcept;

}  // namespace haptic
