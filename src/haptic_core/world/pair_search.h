/// Which shapes may touch: boxes, sorted out by a sweep or compared one by one.
#pragma once
#include <vector>

#include "haptic_core/geometry/search/broad_phase.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/placement.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// A lower bound of one box above an upper one of another, as indices into the bounds of all boxes, six a box: equal ones, never.
struct BoundsApart {
  int lower = 0;  ///< index of the bound that lies above the other
  int upper = 0;  ///< index of the bound that lies below it
};

/// Scratch of the search for pairs.
struct SearchWork {
  BroadPhase boxes;                   ///< keeps the order of the boxes from call to call
  std::vector<BoundsApart> apart_by;  ///< what last told the boxes of a listed pair apart; tried first, it changes no result
  std::vector<ActivePair> previous;   ///< pairs of the last search

  explicit SearchWork(const Model& model);  ///< set-up: room for all shapes
};

/// (in realtime) Poses and boxes of the shapes, then the pairs whose boxes overlap, in the order of their keys; what a
/// pair remembers comes along from the last search. With h > 0 boxes of implicitly stepped trees, which have yet to move,
/// are widened by how far they may come in that time [s]. Sets kPairsDropped when there are more than the state has room for.
void findPairs(const Model& model, double h, Placement& placement, State& state, SearchWork& search,
               StepReport& report) noexcept;

}  // namespace haptic
