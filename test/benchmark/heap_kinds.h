/// Heaps of one kind of body at several stiffnesses by the default method, interleaved with Bullet and ODE.
#pragma once
#include <map>
#include <string>

#include "../scenes/heap.h"

namespace haptic::bench {

/// The largest over the stiffnesses of a heap, or over heaps.
struct KindFigures {
  double mean = 0, worst = 0;       ///< mean step, and the median over five runs of the largest, over those of Bullet with 50 iterations
  double unconverged_share = 0;     ///< of the steps in which anything touches
  double wrench_share = 0;          ///< wrench out of balance in such a step, over the weight of the heap
  double budget_used = 0;           ///< evaluations over the island's budget
  std::map<std::string, double> mean_us;  ///< by stiffness; of one heap
  void add(const KindFigures& other);
};

/// Two seconds at 1 ms; prints the figures `heapN.KIND.*`.
KindFigures measureHeapOf(scenes::HeapKind kind, int count);

}  // namespace haptic::bench
