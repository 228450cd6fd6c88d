/// Which shapes may touch: boxes that move, sorted out by a sweep, each with the boxes that never move, by a tree; or few pairs, one by
/// one. However much ground there is where nothing lies, it costs nothing.
#pragma once
#include <limits>
#include <vector>

#include "haptic_core/geometry/search/broad_phase.h"
#include "haptic_core/world/hands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/placement.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/visits.h"

namespace haptic {

/// A lower bound of one box above an upper one of another, as indices into the bounds of all boxes, six a box: equal ones, never.
struct BoundsApart {
  int lower = 0;  ///< index of the bound that lies above the other
  int upper = 0;  ///< index of the bound that lies below it
};

/// Scratch of the search for pairs.
struct SearchWork {
  BroadPhase boxes;                   ///< of what moves; keeps the order of the boxes from call to call
  std::vector<ConvexShape::Box> moving;    ///< boxes of the model's `moving_shapes`, for the sweep
  LoadedVector<std::uint64_t> with_fixed;  ///< keys of the pairs that the tree finds
  std::vector<BoundsApart> apart_by;  ///< what last told the boxes of a listed pair apart; tried first, it changes no result
  std::vector<int> previous;          ///< slots of the pairs of the last search

  explicit SearchWork(const Model& model);  ///< set-up: room for all shapes
};

/// (in realtime) Finds the pairs of the visited boxes that overlap, for `eachOverlap`. False: there was no room for some.
bool sweepBoxes(const Model& model, const Visits& visits, const Placement& placement, SearchWork& search) noexcept;

/// (in realtime) visit(a, b) for the pairs a < b that `sweepBoxes` found and that may collide, in the order of their keys.
template <class Visit>
void eachOverlap(const Model& model, const SearchWork& search, Visit&& visit) noexcept {
  const bool all = !model.settings.leave_out;
  const std::uint64_t* fixed = search.with_fixed.begin();
  const auto visitFixed = [&](std::uint64_t below) {
    for (; fixed != search.with_fixed.end() && *fixed < below; ++fixed) {
      visit(static_cast<int>(*fixed >> 32), static_cast<int>(*fixed & 0xffffffffu));
    }
  };
  for (const BroadPhase::Pair& found : search.boxes.pairs()) {
    const int a = all ? found.a : model.moving_shapes[found.a], b = all ? found.b : model.moving_shapes[found.b];
    visitFixed(ActivePair::keyOf(a, b));
    if (!all || model.mayCollide(a, b)) visit(a, b);
  }
  visitFixed(std::numeric_limits<std::uint64_t>::max());
}

/// (in realtime) Poses and boxes of these shapes. With h > 0 boxes of implicitly stepped trees, which have yet to move, are widened by
/// how far they may come in that time [s], and those of held links by the way that they went.
void placeShapes(const Model& model, double h, const std::vector<int>& shapes, const State& state, const HandWork& hands,
                 Placement& placement) noexcept;

/// (in realtime) The pairs whose boxes overlap, of the shapes that are visited, in the order of their keys; a pair's memory comes
/// along from the last search. Sets kPairsDropped when there are more than the state has room for.
void findPairs(const Model& model, const Visits& visits, const Placement& placement, State& state, SearchWork& search,
               StepReport& report) noexcept;

}  // namespace haptic
