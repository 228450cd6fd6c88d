/// What a user may set of the motor boards' line.
#pragma once

namespace haptic {

struct UartSettings {
  double rate_hz = 1000;         ///< at which exchange will be called; more than the wire carries is refused
  int baud = 2000000;            ///< of the port; sets the wire time
  double reply_wait_s = 0;       ///< longest wait for answers [s]; 0: 80 % of the period, at least the cycle
  double max_string_speed = 20;  ///< a count that needs more is refused [m/s]; a hand reaches 5
  double max_string_acceleration =
      1000;  ///< likewise [m/s²]: 20 N on a rotor of 1e-6 kg·m² at 8 mm do 1250, a hand 100
  double silent_after_s =
      0.02;  ///< counts of any board older than this: zero currents, and the boards are taught anew
  /// The same while a string may pull more than its least: the limit, less 8 ms that it takes to reach a
  /// board whose length table is spoilt (zeroForAnyTable), less a tick.
  double zero_after_s = 0.011;
  double reopen_s = 0.25;  ///< pause between attempts to open a lost port [s]
  bool guard = true;       ///< zero currents by a second process when this one dies or stalls
};

}  // namespace haptic
