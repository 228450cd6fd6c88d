/// How far a pass of an implicit stage may carry its reference: no pair gets deeper between two references than volumes know the way
/// out of (`kShareOfWidth`), as in a trust region. A body that tips over, rolls or lands does so within one step.
#pragma once
#include <vector>

#include "haptic_core/geometry/pairs/time_of_impact.h"
#include "haptic_core/stepping/frozen_problem.h"
#include "haptic_core/stepping/stage_contacts.h"

namespace haptic {

/// The way of an island's shapes from the last reference to the next, and the share of it that may be gone.
class DepthLimit {
 public:
  DepthLimit(const Model& model, const FrozenProblem& problem, const StageContacts& contacts);  ///< all stay the caller's

  /// (in realtime) Whether a pair of the island may get too deep where bodies move by g `velocity` [s, m/s, rad/s]: bounds of ways alone.
  bool mayBePassed(const Island& island, const State& state, const double* velocity, double g) const noexcept;
  /// (in realtime) The shapes [first, end) lie at X_WS at the last reference.
  void note(const Pose* X_WS, int first, int end) noexcept;
  /// (in realtime) Share of the way from there to X_WS up to which no pair gets too deep. `first`: it begins where the stage does, and
  /// pairs touch as the state has it.
  double share(const Island& island, const State& state, const Pose* X_WS, const double* velocity, double g, bool first) const noexcept;

 private:
  double mostDepth(const ActivePair& pair) const noexcept;
  double way(const ActivePair& pair, const double* velocity, double g) const noexcept;
  ShapeMotion motion(int shape, const Pose& X_WS) const noexcept;

  const Model& model_;
  const FrozenProblem& problem_;
  const StageContacts& contacts_;
  std::vector<Pose> X_last_;  ///< by shape
};

}  // namespace haptic
