/// What a step of a scene costs on this machine, and which collisions it goes to.
#pragma once
#include <string>
#include <vector>

#include "haptic_core/world/definition.h"

namespace haptic {

/// Processor times, of a scene that has come to rest or run for a while.
struct StepCost {
  /// Of one collision.
  struct Share {
    std::string name;     ///< the collision's, or its link's
    int pairs = 0;        ///< that it is looked at in
    double seconds = 0;   ///< of one look at all of them; each pair counts half for each of its two
  };
  double seconds = 0;     ///< of a step, median
  std::vector<Share> of;  ///< the costliest first
};

/// Runs a copy of the scene for `seconds` of simulated time, then times steps, and looks at each pair alone. Throws SetupError as World
/// does. A pair's time is that of finding its patch once; implicit steps look more than once.
StepCost stepCost(const WorldDef& def, double seconds = 0.5);

/// A line of all, and one for each of the costliest collisions; a scene without pairs has the first alone.
std::vector<std::string> costLines(const StepCost& cost);

}  // namespace haptic
