/// Parts of `./run bench step`; each prints figures of its own.
#pragma once
#include "../comparators/velocity_verlet.h"
#include "haptic_core/world/world.h"

namespace haptic::bench {

/// Settings at 1 kHz.
inline WorldSettings stepSettings(Attempts attempts = Attempts::kAll, double h = 1e-3) {
  WorldSettings settings;
  settings.step = h;
  settings.attempts = attempts;
  return settings;
}

/// Of a fine reference.
inline WorldSettings verletSettings(double h) {
  WorldSettings settings = stepSettings(Attempts::kAll, h);
  settings.comparator = comparators::velocityVerlet;
  return settings;
}

void runMotions(const char* filter);  ///< step.*: time and error beside the dated values; `filter` may be null
void runBits();                       ///< index.bits_differ, scale.bits_differ
void runCases();                      ///< turntable.*, marble.*, rod_impact.*, bounce.*
void runAccuracy();                   ///< accuracy.*, hand.force_error_est.*: errors that steps foresee, beside the true ones
void runShaken();                     ///< shaken.*: force of a block on a platform that is led up and down
void runPloughs(const char* filter);  ///< plough.*: a hand through heaps; `filter` may be null

}  // namespace haptic::bench
