/// What became of injected faults: the sums behind the figures `faults.*`.
#pragma once
#include <vector>

namespace haptic::bench {

struct FaultTally {
  int injected = 0, detected = 0, recovered = 0;
  int harmless = 0;               ///< without effect on any pose: not counted as injected
  std::vector<double> detect_ms;  ///< from the effect to the notice [ms]
  long out_of_bounds = 0;         ///< tensions outside the device's bounds
  long alarms = 0;                ///< of the undisturbed run
  double quiet_hours = 0;         ///< its length [h]

  void add(const FaultTally& o) {
    injected += o.injected, detected += o.detected, recovered += o.recovered, harmless += o.harmless;
    detect_ms.insert(detect_ms.end(), o.detect_ms.begin(), o.detect_ms.end());
    out_of_bounds += o.out_of_bounds, alarms += o.alarms, quiet_hours += o.quiet_hours;
  }
};

/// Faults of strings and encoders in the twin alone, an undisturbed run and abusive commands.
FaultTally twinFaults();

}  // namespace haptic::bench
