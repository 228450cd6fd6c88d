/// The last steps of a world, to look back on when it has stopped.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// The last steps of a world, to look back on.
/// A ring of fixed capacity: what moved, after each step, without contact memory, and the last state in full. Not part of
/// the state. It looks at `state` as long as it lives.
class StepHistory {
 public:
  /// One step: arrays as in State; `wrench` has six numbers per pointer, torque [N·m] first, then force
  /// [N].
  struct Record {
    std::uint64_t step;  ///< index of the step
    double time;  ///< [s]
    const double *q, *v, *wrench;  ///< sizes nq, nv and 6 per pointer; valid until the next `keep`
  };

  /// Room for `capacity` steps. Memory: capacity × (nq + nv + 6 pointers + 2) doubles.
  StepHistory(int capacity, const State& state);  ///< set-up

  /// (in realtime) The state as it is now, of which only `trees` have changed since the last time; drops the oldest when full. `changes`:
  /// another number where they are others than then. Costs as much as they and what changed within the capacity.
  void keep(const Model& model, const std::vector<int>& trees, unsigned changes) noexcept;
  void clear() noexcept;  ///< as if nothing had been kept
  /// Records kept, up to the capacity.
  int size() const { return static_cast<int>(std::min<std::uint64_t>(count_, capacity_)); }
  Record record(int i) const;  ///< 0: the oldest kept, size() - 1: the last step
  const State& latest() const { return state_; }  ///< between two steps: complete, contact memory included

 private:
  double* begin() noexcept;
  void keepTree(const ModelTree& tree, double* row) const noexcept;
  void keepHands(double* row) const noexcept;
  const State& state_;
  std::uint64_t capacity_, count_ = 0, next_ = 0;  ///< next_: count_ modulo the capacity
  std::size_t nq_, nv_, pointers_, stride_;
  std::vector<double> rows_;
  std::vector<std::uint64_t> kept_;  ///< by tree: `count_` at which it was in the list last
  std::vector<int> late_;            ///< trees that are not, but have rows that are older
  unsigned changes_ = ~0u;
};

}  // namespace haptic
