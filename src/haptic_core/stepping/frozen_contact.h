/// What presses and pulls in a pass of an implicit stage (frozen_problem.h).
#pragma once
#include "haptic_core/dynamics/link_force.h"
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
  FrozenPatch::Force force;            ///< at V
  bool ends_here = false;              ///< a pass has ended at V, and `force` is that there
  Vector3 slid = Vector3::Zero();      ///< friction at the last Newton step where it slid (x, y, about n); 0: it stuck [N, N·m]
  Matrix6 G = Matrix6::Zero();         ///< -g ∂F/∂V of the last Newton step, friction's limit kept
  Vector6 per_load = Vector6::Zero();  ///< ∂F/∂N of it by that limit [m … 1]
  Vector6 F_done = Vector6::Zero();    ///< that the last Newton step balanced, of B at P, in P's axes [N·m, N]
  double pulled = 0;                   ///< by which the last full Newton step would have it pull [N]
};

/// A force between two links, or a link and W, in a pass of an implicit stage: linear in the motion since the reference, but for the
/// limit of its line. A hand's coupling and every force element (dynamics/link_force.h) become one.
struct FrozenForce {
  int source = 0;                      ///< whose it is: the caller's number
  int link_a = -1, link_b = -1;        ///< world indices; A −1: W
  Vector3 p_WA = Vector3::Zero(), p_WB = Vector3::Zero();  ///< where it acts, at the reference [m]
  /// C in W: g² of the springs and g of the dampers, the line's apart [N·m·s², N·s²/m].
  Matrix3 turn = Matrix3::Zero(), way = Matrix3::Zero();
  Wrench F;                            ///< on B at p_WB at the reference, the line's apart; zero where the links' wrenches hold it
  LineForce line;                      ///< at the reference
  bool lined = false;                  ///< there is a line
  double slope = 0;                    ///< the line's part of C [N·s²/m]
  double gained = 0;                   ///< speed of B over A along the line since the reference [m/s]
  double step = 0;                     ///< of that, by J p
  double force = 0;                    ///< of the line, at `gained` [N]
  double done = 0;                     ///< of the line: force that the last Newton step balanced [N]

  /// (in realtime) `force` is one here and now; its wrench stays out where `apart` is false.
  void freeze(const LinkForce& now, double g, bool apart) noexcept {
    p_WA = now.p_WA, p_WB = now.p_WB;
    turn = g * g * now.turn_K + g * now.turn_D;
    way = g * g * now.way_K + g * now.way_D;
    F = apart ? now.F : Wrench{};
    line = now.line;
    lined = !line.n.isZero(0);
    slope = g * g * line.stiffness + g * line.damping;
  }
  /// (in realtime) Of the line where B has gained so much speed, in a stage of length g [N].
  double lineAt(double gain, double g) const noexcept { return line.within(line.spring + line.damper - slope / g * gain); }
  /// (in realtime) The line's part of C where it stands: 0 beyond its range.
  double lineSlope(double g) const noexcept {
    const double pull = line.spring + line.damper - slope / g * gained;
    return pull > line.least && pull < line.most ? slope : 0;
  }
};

}  // namespace haptic
