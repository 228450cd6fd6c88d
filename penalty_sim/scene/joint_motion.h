/// Positions of joints over time, from a CSV file.
#pragma once
#include <string>

#include "haptic_core/world/definition.h"

namespace haptic {

/// First line: `time` and the joints' names (without the model's prefix); then a row per time, in seconds and
/// in rad or m, separated by commas; lines that begin with # are left out. `first`: the articulations from
/// there on are the model's. Throws SetupError that names file, line and column: a joint that does not exist,
/// numbers missing or not finite, times that do not rise.
JointPathDef readJointMotion(const std::string& path, const std::string& prefix, const WorldDef& world,
                             std::size_t first);

}  // namespace haptic
