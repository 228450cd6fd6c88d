#include "haptic_core/world/pair_search.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "haptic_core/stepping/own_rate.h"

namespace haptic {
namespace {

/// The sweep knows which pairs to leave out, and has the boxes that move; in the general step it finds all pairs of all boxes, and
/// findPairs drops them.
BroadPhase makeBroadPhase(const Model& model) {
  if (!model.settings.leave_out) return BroadPhase(static_cast<int>(model.shapes.size()), {});
  const std::vector<int>& moving = model.moving_shapes;
  const int n = static_cast<int>(moving.size());
  std::vector<std::pair<int, int>> never;
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      if (!model.mayCollide(moving[a], moving[b])) never.emplace_back(a, b);
    }
  }
  return BroadPhase(n, never, model.pair_capacity);
}

/// How far a shape may come in h [m]: twice the way at today's speed and gravity. The speed that a
/// collision adds is within it.
double margin(const Model& model, const State& state, const HandWork& hands, const Placement& placement, int shape, double h) {
  const int l = model.shapes[shape].link;
  const ModelLink& link = model.links[l];
  if (!(h > 0) || !link.moves) return 0;
  const LinkWork& work = placement.link[l];
  const int lead = hands.held_by[l];
  const double way = lead >= 0 ? hands.moved[lead].linear.norm() + hands.moved[lead].angular.norm() * (link.size + work.p_OC.norm()) : 0;
  h = stepping::foreseen(model, state, link.articulation, h);
  return std::max(way, 2 * h * (work.velocity.norm() + work.omega.norm() * link.size + h * model.settings.gravity.norm()));
}

/// Bounds of a box as numbers in a row: its three lower ones, then its three upper ones.
constexpr int kBounds = 6;
static_assert(sizeof(ConvexShape::Box) == kBounds * sizeof(double));

/// Whether two boxes are apart, and if so by which bounds. Overlap needs all comparisons to hold: with NaN they do not.
bool areApart(const ConvexShape::Box* boxes, int a, int b, BoundsApart& by) noexcept {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(boxes[a].lower[axis] <= boxes[b].upper[axis])) return by = {kBounds * a + axis, kBounds * b + 3 + axis}, true;
    if (!(boxes[b].lower[axis] <= boxes[a].upper[axis])) return by = {kBounds * b + axis, kBounds * a + 3 + axis}, true;
  }
  return false;
}

/// The list of the pairs that a step visits, by key. A pair that touched stays for once where its boxes are apart again: how it parted is
/// still to be told; and one of a tree that waits for its turn, for it was found for all that time.
class PairList {
 public:
  PairList(const Model& model, State& state, SearchWork& search)
      : model_(model), state_(state), pairs_(state.pairs), previous_(search.previous) {
    pairs_.renew(search.previous);
  }
  /// False: there is no room. (Slots of what is dropped in this search are free in the next one.)
  bool add(int a, int b) noexcept {
    const std::uint64_t key = ActivePair::keyOf(a, b);
    keepTouching(key);
    if (before_ == previous_.size() || pairs_[previous_[before_]].key != key) return pairs_.append(key) >= 0;
    pairs_.keep(previous_[before_++]);
    return true;
  }
  void finish() noexcept { keepTouching(std::numeric_limits<std::uint64_t>::max()); }

 private:
  void keepTouching(std::uint64_t below) noexcept {
    for (; before_ < previous_.size() && pairs_[previous_[before_]].key < below; ++before_) {
      const ActivePair& pair = pairs_[previous_[before_]];
      const bool stays = pair.friction.touching != 0 || waits(pair);
      stays ? pairs_.keep(previous_[before_]) : pairs_.drop(previous_[before_]);
    }
  }
  bool waits(const ActivePair& pair) const noexcept {
    return model_.turn_steps > 1 &&
           (state_.turn[model_.treeOf(pair.shapeA())] > state_.step || state_.turn[model_.treeOf(pair.shapeB())] > state_.step);
  }

  const Model& model_;
  State& state_;
  PairStore<ActivePair>& pairs_;
  const std::vector<int>& previous_;
  std::size_t before_ = 0;
};

}  // namespace

SearchWork::SearchWork(const Model& model)
    : boxes(makeBroadPhase(model)), apart_by(model.listed_pairs.size()) {
  previous.reserve(model.pair_capacity);
  if (!model.settings.leave_out) return;
  moving.resize(model.moving_shapes.size());
  with_fixed.reserve(model.pair_capacity);
}

bool sweepBoxes(const Model& model, const Visits& visits, const Placement& placement, SearchWork& search) noexcept {
  if (!model.settings.leave_out) return search.boxes.update(placement.box.data());
  search.with_fixed.clear();
  bool complete = true;
  for (const int i : visits.moving) {
    const int s = model.moving_shapes[i];
    search.moving[i] = placement.box[s];
    model.fixed_boxes.eachOverlap(placement.box[s], [&](int fixed) {
      const int f = model.fixed_shapes[fixed], a = std::min(s, f), b = std::max(s, f);
      if (model.mayCollide(a, b)) complete &= search.with_fixed.push_back(ActivePair::keyOf(a, b));
    });
  }
  std::sort(search.with_fixed.begin(), search.with_fixed.end());
  return search.boxes.update(search.moving.data()) && complete;
}

void placeShapes(const Model& model, double h, const std::vector<int>& shapes, const State& state, const HandWork& hands,
                 Placement& placement) noexcept {
  if (!model.searches_pairs) return;
  for (const int s : shapes) placeShape(model, s, margin(model, state, hands, placement, s, h), placement);
}

void findPairs(const Model& model, const Visits& visits, const Placement& placement, State& state, SearchWork& search,
               StepReport& report) noexcept {
  if (!model.searches_pairs) return;
  PairList pairs(model, state, search);
  bool complete = true;
  if (!model.listed_pairs.empty()) {
    const ConvexShape::Box* boxes = placement.box.data();
    const double* bounds = boxes->lower.data();
    for (std::size_t i = 0, n = search.apart_by.size(); i < n; ++i) {
      BoundsApart& by = search.apart_by[i];
      if (bounds[by.lower] > bounds[by.upper]) continue;
      const auto [a, b] = model.listed_pairs[i];
      if (areApart(boxes, a, b, by) || placement.areApart(a, b)) continue;
      if (!visits.leaveOut(model.treeOf(a), model.treeOf(b))) complete &= pairs.add(a, b);
    }
  } else {
    complete &= sweepBoxes(model, visits, placement, search);
    eachOverlap(model, search, [&](int a, int b) {
      if (!placement.areApart(a, b)) complete &= pairs.add(a, b);  // balls side by side across the axes; they would join islands
    });
  }
  pairs.finish();
  if (!complete) report.flags |= kPairsDropped;
}

}  // namespace haptic
