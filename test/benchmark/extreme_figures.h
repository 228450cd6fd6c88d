/// The parts of `./run bench extreme` beyond the cases themselves; each prints its figures.
#pragma once
#include "haptic_core/world/world.h"

namespace haptic::bench {

/// Over all implicit runs of the program.
struct ImplicitTotals {
  long steps = 0, iterations = 0, unconverged = 0;
  int most_iterations = 0;
};
inline ImplicitTotals totals;

inline WorldSettings implicitSettings(double h, Attempts attempts = Attempts::kImplicitEuler) {
  WorldSettings s;
  s.step = h;
  s.attempts = attempts;
  return s;
}

/// One step, counted in `totals`.
void stepOnce(World& world);

void rigidLimits();        ///< tilt.residual_10ms_nms, rigid.*
void certificateLimits();  ///< certificate.*
void allocations();        ///< allocations.extreme
void softOverhead();       ///< soft.*
/// What `softOverhead` counts, in a process of its own: steps of a soft scene, `automatic` or plain explicit.
void countSoft(const char* attempts);

}  // namespace haptic::bench
