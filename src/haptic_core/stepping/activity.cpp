#include "haptic_core/stepping/activity.h"

#include <algorithm>
#include <functional>

#include "haptic_core/stepping/own_rate.h"
#include "haptic_core/world/carry_over.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {
namespace {

/// Where the middles of the model's moving shapes are at the start.
std::vector<Vector3> placesOf(const Model& model) {
  std::vector<LinkWork> link(model.links.size());
  for (const ModelTree& tree : model.trees) {
    forwardKinematics(*tree.model, model.q_start.data() + tree.q, model.v_start.data() + tree.v, link.data() + tree.link);
  }
  std::vector<Vector3> places;
  for (const int s : model.moving_shapes) {
    const ModelShape& shape = model.shapes[static_cast<std::size_t>(s)];
    places.push_back(link[static_cast<std::size_t>(shape.link)].X_WL * (shape.X_LS * shape.shape->centre()));
  }
  return places;
}

/// By tree, with the end of the last: where in an ascending list of things on links its own begin.
template <class LinkOf>
std::vector<int> firstByTree(const Model& model, std::size_t count, LinkOf&& linkOf) {
  std::vector<int> first;
  std::size_t i = 0;
  for (const ModelTree& tree : model.trees) {
    while (i < count && linkOf(i) < tree.link) ++i;
    first.push_back(static_cast<int>(i));
  }
  first.push_back(static_cast<int>(count));
  return first;
}

bool isLeftOut(const Model& model, const ActivePair& pair, const Visits& visits) noexcept {
  return visits.leaveOut(model.treeOf(pair.shapeA()), model.treeOf(pair.shapeB()));
}

template <class Is>
void dropIf(std::vector<int>& list, Is&& is) noexcept {
  list.erase(std::remove_if(list.begin(), list.end(), is), list.end());
}

}  // namespace

Activity::Activity(const Model& model)
    : on_(model.settings.leave_out), island_(model.trees.size(), -1), next_(model.trees.size(), -1), wakes_(model.trees.size()) {
  if (!on_) return;
  const auto first = [&](std::size_t count, auto&& linkOf) { return firstByTree(model, count, linkOf); };
  first_shape_ = first(model.shapes.size(), [&](std::size_t i) { return model.shapes[i].link; });
  first_slot_ = first(model.moving_shapes.size(), [&](std::size_t i) { return model.shapes[model.moving_shapes[i]].link; });
  for (std::vector<int>* list : {&islands_, &leaving_trees_, &woken_}) list->reserve(model.trees.size());
  leaving_.reserve(model.trees.size());
  merged_.reserve(std::max(model.shapes.size(), static_cast<std::size_t>(model.pair_capacity)));
  boxes_ = BoxSlots(placesOf(model));
}

void Activity::leave(const Island& island, const State& state, Visits& visits) noexcept {
  if (!on_) return;
  leaving_.push_back({static_cast<int>(leaving_trees_.size()), island.tree_count});
  leaving_trees_.insert(leaving_trees_.end(), island.trees, island.trees + island.tree_count);
  const Phase phase = state.turn[island.trees[0]] != 0 ? Phase::kWaits : Phase::kRests;
  for (int n = 0; n < island.tree_count; ++n) visits.phase[island.trees[n]] = phase;
}

void Activity::close(const Model& model, State& state, Work& work, StepReport& report) noexcept {
  report.implicit_islands += static_cast<int>(islands_.size());
  report.standing += trees_ - waiting_;
  report.waiting += waiting_;
  report.flags |= flags_;
  const HandWork& hands = work.hands;
  idle_ = trees_ > 0 && waiting_ == 0 && hands.movers.empty() && hands.acting.empty() && hands.leading.empty();
  if (work.stopped) {
    for (const int t : leaving_trees_) work.visits.phase[t] = Phase::kMoves;
  } else if (!leaving_.empty()) {
    for (const Leaving& island : leaving_) lay(model, island, state, work);
    state.pairs.rest([&](int i) { return isLeftOut(model, state.pairs[i], work.visits); });
    changed(model, state, work);
  }
  leaving_.clear(), leaving_trees_.clear();
  work.reported.list(state.pairs.awake());
  report.pairs = state.pairs.count();
  report.contacts = work.reported.count();
}

/// Its trees leave, each box as wide as it may come until the next turn, from where it is now.
void Activity::lay(const Model& model, const Leaving& island, const State& state, Work& work) noexcept {
  const int* trees = &leaving_trees_[static_cast<std::size_t>(island.first)];
  islands_.push_back(trees[0]);
  trees_ += island.count;
  const bool waits = work.visits.phase[trees[0]] == Phase::kWaits;
  if (waits) waiting_ += island.count;
  for (int n = 0; n < island.count; ++n) {
    const int t = trees[n];
    island_[t] = trees[0];
    next_[t] = n + 1 < island.count ? trees[n + 1] : -1;
    if (!model.searches_pairs) continue;
    if (waits) {
      merged_.clear();
      for (int s = first_shape_[t]; s < first_shape_[t + 1]; ++s) merged_.push_back(s);
      placeShapes(model, model.settings.step, merged_, state, work.hands, work.placement);
    }
    for (int i = first_slot_[t]; i < first_slot_[t + 1]; ++i) boxes_.put(i, work.placement.box[model.moving_shapes[i]]);
  }
}

