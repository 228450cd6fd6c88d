/// How deep bodies rest in one another, from the scene's own statics.
///
/// A copy of the world settles by implicit steps that are long beside every mode of it, and ends in equilibrium: each body carries its
/// share of the bodies on it, off centre or on one edge, and with the efforts of drives. Hands are at rest.
#pragma once
#include <functional>
#include <vector>

#include "haptic_core/world/definition.h"

namespace haptic {

/// One pair of collisions in touch.
struct RestingContact {
  int shape_a = -1, shape_b = -1;  ///< index among all collisions of the definition, in its order
  double depth = 0;                ///< [m]
  double force = 0;                ///< along the normal [N]
};

/// A settled scene.
struct RestingDepths {
  bool settled = false;  ///< nothing moves any more, and the last step converged
  std::vector<RestingContact> contacts;  ///< of the last step, between bodies slower than 20 times the speed of rest
};

inline constexpr double kSettleStep = 1e-2;  ///< [s]: a mode of 30 Hz and more is damped within one or two
/// [m/s] or [rad/s]: in a step of 10 ms 10 µm, below 1 % of a body of 1 mm. Shallower depths ask for less.
inline constexpr double kAtRest = 1e-3;

/// What settling may cost, counted (world/counted_work.h), so that the same scene settles alike everywhere; several calls share it.
struct SettleBudget {
  double left = 0;                             ///< [units], about a nanosecond each
  std::function<void(double left)> progress;   ///< after each step; empty: nobody is told
  bool spent() const { return left <= 0; }     ///< settling ended before its time
};

/// Lets a copy of `def` settle for at most `steps` steps of kSettleStep; it ends when nothing moves faster than `at_rest`, or when
/// the budget is spent. Throws SetupError where World does. Cost: that of the steps.
RestingDepths restingDepths(const WorldDef& def, int steps, double at_rest = kAtRest, SettleBudget* budget = nullptr);

/// The same by the scene's own steps, for `seconds` at most: where a body falls over, these tell on which side it will lie.
RestingDepths restingDepthsAsRun(const WorldDef& def, double seconds, double at_rest = kAtRest, SettleBudget* budget = nullptr);

}  // namespace haptic
