/// Which pairs of boxes overlap: sweep and prune.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic {

/// Finds the pairs of boxes that overlap, by sweep and prune.
/// Boxes are sorted by their lower ends along the axis of the widest spread (insertion sort: nearly sorted
/// from the last step), then each is compared with those that begin before it ends. Pairs come out ordered, a
/// < b and ascending, and depend on the boxes alone: the sorting left from earlier steps changes no result
/// and need not be saved. Cost about N times the boxes in a slab; 1000 boxes in a cube: see
/// `contact.broadphase_1000_us`. Boxes that are not selected cost nothing.
class BroadPhase {
 public:
  /// Two boxes by index.
  struct Pair {
    int a, b;  ///< a < b
    bool operator==(const Pair& o) const { return a == o.a && b == o.b; }  ///< the same two
  };

  /// `never[i]` lists pairs (any order) that are left out for good: static with static, links of one body,
  /// filters. `max_pairs` bounds the result; 0: as many pairs as are allowed, at most 64 per box.
  BroadPhase(int box_count, const std::vector<std::pair<int, int>>& never, int max_pairs = 0);

  /// True when a and b may meet at all.
  bool allowed(int a, int b) const { return !(never_[bit(a, b) >> 6] >> (bit(a, b) & 63) & 1); }
  int boxCount() const { return count_; }  ///< boxes it was made for

  /// (in realtime) Finds the pairs of `boxes` (box_count of them, in one frame) that touch or overlap. False
  /// when more than `max_pairs` did and the last ones were dropped.
  bool update(const ConvexPolyhedron::Box* boxes) noexcept;
  /// (in realtime) From now on `update` looks at these boxes alone, by index; at first it looks at all.
  void select(const std::vector<int>& boxes) noexcept;
  const LoadedVector<Pair>& pairs() const { return pairs_; }  ///< found by the last `update`

 private:
  std::size_t bit(int a, int b) const { return static_cast<std::size_t>(a) * count_ + b; }
  int widestAxis(const ConvexPolyhedron::Box* boxes) const noexcept;
  void sort(const ConvexPolyhedron::Box* boxes, int axis) noexcept;

  struct Interval {
    double lower, upper;          ///< along the sweep
    double lower2[2], upper2[2];  ///< along the other two axes
    int box;
  };
  void orderPairs() noexcept;

  int count_;
  std::vector<std::uint64_t> never_;
  std::vector<Interval> order_;
  LoadedVector<Pair> found_, pairs_;
  std::vector<int> bucket_;
};

}  // namespace haptic
