/// Saved states of a world: one slot in memory, and files.
#pragma once
#include <string>
#include <vector>

#include "haptic_core/world/world.h"

namespace haptic {

/// Writes `state` to `file`: magic, hash, length, doubles of this machine. Throws SetupError naming the file.
void writeState(const std::string& file, const std::vector<double>& state, std::uint64_t hash);

/// Throws SetupError: not found, no state file, truncated.
std::vector<double> readState(const std::string& file);

}  // namespace haptic
