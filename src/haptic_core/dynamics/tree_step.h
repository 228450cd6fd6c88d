/// Velocity Verlet of one articulation, cut where a world evaluates wrenches: one call for free bodies, trees and
/// trees whose joints have laws. A free body takes its short way inside, with no look at joints.
///
/// Velocity Verlet: `startVerlet` with the pull that `readPull` has read at the start; the caller adds wrenches at the new q and the
/// predicted v; `finishVerlet`.
/// Between the kicks a free body moves without forces, to fifth order (free_body.h), a tree under gravity, to fourth
/// (runge_kutta.h): chains whip, and their Coriolis forces are no smaller than contact forces. Joints with laws move by
/// TreeMotion, with the pull of the step's start.
///
/// Nothing here allocates, throws or blocks after TreeStepScratch::fit (in realtime).
#pragma once
#include <vector>

#include "haptic_core/dynamics/tree_motion.h"

namespace haptic {

/// One articulation in the caller's arrays; pointers to its first link and degree. Cheap: made for each call.
struct SteppedTree {
  const Articulation* model = nullptr;     ///< the constant tree
  TreeMotion* motion = nullptr;            ///< of joints with laws of their own; null: none have any
  const JointCommand* commands = nullptr;  ///< by link; read with `motion` only
  double* q = nullptr;                     ///< [nq]
  double* v = nullptr;                     ///< [nv]
  /// [nv] What contacts and hands do, from one evaluation to the next step. Free body: torque about C [N·m], then
  /// acceleration of C, gravity's included [m/s²]. Tree: v̇. With `motion`: generalised forces.
  double* pull = nullptr;
  /// [nv] startVerlet leaves v½ here for finishVerlet, with `motion` the mean velocity over the step.
  double* half = nullptr;
  LinkWork* work = nullptr;                ///< by link
};

/// Scratch of these steps, one for all trees of a world.
struct TreeStepScratch {
  void fit(const Articulation& articulation);  ///< set-up: grows to what this tree needs
  std::vector<double> stages, alone;           ///< sized by `fit`
  std::vector<Wrench> wrenches;                ///< by link, all zero
};

/// (in realtime) Half a kick by `pull` and the drift: q is that of the step's end, v its prediction, `work` their
/// kinematics, without wrenches. Returns the joints' report; null without `motion`.
const JointReport* startVerlet(const SteppedTree& tree, const Vector3& gravity, double h, TreeStepScratch& scratch) noexcept;

/// (in realtime) The other half of the kick, from v½, by the wrenches in `work`; v and the velocities in `work` are those
/// of the step's end, `pull` is read for the next. Not with `motion`, which has done it.
void finishVerlet(const SteppedTree& tree, const Vector3& gravity, double h, TreeStepScratch& scratch) noexcept;

/// (in realtime) `pull` from the wrenches in `work`, and nothing else.
void readPull(const SteppedTree& tree, const Vector3& gravity, TreeStepScratch& scratch) noexcept;

}  // namespace haptic
