/// What presses and pulls in a pass of an implicit stage (frozen_problem.h).
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/stepping/frozen_patch.h"

namespace haptic {

/// A contact in a pass of an implicit stage.
struct FrozenContact {
  int link_a = 0, link_b = 0;          ///< world indices
  Pose X_WP;                           ///< of the patch, at the reference
  FrozenPatch patch;                   ///< its frozen force
  Vector6 V_reference = Vector6::Zero();  ///< of B over A at P, in P's axes
  Vector6 V_frozen = Vector6::Zero();  ///< the same where the patch was frozen
  Vector6 V = Vector6::Zero();         ///< the same at the present v
  Vector6 step = Vector6::Zero();      ///< J p
  Vector6 step_loaded = Vector6::Zero();  ///< the same with what the step changes friction's limit by
  FrozenPatch::Force force;            ///< at V
  Vector3 slid = Vector3::Zero();      ///< friction at the last Newton step where it slid (x, y, about n); 0: it stuck [N, N·m]
  Matrix6 G = Matrix6::Zero();         ///< -g ∂F/∂V of the last Newton step, friction's limit kept
  Vector6 per_load = Vector6::Zero();  ///< ∂F/∂N of it by that limit [m … 1]
  Vector6 F_done = Vector6::Zero();    ///< that the last Newton step balanced, of B at P, in P's axes [N·m, N]
};

/// A spring-damper on a link, about its frame's origin.
struct FrozenCoupling {
  int link = -1;                       ///< world index
  /// C in W: g² of the springs and g of the dampers [N·m·s², N·s²/m].
  Matrix3 turn = Matrix3::Zero(), way = Matrix3::Zero();
};

}  // namespace haptic
