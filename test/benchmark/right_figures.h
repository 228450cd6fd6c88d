/// Parts of `./run bench right`; each prints figures of its own.
#pragma once
#include <string>

#include "../comparators/named_attempts.h"
#include "haptic_core/world/world.h"

namespace haptic::bench {

using comparators::kNamedAttempts;
using comparators::NamedAttempts;

void runBelts();      ///< belt.*
void runCarriers();   ///< carrier.*
void runBalances();   ///< wrench.*, momentum.*
void runDrops();      ///< contact.*
void runEnergy();     ///< energy.*
void runGround();     ///< ground.*
void runImpacts();    ///< impact.*, runaway.*
void runOrder();      ///< order.*
void runPower();      ///< power.*
void runRings();      ///< ring.*
void runRolling();    ///< roll.*

}  // namespace haptic::bench
