/// Rigid ellipsoids that roll: written by rolling_reference.py.
#pragma once

namespace haptic::bench {

constexpr double kRattlebackReversal = 0.5726192;  ///< first reversal of its yaw [s]
constexpr double kEggAmplitude = 0.9999993;  ///< of its fifteenth swing over the first's [1]
constexpr double kEggPeriod = 0.2854784;  ///< [s]

}  // namespace haptic::bench
