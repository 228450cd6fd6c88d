/// Which of many boxes that never move overlap one that does.
#pragma once
#include <vector>

#include "haptic_core/geometry/shapes/convex_shape.h"

namespace haptic {

/// Boxes halved again and again along the axis on which their middles spread most, until few are left. Made once, at set-up; all
/// queries are const and safe from any number of threads. A query costs about 10 ns a level (log₂ of the number of boxes) and a
/// few ns for each box that it looks at, however many there are elsewhere.
class BoxTree {
 public:
  using Box = ConvexShape::Box;  ///< along the axes of one frame for all

  BoxTree() = default;  ///< of no box
  explicit BoxTree(const std::vector<Box>& boxes);  ///< boxes may be without end

  /// (in realtime) visit(i) for each of the boxes that touches or overlaps `box`, each once, in an order of the tree's own. No box
  /// overlaps one with NaN.
  template <class Visit>
  void eachOverlap(const Box& box, Visit&& visit) const noexcept;

  static bool overlap(const Box& a, const Box& b) noexcept {
    return a.lower.x() <= b.upper.x() && b.lower.x() <= a.upper.x() && a.lower.y() <= b.upper.y() && b.lower.y() <= a.upper.y() &&
           a.lower.z() <= b.upper.z() && b.lower.z() <= a.upper.z();
  }  ///< they touch or overlap

 private:
  static constexpr int kLeaf = 4;    ///< boxes of a leaf at most
  static constexpr int kDeepest = 32;  ///< levels: halves of 2³¹ boxes
  /// An inner node's first child follows it.
  struct Node {
    Box box;            ///< around all below
    int first, count;   ///< a leaf's items; count 0: `first` is the second child
  };
  void split(const std::vector<Box>& boxes, int first, int count);

  std::vector<Node> nodes_;
  std::vector<Box> item_box_;
  std::vector<int> item_;  ///< indices of the boxes
};

template <class Visit>
void BoxTree::eachOverlap(const Box& box, Visit&& visit) const noexcept {
  int open[kDeepest + 1], count = 0;
  if (!nodes_.empty()) open[count++] = 0;
  while (count > 0) {
    const int n = open[--count];
    const Node& node = nodes_[n];
    if (!overlap(node.box, box)) continue;
    if (node.count == 0) {
      open[count++] = node.first;
      open[count++] = n + 1;
      continue;
    }
    for (int i = node.first; i < node.first + node.count; ++i) {
      if (overlap(item_box_[i], box)) visit(item_[i]);
    }
  }
}

}  // namespace haptic
