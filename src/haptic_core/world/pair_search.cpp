#include "haptic_core/world/pair_search.h"

#include <limits>
#include <utility>

namespace haptic {
namespace {

/// The sweep knows which pairs to leave out; in the general step it finds them all, and findPairs drops them.
BroadPhase makeBroadPhase(const Model& model) {
  const int n = static_cast<int>(model.shapes.size());
  const bool leave_out = model.settings.leave_out;
  std::vector<std::pair<int, int>> never;
  for (int a = 0; leave_out && a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      if (!model.mayCollide(a, b)) never.emplace_back(a, b);
    }
  }
  return BroadPhase(n, never, leave_out ? model.pair_capacity : 0);
}

/// How far an implicitly stepped shape may come in h [m]: twice the way at today's speed and gravity. What a collision
/// adds to the speed is within it.
double margin(const Model& model, const State& state, const Placement& placement, int shape, double h) {
  const int l = model.shapes[shape].link;
  const ModelLink& link = model.links[l];
  if (!(h > 0) || !link.moves || state.mode[link.articulation] != TreeMode::kImplicit) return 0;
  const LinkWork& work = placement.link[l];
  return 2 * h * (work.velocity.norm() + work.omega.norm() * link.size + h * model.settings.gravity.norm());
}

/// Whether two boxes are apart along an axis, tried first along the one that told them apart last: most pairs that are, stay so.
bool boxesApart(const ConvexShape::Box& A, const ConvexShape::Box& B, std::uint8_t& axis) noexcept {
  const auto apart = [&](int i) { return !(A.lower[i] <= B.upper[i] && B.lower[i] <= A.upper[i]); };
  if (apart(axis)) return true;
  for (std::uint8_t i = 0; i < 3; ++i) {
    if (apart(i)) return axis = i, true;
  }
  return false;
}

/// Fills the state's pairs in the order of their keys. A pair that touched stays for once where its boxes are apart again: how
/// it parted is still to be told.
class PairList {
 public:
  PairList(State& state, SearchWork& search) : state_(state), previous_(search.previous), count_before_(state.pair_count) {
    std::swap(search.previous, state.pairs);
    state.pair_count = 0;
  }
  /// False: there is no room.
  bool add(int a, int b) noexcept {
    ActivePair pair;
    pair.key = ActivePair::keyOf(a, b);
    const bool room = keepTouching(pair.key);
    if (before_ < count_before_ && previous_[before_].key == pair.key) pair = previous_[before_++];
    return put(pair) && room;
  }
  bool finish() noexcept { return keepTouching(std::numeric_limits<std::uint64_t>::max()); }

 private:
  bool keepTouching(std::uint64_t below) noexcept {
    bool room = true;
    for (; before_ < count_before_ && previous_[before_].key < below; ++before_) {
      if (previous_[before_].friction.touching != 0) room &= put(previous_[before_]);
    }
    return room;
  }
  bool put(const ActivePair& pair) noexcept {
    if (state_.pair_count == static_cast<int>(state_.pairs.size())) return false;
    state_.pairs[state_.pair_count++] = pair;
    return true;
  }

  State& state_;
  const std::vector<ActivePair>& previous_;
  int before_ = 0, count_before_;
};

}  // namespace

SearchWork::SearchWork(const Model& model)
    : boxes(makeBroadPhase(model)), apart_along(model.listed_pairs.size()), previous(model.pair_capacity) {}

void findPairs(const Model& model, double h, Placement& placement, State& state, SearchWork& search,
               StepReport& report) noexcept {
  if (!model.searches_pairs) return;
  for (const int s : model.updated_shapes) placeShape(model, s, margin(model, state, placement, s, h), placement);
  PairList pairs(state, search);
  bool complete = true;
  if (!model.listed_pairs.empty()) {
    for (std::size_t i = 0; i < model.listed_pairs.size(); ++i) {
      const auto& [a, b] = model.listed_pairs[i];
      if (!boxesApart(placement.box[a], placement.box[b], search.apart_along[i]) && !placement.areApart(a, b)) {
        complete &= pairs.add(a, b);
      }
    }
  } else {
    complete &= search.boxes.update(placement.box.data());
    for (const BroadPhase::Pair& found : search.boxes.pairs()) {
      if (placement.areApart(found.a, found.b)) continue;  // balls side by side across the axes; they would join islands
      if (model.settings.leave_out || model.mayCollide(found.a, found.b)) complete &= pairs.add(found.a, found.b);
    }
  }
  complete &= pairs.finish();
  if (!complete) report.flags |= kPairsDropped;
}

}  // namespace haptic
