#include "haptic_core/stepping/standing_islands.h"

#include <algorithm>
#include <utility>

#include "haptic_core/stepping/implicit_step.h"

namespace haptic::stepping {
namespace {

/// No hand pulls at it, no joint has a law of its own, and what its pairs know beside it never moves.
bool isAlone(const Model& model, const Island& island, const State& state) noexcept {
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

}  // namespace

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
  any_ = false;
}

bool StandingIslands::repeats(const Model& model, const Island& island, const State& state, bool looks) const noexcept {
  const auto stood = [&](int tree) {
    return last_[tree].trees == island.tree_count && last_[tree].pairs == island.pair_count && (last_[tree].looked || !looks);
  };
  return any_last_ && std::all_of(island.trees, island.trees + island.tree_count, stood) && isAlone(model, island, state);
}

void StandingIslands::repeat(const Island& island, const State& state, Report& report) noexcept {
  Standing standing = last_[island.trees[0]];
  const int first_contact = report.contacts.size();
  for (int i = 0; i < standing.contacts; ++i) report.addContact(contacts_[standing.first_contact + i], false);
  for (int i = 0; i < island.pair_count; ++i) report.addEnergy(state.pairs[island.pairs[i]].friction);
  report.step.residual = std::max(report.step.residual, standing.residual);
  report.step.wrench_error = std::max(report.step.wrench_error, standing.wrench_error);
  standing.first_contact = first_contact;
  keep(island, standing);
}

void StandingIslands::note(const Island& island, const ImplicitReport& solved, bool looked, int first_contact,
                           const Report& report) noexcept {
  Standing standing;
  standing.trees = island.tree_count;
  standing.pairs = island.pair_count;
  standing.looked = looked || last_[island.trees[0]].looked;
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
