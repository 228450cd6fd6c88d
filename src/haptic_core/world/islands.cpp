#include "haptic_core/world/islands.h"

#include <algorithm>

#include "haptic_core/stepping/own_rate.h"
#include "haptic_core/world/link_forces.h"

namespace haptic {

Islands::Islands(const Model& model) : model_(model), joined_(model.trees.size()) {
  const std::size_t trees = model.trees.size(), pairs = static_cast<std::size_t>(model.pair_capacity);
  island_.resize(trees, -1);
  trees_.resize(trees);
  pairs_.resize(pairs);
  pair_island_.resize(pairs);
  first_tree_.resize(trees + 1);
  first_pair_.resize(trees + 1);
}

void Islands::find(const State& state, const std::vector<int>& trees, const std::vector<int>& held_by) noexcept {
  const auto moves = [&](int t) {
    return !model_.trees[t].model->isStatic() && held_by[model_.trees[t].link] < 0;
  };
  group(state, trees, moves, [](int) { return true; });
}

void Islands::findDue(const State& state, const std::vector<int>& trees, std::uint64_t as_of) noexcept {
  const auto moves = [&](int t) { return stepping::isDue(state, t) && state.as_of[t] == as_of; };
  group(state, trees, moves, [this](int t) { return model_.trees[t].model->isStatic(); });
}

/// `joins`: a pair with a tree that does not move belongs to the island of the other side.
template <class Moves, class Joins>
void Islands::group(const State& state, const std::vector<int>& trees, Moves&& moves, Joins&& joins) noexcept {
  for (const int t : trees) joined_.separate(t);
  const auto treeOf = [this](int shape) { return model_.links[model_.shapes[shape].link].articulation; };
  for (const int i : state.pairs.awake()) {
    const int a = treeOf(state.pairs[i].shapeA()), b = treeOf(state.pairs[i].shapeB());
    if (moves(a) && moves(b)) joined_.merge(a, b);
  }
  eachForce(model_, trees, moves, [&](int, const ModelForce& force) {
    if (force.tree_a >= 0 && force.tree_b >= 0 && moves(force.tree_a) && moves(force.tree_b)) joined_.merge(force.tree_a, force.tree_b);
  });
  count_ = 0;
  for (const int t : trees) {
    const int root = joined_.root(t);  // the lowest tree: islands come out in its order
    island_[t] = !moves(t) ? -1 : root == t ? count_++ : island_[root];
  }
  std::fill_n(first_tree_.begin(), count_ + 1, 0);
  std::fill_n(first_pair_.begin(), count_ + 1, 0);
  for (const int t : trees) {
    if (island_[t] >= 0) ++first_tree_[island_[t] + 1];
  }
  for (const int i : state.pairs.awake()) {
    const int tree_a = treeOf(state.pairs[i].shapeA()), tree_b = treeOf(state.pairs[i].shapeB());
    const int a = island_[tree_a], b = island_[tree_b];
    pair_island_[i] = a >= 0 && (b >= 0 || joins(tree_b)) ? a : b >= 0 && joins(tree_a) ? b : -1;
    if (pair_island_[i] >= 0) ++first_pair_[pair_island_[i] + 1];
  }
  for (int i = 0; i < count_; ++i) {
    first_tree_[i + 1] += first_tree_[i];
    first_pair_[i + 1] += first_pair_[i];
  }
  // Filled from the front; the ranges' ends move up and are put back afterwards.
  for (const int t : trees) {
    if (island_[t] >= 0) trees_[first_tree_[island_[t]]++] = t;
  }
  for (const int i : state.pairs.awake()) {
    if (pair_island_[i] >= 0) pairs_[first_pair_[pair_island_[i]]++] = i;
  }
  for (int i = count_; i > 0; --i) {
    first_tree_[i] = first_tree_[i - 1];
    first_pair_[i] = first_pair_[i - 1];
  }
  first_tree_[0] = first_pair_[0] = 0;
}

}  // namespace haptic