/// The lists that a step visits, without what is left out.
void Activity::changed(const Model& model, const State& state, Work& work) noexcept {
  ++changes_;
  Visits& visits = work.visits;
  const auto left = [&](int tree) { return visits.phase[tree] != Phase::kMoves; };
  dropIf(visits.trees, left);
  dropIf(visits.shapes, [&](int s) { return left(model.treeOf(s)); });
  dropIf(visits.moving, [&](int i) { return left(model.treeOf(model.moving_shapes[i])); });
  work.search.boxes.select(visits.moving);
  work.hands.movers.clear();
  for (const int t : visits.trees) {
    if (work.hands.movesByItself(model.trees[t])) work.hands.movers.push_back(&model.trees[t]);
  }
  flags_ = 0;
  work.reported.list(state.pairs.awake());
  work.reported.listResting(state.pairs.resting());
  for (const int slot : work.reported.resting()) flags_ |= flagsOf(work.reported[slot]);
}

void Activity::mark(int tree) noexcept {
  const int island = island_[tree];
  if (island < 0 || wakes_[island]) return;
  wakes_[island] = 1;
  ++marked_;
}

void Activity::wakeNear(const Model& model, double h, State& state, Work& work) noexcept {
  if (islands_.empty() || !model.searches_pairs) return;
  for (const int s : work.visits.shapes) {
    boxes_.eachOverlap(work.placement.box[s], [&](int slot) {
      const int other = model.moving_shapes[slot];
      if (model.mayCollide(std::min(s, other), std::max(s, other)) && !work.placement.areApart(s, other)) mark(model.treeOf(other));
    });
  }
  if (marked_ == 0) return;
  wakeMarked(model, state, work);
  placeShapes(model, h, work.visits.shapes, state, work.hands, work.placement);
}

void Activity::wakeForStep(const Model& model, State& state, Work& work) noexcept {
  for (const PointerState& pointer : state.pointers) {
    if (pointer.targeted && pointer.link >= 0) mark(model.links[pointer.link].articulation);
  }
  for (std::size_t i = 0; waiting_ > 0 && i < islands_.size(); ++i) {
    if (isDue(state, islands_[i])) mark(islands_[i]);
  }
  if (marked_ > 0) wakeMarked(model, state, work);
}

void Activity::wakeAll(const Model& model, bool waiting_only, State& state, Work& work) noexcept {
  idle_ = false;
  for (const int island : islands_) {
    if (!waiting_only || work.visits.phase[island] == Phase::kWaits) mark(island);
  }
  if (marked_ > 0) wakeMarked(model, state, work);
}

void Activity::wakeMarked(const Model& model, State& state, Work& work) noexcept {
  marked_ = 0;
  Visits& visits = work.visits;
  woken_.clear();
  for (const int island : islands_) {
    for (int t = island; wakes_[island] && t >= 0; t = next_[t]) woken_.push_back(t);
  }
  dropIf(islands_, [this](int island) { return wakes_[island] != 0; });
  std::sort(woken_.begin(), woken_.end());
  trees_ -= static_cast<int>(woken_.size());
  for (const int t : woken_) {
    if (visits.phase[t] == Phase::kWaits) --waiting_;
    visits.phase[t] = Phase::kMoves;
    wakes_[t] = 0;
    island_[t] = next_[t] = -1;
    for (int i = first_slot_[t]; i < first_slot_[t + 1]; ++i) boxes_.clear(i);
  }
  state.pairs.wake([&](int i) { return !isLeftOut(model, state.pairs[i], visits); });
  const auto ofTrees = [this](const std::vector<int>& first, auto&& of, std::vector<int>& list) {
    merged_.clear();
    for (const int t : woken_) {
      for (int i = first[t]; i < first[t + 1]; ++i) {
        if (of(i)) merged_.push_back(i);
      }
    }
    merge(merged_, list, std::less<int>());
  };
  merge(woken_, visits.trees, std::less<int>());
  if (model.has_contacts) ofTrees(first_shape_, [&](int s) { return model.links[model.shapes[s].link].moves; }, visits.shapes);
  ofTrees(first_slot_, [](int) { return true; }, visits.moving);
  changed(model, state, work);
}

void Activity::carryOver(const Activity& from, const CarryOver& map, const Work& old_work, const Model& model, State& state,
                         Work& work) noexcept {
  if (!on_) return;
  for (const int first : from.islands_) {
    Leaving island{static_cast<int>(leaving_trees_.size()), 0};
    bool whole = true;
    for (int t = first; t >= 0; t = from.next_[t]) {
      const int now = map.tree_now[t];
      whole &= now >= 0 && !map.stirred[now];
      if (whole) leaving_trees_.push_back(now);
    }
    island.count = static_cast<int>(leaving_trees_.size()) - island.first;
    if (!whole) {
      leaving_trees_.resize(static_cast<std::size_t>(island.first));
      continue;
    }
    for (int t = first; t >= 0; t = from.next_[t]) {
      const int now = map.tree_now[t];
      work.visits.phase[now] = Phase::kRests;
      work.sums.now[now] = old_work.sums.now[t];
      work.sums.tree.set(static_cast<std::size_t>(now), work.sums.now[now]);
      merged_.clear();
      for (int s = first_shape_[now]; s < first_shape_[now + 1]; ++s) merged_.push_back(s);
      placeShapes(model, model.settings.step, merged_, state, work.hands, work.placement);
    }
    lay(model, island, state, work);
  }
  leaving_trees_.clear();
  state.pairs.rest([&](int i) { return isLeftOut(model, state.pairs[i], work.visits); });
  changed(model, state, work);
}

void lookForPairs(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept {
  placeShapes(model, h, work.visits.shapes, state, work.hands, work.placement);
  work.activity.wakeNear(model, h, state, work);
  findPairs(model, work.visits, work.placement, state, work.search, report);
}

}  // namespace haptic::stepping
