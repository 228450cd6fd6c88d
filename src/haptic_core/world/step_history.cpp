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
      rows_(capacity_ * stride_) {}

/// A new row, with the step and the time.
double* StepHistory::begin() noexcept {
  double* row = rows_.data() + next_ * stride_;
  ++count_;
  if (++next_ == capacity_) next_ = 0;
  std::memcpy(row, &state_.step, sizeof(double));  // the integer's bits
  row[1] = state_.time;
  return row;
}

void StepHistory::repeat() noexcept {
  if (capacity_ == 0) return;
  if (count_ == 0) return keep();
  const double* last = rows_.data() + (next_ == 0 ? capacity_ - 1 : next_ - 1) * stride_;
  double* row = begin();
  if (row != last) std::memcpy(row + 2, last + 2, (stride_ - 2) * sizeof(double));
}

void StepHistory::keep() noexcept {
  if (capacity_ == 0) return;
  double* row = begin();
  row = std::copy(state_.q.begin(), state_.q.end(), row + 2);
  row = std::copy(state_.v.begin(), state_.v.end(), row);
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
