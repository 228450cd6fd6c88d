/// Hands in the world: targets, links whose motion a hand prescribes, spring-dampers that pull at links, grabbing.
///
/// Direct coupling (the seeds'): the link goes where the hand is, and the contact wrench on it goes to the hand. Virtual
/// coupling: a spring-damper from the hand's target to the link, whose opposite goes to the hand.
#pragma once
#include <vector>

#include "haptic_core/world/hand_bound.h"
#include "haptic_core/world/held_proxy.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/placement.h"
#include "haptic_core/world/contact_reports.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// Where a held link shall be at the end of the step, and how it moves there.
struct HeldGoal {
  Vector3 p_WL = Vector3::Zero();            ///< [m]
  Quaternion q_WL = Quaternion::Identity();  ///< orientation
  Twist V_WL;                                ///< at L's origin, in W
};

/// Scratch of the hands in a step, and of the motions of the scene: both lead links. A lead is a pointer, or a motion with the number of
/// pointers added to its index.
struct HandWork {
  // Follow from tuning and from which links are held: refreshed by `refreshHands`, at load, grab, tune and restore.
  std::vector<int> held_by;                   ///< by world link: lead that prescribes its motion; -1: none
  std::vector<PointerCoupling> own_coupling;  ///< by pointer, with nothing left to derive
  std::vector<const ModelTree*> movers;       ///< trees that move by themselves
  double moving_mass = 0;                     ///< of all of them [kg]

  /// By lead. The caller that moves the pointer tells the hand's bound before a step; the rest is of one step. Motions bear anything.
  std::vector<HandBound> bound;
  std::vector<double> pressed;  ///< by world link: force that surfaces carry under it [N]: a hand's and its weight; 0: none

  // Of one step.
  std::vector<int> acting;      ///< pointers that hold a link, or pull at one because they have a target; ascending
  std::vector<PointerCoupling> coupling;  ///< by pointer: `own_coupling`, or less where the hand bears less
  std::vector<int> leading;     ///< leads that move their link in it; ascending
  std::vector<HeldGoal> goal;   ///< by lead: where a held link goes, the target or less far (held_proxy.h)
  std::vector<Twist> moved;     ///< by lead: displacement of a held link in this step [rad], [m]
  /// By pointer: the step's estimate of the error of its hand's force, as a mean over the step [N].
  std::vector<double> force_error;
  std::vector<Wrench> wrench;   ///< by pointer: of the world on the hand, mean over the step

  ProxyWork proxy;              ///< of `aimHeld`

  explicit HandWork(const Model& model);  ///< set-up: room for all pointers and links
  /// It has degrees of freedom, and no hand holds it.
  bool movesByItself(const ModelTree& tree) const noexcept {
    return !tree.model->isStatic() && held_by[tree.link] < 0;
  }
};

/// (in realtime) After the tuning, the pointers' links or the state have changed.
void refreshHands(const Model& model, const State& state, HandWork& hands) noexcept;

/// (in realtime) A link that moves and is not held by another; for direct coupling a free body.
bool canGrab(const Model& model, const HandWork& hands, int pointer, int link) noexcept;
/// (in realtime) Makes another link the pointer, its target where the link is; the caller has asked `canGrab`.
void grab(const Model& model, const Placement& placement, int pointer, int link, State& state, HandWork& hands) noexcept;
/// Throws SetupError that says why the link cannot be grabbed; nothing where it can.
void checkGrab(const Model& model, const HandWork& hands, int pointer, int link);

/// (in realtime) World link that a lead moves; -1: a pointer without one.
int ledLink(const Model& model, const State& state, int lead) noexcept;

/// (in realtime) Before a step: which pointers act in it, and which leads move their links. The other pointers' hands feel nothing.
void findActing(const Model& model, State& state, HandWork& hands) noexcept;

/// (in realtime) Where the hand wants the pointer's frame at the end of the next step. Numbers that are not finite are ignored.
void aim(PointerState& pointer, const Pose& X_WP, const Twist& V_WP) noexcept;

/// (in realtime) Where motions are after a step of length h [s] becomes their goals.
void aimMotions(const Model& model, double h, const State& state, HandWork& hands) noexcept;

/// (in realtime) Held links go to their goals.
void moveHeld(const Model& model, State& state, HandWork& hands, Placement& placement) noexcept;

/// Stiffness and damping of a virtual coupling, in W.
struct CouplingMatrices {
  Matrix3 stiffness, damping;                          ///< [N/m], [N·s/m]
  Matrix3 rotational_stiffness, rotational_damping;    ///< [N·m/rad], [N·m·s/rad]
};
/// (in realtime) Of a pointer's frame that stands as R_WP and shall stand as R_WT.
CouplingMatrices matricesOf(const PointerCoupling& coupling, const Matrix3& R_WP, const Matrix3& R_WT) noexcept;

/// (in realtime) Wrench of a virtual coupling on its link, about the origin of the pointer's frame P, in W; T: the target of the link.
Wrench couplingForce(const PointerCoupling& coupling, const Pose& X_LP, const HeldGoal& T, const LinkWork& link) noexcept;

/// (in realtime) Wrenches of contacts and force elements on a held link go to its hand. Each contact books the hand's supply (ledger.h);
/// without a ledger it is estimated here, so that pushed bodies are not taken for a runaway.
void collectHeld(const Model& model, const ContactReports& contacts, const Placement& placement, State& state, HandWork& hands) noexcept;

/// (in realtime) The wrench of the step on each hand; zero when the world has stopped. `wrench_error`: that solves left out of balance [N].
void tellHands(bool stopped, double wrench_error, HandWork& hands, State& state) noexcept;

}  // namespace haptic
