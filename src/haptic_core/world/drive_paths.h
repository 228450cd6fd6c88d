/// Positions that drives are asked for over time.
#pragma once
#include <vector>

#include "haptic_core/world/definition.h"

namespace haptic {

class Model;
struct State;

/// A JointPathDef compiled for a world: indices of the state in place of links.
struct DrivePath {
  std::vector<int> commands;  ///< by column: index in the state's commands
  std::vector<double> time;   ///< of the rows [s], rising
  std::vector<double> position;  ///< rows × columns [rad] or [m]
};

/// Compiled from the definition; the model's trees and joints are there already. Throws SetupError where a joint has no
/// drive or the rows do not fit.
std::vector<DrivePath> drivePaths(const WorldDef& def, const Model& model);

/// (in realtime) Drives are asked for where the paths are at the end of the step, and for their rates as velocities.
void followDrivePaths(const Model& model, State& state) noexcept;

}  // namespace haptic
