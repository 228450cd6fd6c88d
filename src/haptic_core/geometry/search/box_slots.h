/// Which of many boxes, that come and go in numbered slots, overlap another one.
#pragma once
#include <vector>

#include "haptic_core/geometry/search/box_tree.h"

namespace haptic {

/// A binary tree whose shape is made once, from where the boxes are then; its nodes bound the boxes below them. To put or take a box
/// costs log₂ N, a query as much for each that it finds, while boxes stay near where they were: what went far widens the nodes
/// above its slot, which costs time and changes no result. In real time nothing is allocated.
class BoxSlots {
 public:
  using Box = ConvexShape::Box;  ///< along the axes of one frame for all

  explicit BoxSlots(const std::vector<Vector3>& places = {});  ///< set-up: a slot for each place, empty

  /// (in realtime) Replaces the slot's box.
  void put(int slot, const Box& box) noexcept { set(leaf_[static_cast<std::size_t>(slot)], box); }
  /// (in realtime) The slot is empty.
  void clear(int slot) noexcept { set(leaf_[static_cast<std::size_t>(slot)], kEmpty); }

  /// (in realtime) visit(slot) for each of the boxes that touches or overlaps `box`, each once, in an order of the tree's own.
  template <class Visit>
  void eachOverlap(const Box& box, Visit&& visit) const noexcept {
    std::size_t open[2 * kDeepest], count = 0;
    open[count++] = 1;
    while (count > 0) {
      const std::size_t n = open[--count];
      if (!BoxTree::overlap(node_[n], box)) continue;
      if (n >= leaves_) {
        if (node_[n].lower.x() <= node_[n].upper.x()) visit(slot_[n - leaves_]);  // a box without end overlaps empty slots, too
        continue;
      }
      open[count++] = 2 * n + 1;
      open[count++] = 2 * n;
    }
  }

 private:
  static constexpr int kDeepest = 32;  ///< levels: 2³¹ slots
  static const Box kEmpty;             ///< overlaps nothing
  void set(std::size_t node, const Box& box) noexcept;
  void share(const std::vector<Vector3>& places, std::vector<int>& slots, int first, int count, std::size_t leaf, std::size_t leaves);

  std::size_t leaves_ = 1;
  std::vector<Box> node_;          ///< 1 is the root; the children of n are 2 n and 2 n + 1
  std::vector<int> slot_;          ///< by leaf
  std::vector<std::size_t> leaf_;  ///< node by slot
};

}  // namespace haptic
