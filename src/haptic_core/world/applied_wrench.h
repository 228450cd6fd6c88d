/// Wrenches that somebody applies to links for a time: a push, a test of stiffness, a thruster.
///
/// A wrench is constant from one step to another, in W or in the link, about a point of the link. It starts and ends between two
/// steps, so its impulse is F times the time, whatever the attempt: velocity Verlet looks at the forces again where it jumps, and
/// BDF2 does not take up from before. Explicit steps see it at each evaluation, implicit ones in each pass at the pose of the stage's end.
///
/// Its work is F times the way of its point, the mean of both ends: exact for a force that keeps its direction in W, of second order
/// for one that turns with the link. A link that a hand or a motion leads goes where it is led: a wrench on it does nothing.
#pragma once
#include <vector>

#include "haptic_core/dynamics/kinematics.h"
#include "haptic_core/world/hands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/placement.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// Where the wrenches were at the start of a part of a step.
struct WrenchWork {
  /// One of them.
  struct Place {
    Vector3 p_W = Vector3::Zero();   ///< of its point [m]
    Wrench F_W;                      ///< about it
    Vector3 omega = Vector3::Zero(); ///< of the link [rad/s]
  };
  std::vector<Place> before;         ///< in the order of State::wrenches

  WrenchWork() : before(kMostWrenches) {}  ///< set-up
};

/// (in realtime) About its point, in W.
Wrench wrenchInWorld(const LinkWrench& wrench, const LinkWork& link) noexcept;

/// (in realtime) Adds what acts on the links of a tree; `link`: by world index.
void addWrenches(const Model& model, const State& state, int tree, LinkWork* link) noexcept;

/// (in realtime) Something acts on this tree.
bool anyWrench(const Model& model, const State& state, int tree) noexcept;

/// (in realtime) Before a part of a step, everything placed.
void noteWrenches(const State& state, const Placement& placement, WrenchWork& work) noexcept;

/// (in realtime) After a part of length h [s]: the work goes into the ledger's `external`.
void bookWrenches(const HandWork& hands, double h, const WrenchWork& work, const Placement& placement, State& state) noexcept;

}  // namespace haptic
