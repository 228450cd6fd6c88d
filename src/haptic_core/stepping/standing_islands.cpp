#include "haptic_core/stepping/standing_islands.h"

#include <algorithm>
#include <utility>

#include "haptic_core/stepping/implicit_step.h"

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

/// A free body as slow as one at rest.
bool rests(const Model& model, const ModelTree& tree, double h, const State& state, const Placement& placement) noexcept {
  if (!tree.model->isFreeBody()) return false;
  const double reach = placement.link[tree.link].p_WO.norm() + model.links[tree.link].size;
  const double rounding = kOfRounding * roundingSpeed(h * model.settings.gravity.norm(), reach, h);
  const bool calm = state.calm[model.indexOf(tree)] >= kCalmSteps;
  return isSlow(model, tree, calm ? std::max(restingSpeed(model.settings, h), rounding) : rounding, placement);
}

/// It touches something, and all of its bodies rest.
bool rests(const Model& model, const Island& island, double h, const State& state, const Placement& placement) noexcept {
  const auto touches = [&state](int pair) { return state.pairs[pair].friction.touching != 0; };
  if (!std::any_of(island.pairs, island.pairs + island.pair_count, touches)) return false;
  return std::all_of(island.trees, island.trees + island.tree_count,
                     [&](int t) { return rests(model, model.trees[t], h, state, placement); });
}

}  // namespace

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
  return true;
}

bool isCalm(const Island& island, const State& state) noexcept {
  return std::all_of(island.trees, island.trees + island.tree_count, [&](int t) { return state.calm[t] >= kCalmSteps; });
}

void countCalm(const Model& model, const HandWork& hands, const Placement& placement, State& state) noexcept {
  const double most = restingSpeed(model.settings, model.settings.step);
  for (const ModelTree* tree : hands.movers) {
    int& calm = state.calm[model.indexOf(*tree)];
    calm = isSlow(model, *tree, most, placement) ? std::min(calm + 1, kCalmSteps) : 0;
  }
}

void settleExplicit(const Model& model, double h, const Placement& placement, Islands& islands, const HandWork& hands,
                    State& state) noexcept {
  bool any = false;  // most steps have none, and need no islands
  for (std::size_t t = 0; t < model.trees.size() && !any; ++t) {
    any = state.mode[t] != TreeMode::kImplicit && rests(model, model.trees[t], h, state, placement);
  }
  if (!any) return;
  islands.find(state, hands.held_by, false);
  for (int i = 0; i < islands.count(); ++i) {
    const Island island = islands[i];
    if (state.mode[island.trees[0]] == TreeMode::kImplicit || !rests(model, island, h, state, placement)) continue;
    if (!standsAlone(model, island, state)) continue;
    for (int n = 0; n < island.tree_count; ++n) state.mode[island.trees[n]] = TreeMode::kImplicit;
  }
}

StandingIslands::StandingIslands(const Model& model) : last_(model.trees.size()), now_(model.trees.size()) {
  contacts_.reserve(model.pair_capacity);
}

void StandingIslands::open(LoadedVector<ContactReport>& contacts) noexcept {
  std::swap(contacts_, contacts);
  std::swap(last_, now_);
  std::swap(any_last_, any_);
  forget();
}

void StandingIslands::forget() noexcept {
  if (any_) std::fill(now_.begin(), now_.end(), Standing{});
  any_ = all_ = false;
  repeated_ = 0;
}

void StandingIslands::carryOver(const StandingIslands& from, const std::vector<int>& tree, const std::vector<int>& contact,
                                const std::vector<char>& stirred) noexcept {
  forget();
  for (std::size_t t = 0; t < now_.size(); ++t) {
    now_[t] = Standing{};
    if (tree[t] < 0 || stirred[t]) continue;
    Standing standing = from.now_[tree[t]];
    if (standing.contacts > 0) standing.first_contact = contact[standing.first_contact];
    now_[t] = standing;
    any_ |= standing.trees > 0;
  }
}

void StandingIslands::close(const HandWork& hands) noexcept {
  all_ = repeated_ > 0 && repeated_ == hands.movers.size() && hands.acting.empty() && hands.leading.empty();
}

bool StandingIslands::repeats(const Model& model, const Island& island, const State& state) const noexcept {
  const auto stood = [&](int tree) {
    return last_[tree].trees == island.tree_count && last_[tree].pairs == island.pair_count;
  };
  return any_last_ && std::all_of(island.trees, island.trees + island.tree_count, stood) && standsAlone(model, island, state);
}

void StandingIslands::repeat(const Island& island, const State& state, Report& report) noexcept {
  Standing standing = last_[island.trees[0]];
  const int first_contact = report.contacts.size();
  for (int i = 0; i < standing.contacts; ++i) report.addContact(contacts_[standing.first_contact + i], false);
  for (int i = 0; i < island.pair_count; ++i) report.addEnergy(state.pairs[island.pairs[i]].friction);
  report.step.residual = std::max(report.step.residual, standing.residual);
  report.step.wrench_error = std::max(report.step.wrench_error, standing.wrench_error);
  standing.first_contact = first_contact;
  repeated_ += island.tree_count;
  keep(island, standing);
}

void StandingIslands::note(const Island& island, const ImplicitReport& solved, int first_contact,
                           const Report& report) noexcept {
  Standing standing;
  standing.trees = island.tree_count;
  standing.pairs = island.pair_count;
  standing.first_contact = first_contact;
  standing.contacts = report.contacts.size() - first_contact;
  standing.residual = solved.residual;
  standing.wrench_error = solved.wrench_error;
  keep(island, standing);
}

void StandingIslands::keep(const Island& island, const Standing& standing) noexcept {
  any_ = true;
  for (int n = 0; n < island.tree_count; ++n) now_[island.trees[n]] = standing;
}

}  // namespace haptic::stepping
