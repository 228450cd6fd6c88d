/// What acts on bodies from outside: wrenches, motions, belts, and their replay.
#pragma once

namespace haptic::bench {

/// Prints wrench.response_err_rel, kinematic.carry_um, kinematic.conveyor_err_rel, spawn.tick_us_added_max and replay.mismatches. The
/// first three are the largest over the sets of attempts that the core has.
void measureActors();

/// Prints wrench.world_stopped: of 10 000 calls of services with numbers of any size, those after which the world stands still; and
/// wrench.refused.
void measureServices();

}  // namespace haptic::bench
