#include "haptic_core/geometry/search/box_slots.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace haptic {

const BoxSlots::Box BoxSlots::kEmpty = {Vector3::Constant(std::numeric_limits<double>::infinity()),
                                        Vector3::Constant(-std::numeric_limits<double>::infinity())};

BoxSlots::BoxSlots(const std::vector<Vector3>& places) : leaf_(places.size()) {
  while (leaves_ < places.size()) leaves_ *= 2;
  node_.assign(2 * leaves_, kEmpty);
  slot_.assign(leaves_, -1);
  std::vector<int> slots(places.size());
  std::iota(slots.begin(), slots.end(), 0);
  share(places, slots, 0, static_cast<int>(slots.size()), 0, leaves_);
}

/// Slots of a part of space to a part of the leaves: halved along the axis of their widest spread.
void BoxSlots::share(const std::vector<Vector3>& places, std::vector<int>& slots, int first, int count, std::size_t leaf,
                     std::size_t leaves) {
  if (count == 0) return;
  if (leaves == 1) {
    slot_[leaf] = slots[static_cast<std::size_t>(first)];
    leaf_[static_cast<std::size_t>(slot_[leaf])] = leaves_ + leaf;
    return;
  }
  Vector3 lowest = Vector3::Constant(std::numeric_limits<double>::infinity()), highest = -lowest;
  for (int i = first; i < first + count; ++i) {
    const Vector3& p = places[static_cast<std::size_t>(slots[static_cast<std::size_t>(i)])];
    lowest = lowest.cwiseMin(p);
    highest = highest.cwiseMax(p);
  }
  int axis = 0;
  (highest - lowest).maxCoeff(&axis);
  const auto begin = slots.begin() + first;
  std::nth_element(begin, begin + count / 2, begin + count, [&](int i, int j) {
    const double a = places[static_cast<std::size_t>(i)][axis], b = places[static_cast<std::size_t>(j)][axis];
    return a != b ? a < b : i < j;
  });
  share(places, slots, first, count / 2, leaf, leaves / 2);
  share(places, slots, first + count / 2, count - count / 2, leaf + leaves / 2, leaves / 2);
}

void BoxSlots::set(std::size_t n, const Box& box) noexcept {
  node_[n] = box;
  while ((n /= 2) > 0) {
    node_[n] = {node_[2 * n].lower.cwiseMin(node_[2 * n + 1].lower), node_[2 * n].upper.cwiseMax(node_[2 * n + 1].upper)};
  }
}

}  // namespace haptic
