#include "haptic_core/stepping/standing_islands.h"

#include <algorithm>

#include "haptic_core/world/link_forces.h"

namespace haptic::stepping {
namespace {

/// No link of the tree is faster than `most` [m/s].
bool isSlow(const Model& model, const ModelTree& tree, double most, const Placement& placement) noexcept {
  for (int l = tree.link; l < tree.link + tree.model->linkCount(); ++l) {
    const LinkWork& link = placement.link[l];
    const double size = model.links[l].size;
    if (!(link.velocity.squaredNorm() + size * size * link.omega.squaredNorm() <= most * most)) return false;
  }
  return true;
}

}  // namespace

bool isStill(const Model& model, int tree, const State& state) noexcept {
  const double* v = state.v.data() + model.trees[tree].v;
  return std::all_of(v, v + model.trees[tree].model->nv(), [](double x) { return x == 0; });
}

bool standsAlone(const Model& model, const Island& island, const State& state) noexcept {
  const auto has = [&island](int tree) { return std::binary_search(island.trees, island.trees + island.tree_count, tree); };
  for (int n = 0; n < island.tree_count; ++n) {
    if (model.trees[island.trees[n]].has_laws) return false;
  }
  for (const PointerState& pointer : state.pointers) {
    if (pointer.targeted && has(model.links[pointer.link].articulation)) return false;
  }
  for (int i = 0; i < island.pair_count; ++i) {
    const ActivePair& pair = state.pairs[island.pairs[i]];
    for (const int tree : {model.treeOf(pair.shapeA()), model.treeOf(pair.shapeB())}) {
      if (!model.trees[tree].model->isStatic() && !has(tree)) return false;
    }
  }
  return model.forces.empty() || forcesStayWithin(model, {island.trees, island.tree_count});
}

bool isCalm(const Island& island, const State& state) noexcept {
  return std::all_of(island.trees, island.trees + island.tree_count, [&](int t) { return state.calm[t] >= kCalmSteps; });
}

void countCalm(const Model& model, const HandWork& hands, const Placement& placement, State& state) noexcept {
  const double most = restingSpeed(model.settings, model.settings.step);
  for (const ModelTree* tree : hands.movers) {
    const int t = model.indexOf(*tree);
    if (state.turn[t] != 0 && state.as_of[t] <= state.step) continue;  // it has been counted at its turn
    state.calm[t] = isSlow(model, *tree, most, placement) ? std::min(state.calm[t] + 1, kCalmSteps) : 0;
  }
  for (const PointerState& pointer : state.pointers) {
    if (pointer.link >= 0 && hands.held_by[pointer.link] >= 0) state.calm[model.links[pointer.link].articulation] = 0;
  }
}

void countCalm(const Model& model, const Island& island, int steps, const Placement& placement, State& state) noexcept {
  const double most = restingSpeed(model.settings, model.settings.step);
  for (int n = 0; n < island.tree_count; ++n) {
    int& calm = state.calm[island.trees[n]];
    calm = isSlow(model, model.trees[island.trees[n]], most, placement) ? std::min(calm + steps, kCalmSteps) : 0;
  }
}

StandingIslands::StandingIslands(const Model& model) : island_(model.trees.size()) { contacts_.reserve(model.pair_capacity); }

void StandingIslands::open(LoadedVector<ContactReport>& contacts) noexcept {
  contacts_.swap(contacts);
  ++turn_;
  all_ = false;
  repeated_ = 0;
}

void StandingIslands::forget() noexcept {
  turn_ += 2;  // the memory is neither of this step nor of the last
  all_ = false;
  repeated_ = 0;
}

void StandingIslands::carryOver(const StandingIslands& from, const std::vector<int>& tree, const std::vector<int>& contact,
                                const std::vector<char>& stirred) noexcept {
  forget();
  for (std::size_t t = 0; t < island_.size(); ++t) {
    if (tree[t] < 0 || stirred[t] || !from.holds(tree[t])) continue;
    Standing standing = from.island_[tree[t]];
    if (standing.contacts > 0) standing.first_contact = contact[standing.first_contact];
    put(static_cast<int>(t), standing, false);
  }
}

void StandingIslands::close(const HandWork& hands, bool any_sleeps, bool any_waits) noexcept {
  all_ = !any_waits && (repeated_ > 0 || any_sleeps) && repeated_ == hands.movers.size() && hands.acting.empty() && hands.leading.empty();
}

bool StandingIslands::repeats(const Model& model, const Island& island, const State& state) const noexcept {
  const auto stood = [&](int tree) {
    const Standing& last = island_[tree];
    return last.turn + 1 == turn_ && last.trees == island.tree_count && last.pairs == island.pair_count;
  };
  return std::all_of(island.trees, island.trees + island.tree_count, stood) && standsAlone(model, island, state);
}

void StandingIslands::repeat(const Island& island, Report& report) noexcept {
  Standing standing = island_[island.trees[0]];
  const int first_contact = report.contacts.size();
  for (int i = 0; i < standing.contacts; ++i) report.addContact(contacts_[standing.first_contact + i], false);
  standing.first_contact = first_contact;
  repeated_ += static_cast<std::size_t>(island.tree_count);
  keep(island, standing);
}

void StandingIslands::note(const Island& island, int first_contact, const Report& report) noexcept {
  Standing standing;
  standing.trees = island.tree_count;
  standing.pairs = island.pair_count;
  standing.first_contact = first_contact;
  standing.contacts = report.contacts.size() - first_contact;
  keep(island, standing);
}

void StandingIslands::put(int tree, Standing standing, bool within) noexcept {
  standing.turn = within ? turn_ - 1 : turn_;
  island_[tree] = standing;
}

void StandingIslands::keep(const Island& island, Standing standing) noexcept {
  for (int n = 0; n < island.tree_count; ++n) put(island.trees[n], standing, false);
}

}  // namespace haptic::stepping
