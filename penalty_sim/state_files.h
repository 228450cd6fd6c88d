/// Saved states of a world: one slot in memory, and files.
#pragma once
#include <string>
#include <vector>

#include "haptic_core/world/world.h"

namespace haptic {

/// Writes `state` to `file`, with a sum over all of it (packed_file.h). Throws SetupError naming the file.
void writeState(const std::string& file, const std::vector<double>& state);

/// Throws SetupError: not found, no saved state of this version, cut, or altered by as little as one bit.
std::vector<double> readState(const std::string& file);

}  // namespace haptic
