/// No heap in steps: implicit, automatic, swept, with friction events, couplings and continuation.
#include <cmath>

#include "../scenes/extremes.h"
#include "../scenes/motions.h"
#include "allocation_count.h"
#include "extreme_figures.h"
#include "figure.h"

namespace haptic::bench {

using namespace scenes;

void allocations() {
  long count = 0;
  for (Attempts attempts : {Attempts::kImplicitEuler, Attempts::kSdirk2, Attempts::kAll}) {
    for (const ExtremeCase& e : extremeCases(implicitSettings(1e-3, attempts))) {
      World world(e.def);
      const long before = allocationCount();
      for (int i = 0; i < 200; ++i) stepOnce(world);
      count += allocationCount() - before;
    }
    CubeParameters c;
    c.mass = StickSlip::kMass;
    c.stiffness = StickSlip::kStiffness;
    World world(StickSlip::scene(implicitSettings(1e-2, attempts)));
    const long before = allocationCount();
    for (int i = 0; i < 200; ++i) StickSlip::step(world, c.size / 2 - c.restDepth());
    count += allocationCount() - before;
  }
  figure("allocations.extreme", count, "1");
}

}  // namespace haptic::bench
