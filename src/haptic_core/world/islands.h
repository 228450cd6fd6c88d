/// Trees joined by pairs that may touch and by force elements: they have to be solved together, and with no others.
#pragma once
#include <vector>

#include "haptic_core/base/disjoint_sets.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// Trees that pairs and force elements connect, with those pairs. The arrays belong to Islands.
struct Island {
  const int* trees = nullptr;  ///< ascending
  int tree_count = 0;          ///< trees in it
  const int* pairs = nullptr;  ///< slots of State::pairs, by key
  int pair_count = 0;          ///< pairs in it
};

/// Groups trees into islands that have to be solved together.
/// Trees that do not move by themselves (static ones, those that a hand holds) join no others and belong to no island;
/// their pairs belong to the island of the other side.
class Islands {
 public:
  explicit Islands(const Model& model);  ///< set-up: room for all trees and pairs

  /// (in realtime) From the pairs in `state` and the force elements, of those of `trees` that move by themselves.
  /// O(trees + pairs + elements).
  void find(const State& state, const std::vector<int>& trees, const std::vector<int>& held_by) noexcept;
  /// (in realtime) Likewise of those whose turn has come and that are as they were after `as_of` steps; pairs with others that move are
  /// left out.
  void findDue(const State& state, const std::vector<int>& trees, std::uint64_t as_of) noexcept;

  int count() const { return count_; }  ///< of the last `find`
  /// Island i < count(), until the next `find`.
  Island operator[](int i) const {
    return {trees_.data() + first_tree_[i], first_tree_[i + 1] - first_tree_[i], pairs_.data() + first_pair_[i],
            first_pair_[i + 1] - first_pair_[i]};
  }
  int of(int tree) const { return island_[tree]; }  ///< -1: does not move by itself

 private:
  template <class Moves, class Joins>
  void group(const State& state, const std::vector<int>& trees, Moves&& moves, Joins&& joins) noexcept;

  const Model& model_;
  int count_ = 0;
  DisjointSets joined_;      ///< of trees
  std::vector<int> island_;  ///< by tree
  std::vector<int> trees_, pairs_, first_tree_, first_pair_, pair_island_;
};

}  // namespace haptic
