#include "haptic_core/geometry/search/box_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace haptic {
namespace {

/// Of a box without end the side that it has, or 0.
double middleOf(const ConvexShape::Box& box, int axis) {
  const double sum = box.lower[axis] + box.upper[axis];
  return std::isfinite(sum) ? 0.5 * sum : 0.0;
}

}  // namespace

BoxTree::BoxTree(const std::vector<Box>& boxes) : item_(boxes.size()) {
  if (boxes.empty()) return;
  std::iota(item_.begin(), item_.end(), 0);
  split(boxes, 0, static_cast<int>(boxes.size()));
  item_box_.reserve(boxes.size());
  for (const int i : item_) item_box_.push_back(boxes[i]);
}

void BoxTree::split(const std::vector<Box>& boxes, int first, int count) {
  const std::size_t at = nodes_.size();
  nodes_.push_back({boxes[item_[first]], first, count});
  Vector3 lowest = Vector3::Constant(INFINITY), highest = -lowest;
  for (int i = first; i < first + count; ++i) {
    const Box& box = boxes[item_[i]];
    nodes_[at].box.lower = nodes_[at].box.lower.cwiseMin(box.lower);
    nodes_[at].box.upper = nodes_[at].box.upper.cwiseMax(box.upper);
    for (int axis = 0; axis < 3; ++axis) {
      lowest[axis] = std::min(lowest[axis], middleOf(box, axis));
      highest[axis] = std::max(highest[axis], middleOf(box, axis));
    }
  }
  if (count <= kLeaf) return;
  int axis = 0;
  (highest - lowest).maxCoeff(&axis);
  const auto begin = item_.begin() + first;
  std::nth_element(begin, begin + count / 2, begin + count, [&](int i, int j) {
    const double a = middleOf(boxes[i], axis), b = middleOf(boxes[j], axis);
    return a != b ? a < b : i < j;
  });
  split(boxes, first, count / 2);
  nodes_[at].first = static_cast<int>(nodes_.size());
  nodes_[at].count = 0;
  split(boxes, first + count / 2, count - count / 2);
}

}  // namespace haptic
