/// Disjoint sets of the numbers 0 … n-1: which of them chains of pairs connect.
///
/// Each set is a tree whose root stands for it. A search halves the way to the root (Tarjan, van Leeuwen: Worst-case analysis of set
/// union algorithms, Journal of the ACM 31, 1984, section 2). The caller says which of two roots stays: with the lowest, roots are found
/// in the order of their sets. Cost of a search or a union O(log n) in the mean over many. Numbers out of range are the caller's fault.
#pragma once
#include <algorithm>
#include <numeric>
#include <vector>

namespace haptic {

/// Sets that pairs of numbers merge.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count = 0) : parent_(count) { separate(); }  ///< set-up: so many sets of one number each

  /// (in realtime) Every number is a set of its own.
  void separate() noexcept { std::iota(parent_.begin(), parent_.end(), 0); }
  /// (in realtime) So is x. Its set must have no other members, or all of them must be taken out before the next search.
  void separate(int x) noexcept { parent_[x] = x; }

  /// (in realtime) The number that stands for the set of x.
  int root(int x) noexcept {
    while (parent_[x] != x) x = parent_[x] = parent_[parent_[x]];
    return x;
  }
  /// (in realtime) Merges the set of y into that of x, whose root stays.
  void mergeInto(int x, int y) noexcept { parent_[root(y)] = root(x); }
  /// (in realtime) Merges two sets, of whose roots the lower stays.
  void merge(int x, int y) noexcept {
    const int a = root(x), b = root(y);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;  ///< by number; a root is its own
};

}  // namespace haptic
