#include "haptic_core/world/step_history.h"

#include <algorithm>
#include <cstring>

namespace haptic {

StepHistory::StepHistory(int capacity, const State& state)
    : state_(state),
      capacity_(capacity),
      nq_(state.q.size()),
      nv_(state.v.size()),
      pointers_(state.pointers.size()),
      stride_(2 + nq_ + nv_ + 6 * pointers_),
      rows_(capacity_ * stride_),
      kept_(state.mode.size()) {
  late_.reserve(kept_.size());
}

/// A new row, with the step and the time.
double* StepHistory::begin() noexcept {
  double* row = rows_.data() + next_ * stride_;
  ++count_;
  if (++next_ == capacity_) next_ = 0;
  std::memcpy(row, &state_.step, sizeof(double));  // the integer's bits
  row[1] = state_.time;
  return row;
}

void StepHistory::keep(const Model& model, const std::vector<int>& trees, unsigned changes) noexcept {
  if (capacity_ == 0) return;
  double* row = begin();  // its old record is `capacity_` steps old
  for (const int t : trees) {
    keepTree(model.trees[t], row);
    kept_[t] = count_;
  }
  if (changes != changes_) {
    changes_ = changes;
    late_.clear();
    for (std::size_t t = 0; t < kept_.size(); ++t) {
      if (kept_[t] != count_ && count_ - kept_[t] < capacity_ + 1) late_.push_back(static_cast<int>(t));
    }
  }
  for (std::size_t i = 0; i < late_.size();) {
    keepTree(model.trees[late_[i]], row);
    if (count_ - kept_[late_[i]] < capacity_) {
      ++i;
      continue;
    }
    late_[i] = late_.back();
    late_.pop_back();
  }
  keepHands(row);
}

void StepHistory::clear() noexcept {
  count_ = next_ = 0;
  std::fill(kept_.begin(), kept_.end(), 0);
  changes_ = ~0u;
}

void StepHistory::keepTree(const ModelTree& tree, double* row) const noexcept {
  std::copy_n(state_.q.begin() + tree.q, tree.model->nq(), row + 2 + tree.q);
  std::copy_n(state_.v.begin() + tree.v, tree.model->nv(), row + 2 + nq_ + tree.v);
}

void StepHistory::keepHands(double* row) const noexcept {
  row += 2 + nq_ + nv_;
  for (const PointerState& pointer : state_.pointers) {
    row = std::copy(pointer.F_W.torque.data(), pointer.F_W.torque.data() + 3, row);
    row = std::copy(pointer.F_W.force.data(), pointer.F_W.force.data() + 3, row);
  }
}

StepHistory::Record StepHistory::record(int i) const {
  const std::uint64_t first = count_ - static_cast<std::uint64_t>(size());
  const double* row = rows_.data() + (first + i) % capacity_ * stride_;
  Record record{0, row[1], row + 2, row + 2 + nq_, row + 2 + nq_ + nv_};
  std::memcpy(&record.step, row, sizeof(double));
  return record;
}

}  // namespace haptic
