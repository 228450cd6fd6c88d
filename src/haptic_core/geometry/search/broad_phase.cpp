#include "haptic_core/geometry/search/broad_phase.h"

#include <algorithm>
#include <string>

#include "haptic_core/base/error.h"

namespace haptic {

BroadPhase::BroadPhase(int box_count, const std::vector<std::pair<int, int>>& never, int max_pairs)
    : count_(box_count), never_((static_cast<std::size_t>(box_count) * box_count + 63) / 64, 0) {
  const auto forbid = [this](int a, int b) {
    never_[bit(a, b) >> 6] |= std::uint64_t{1} << (bit(a, b) & 63);
  };
  for (const auto& [a, b] : never) {
    if (a < 0 || b < 0 || a >= count_ || b >= count_)
      throw SetupError("broad phase",
                       "pair " + std::to_string(a) + ", " + std::to_string(b) + " names no box",
                       "use 0 to " + std::to_string(count_ - 1));
    forbid(a, b);
    forbid(b, a);
  }
  order_.reserve(static_cast<std::size_t>(count_));
  for (int i = 0; i < count_; ++i) order_.push_back({0, 0, {0, 0}, {0, 0}, i});
  if (max_pairs <= 0) {
    long long possible = 0;
    for (int a = 0; a < count_; ++a)
      for (int b = a + 1; b < count_; ++b) possible += allowed(a, b);
    // 64 neighbours per box is five layers of cubes around one; more is a scene of one heap in one place.
    max_pairs = static_cast<int>(std::min(possible, 64LL * count_));
  }
  pairs_.reserve(std::max(1, max_pairs));
  found_.reserve(std::max(1, max_pairs));
  bucket_.resize(count_ + 1);
}

int BroadPhase::widestAxis(const ConvexPolyhedron::Box* boxes) const noexcept {
  Vector3 sum = Vector3::Zero(), squares = Vector3::Zero();
  int bounded = 0;
  for (const Interval& interval : order_) {
    const Vector3 middle = boxes[interval.box].lower + boxes[interval.box].upper;
    if (!middle.allFinite()) continue;  // a half-space's
    ++bounded;
    sum += middle;
    squares += middle.cwiseAbs2();
  }
  int axis = 0;
  (squares - sum.cwiseAbs2() / std::max(1, bounded)).maxCoeff(&axis);
  return axis;
}

void BroadPhase::select(const std::vector<int>& boxes) noexcept {
  order_.clear();  // it has room for all
  for (const int i : boxes) order_.push_back({0, 0, {0, 0}, {0, 0}, i});
}

void BroadPhase::sort(const ConvexPolyhedron::Box* boxes, int axis) noexcept {
  const int count = static_cast<int>(order_.size());
  int moves = 0;
  for (Interval& interval : order_) {
    const ConvexPolyhedron::Box& box = boxes[interval.box];
    interval.lower = box.lower[axis];
    interval.upper = box.upper[axis];
    for (int k = 0; k < 2; ++k) {
      interval.lower2[k] = box.lower[(axis + 1 + k) % 3];
      interval.upper2[k] = box.upper[(axis + 1 + k) % 3];
    }
  }
  for (int i = 1; i < count; ++i) {
    const Interval moving = order_[i];
    int j = i;
    for (; j > 0 && order_[j - 1].lower > moving.lower; --j) order_[j] = order_[j - 1];
    order_[j] = moving;
    moves += i - j;
    // Far from sorted (another axis, a jump): insertion would cost N². 16 moves per box are cheaper than a
    // sort.
    if (moves > 16 * count) {
      std::sort(order_.begin(), order_.end(),
                [](const Interval& x, const Interval& y) { return x.lower < y.lower; });
      return;
    }
  }
}

/// Ascending (a, b): into buckets by a, then each bucket by b; few by comparing. The boxes' order in the sweep leaves no trace.
void BroadPhase::orderPairs() noexcept {
  constexpr int kBucketsPerPair = 16;  // to clear and sum up so many buckets costs as much as to sort a pair in among thousands
  if (found_.size() < count_ / kBucketsPerPair) {
    pairs_.resize(found_.size());
    std::copy(found_.begin(), found_.end(), pairs_.begin());
    std::sort(pairs_.begin(), pairs_.end(), [](const Pair& x, const Pair& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
    return;
  }
  std::fill(bucket_.begin(), bucket_.end(), 0);
  for (const Pair& p : found_) ++bucket_[p.a + 1];
  for (int a = 0; a < count_; ++a) bucket_[a + 1] += bucket_[a];
  pairs_.resize(found_.size());
  for (const Pair& p : found_) pairs_[bucket_[p.a]++] = p;
  for (int a = 0, begin = 0; a < count_; begin = bucket_[a++])
    std::sort(pairs_.begin() + begin, pairs_.begin() + bucket_[a],
              [](const Pair& x, const Pair& y) { return x.b < y.b; });
}

bool BroadPhase::update(const ConvexPolyhedron::Box* boxes) noexcept {
  pairs_.clear();
  found_.clear();
  const int count = static_cast<int>(order_.size());
  if (count < 2) return true;
  sort(boxes, widestAxis(boxes));
  bool complete = true;
  for (int i = 0; i < count; ++i) {
    const Interval first = order_[i];
    for (int j = i + 1; j < count && order_[j].lower <= first.upper; ++j) {
      const Interval& other = order_[j];
      // One branch for both axes: it is nearly always taken the same way.
      const bool apart = static_cast<int>(first.lower2[0] > other.upper2[0]) |
                         (other.lower2[0] > first.upper2[0]) | (first.lower2[1] > other.upper2[1]) |
                         (other.lower2[1] > first.upper2[1]);
      if (apart || !allowed(first.box, other.box)) continue;
      complete =
          found_.push_back({std::min(first.box, other.box), std::max(first.box, other.box)}) && complete;
    }
  }
  orderPairs();
  return complete;
}

}  // namespace haptic
