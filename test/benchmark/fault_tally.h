/// What became of injected faults: the sums behind the figures `faults.*`.
#pragma once
#include <algorithm>
#include <string>
#include <vector>

namespace haptic::bench {

struct FaultTally {
  int injected = 0, detected = 0, recovered = 0;
  int harmless = 0;  ///< moved the pose by less than 1 mm and the force by less than 0.2 N, and nobody said anything
  int missed = 0;    ///< moved one of them by more, and nobody said anything
  int idle = 0;      ///< trials in which the device was not enabled: nothing was injected
  std::vector<double> detect_ms;  ///< from the injection, or from when it began to matter, to the notice [ms]
  double stale_force = 0, energy = 0, pose_error = 0;  ///< greatest [s], [J], [m]
  double cut_force = 0;           ///< as stale_force, while the wire itself was cut or a board could not be turned off [s]
  int power_cycles = 0;
  long out_of_bounds = 0;         ///< tensions outside the device's bounds
  long alarms = 0;                ///< of the undisturbed run
  double quiet_hours = 0;         ///< its length [h]

  void add(const FaultTally& o) {
    injected += o.injected, detected += o.detected, recovered += o.recovered;
    harmless += o.harmless, missed += o.missed, idle += o.idle;
    detect_ms.insert(detect_ms.end(), o.detect_ms.begin(), o.detect_ms.end());
    stale_force = std::max(stale_force, o.stale_force), energy = std::max(energy, o.energy);
    pose_error = std::max(pose_error, o.pose_error), cut_force = std::max(cut_force, o.cut_force);
    power_cycles += o.power_cycles;
    out_of_bounds += o.out_of_bounds, alarms += o.alarms, quiet_hours += o.quiet_hours;
  }
};

/// Faults of strings and encoders in the twin alone, an undisturbed run and abusive commands.
FaultTally twinFaults();

}  // namespace haptic::bench
