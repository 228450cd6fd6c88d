/// Inertia of links: reading, merging across fixed joints, checking, and what stands in where a file gives
/// none.
#pragma once
#include <string>
#include <vector>

#include "haptic_core/world/definition.h"
#include "scene/load_report.h"
#include "scene/robot_file.h"

namespace haptic {

/// Of solid plastic or of a machine with its hollows [kg/m³]: where neither a file nor the user gives one.
inline constexpr double kEstimateDensity = 1000;

/// From <inertial>, whose numbers are sound, in the link's frame; mass 0 when there is none.
LinkInertia readInertia(const RobotFile& robot, const LinkXml& link);

/// Adds `added`, given in frame M of a link fixed at X_LM, to `inertia` in L (parallel axes).
void merge(const LinkInertia& added, const Pose& X_LM, LinkInertia& inertia);

/// Of the collision shapes at a uniform density [kg/m³]; overlapping shapes count twice. Mass 0 without
/// shapes.
LinkInertia inertiaOfShapes(const std::vector<CollisionDef>& collisions, double density);

/// Moments of `mass` spread over the shapes, about their centre; without shapes those of a ball of 20 mm.
Matrix3 momentsOfShapes(const std::vector<CollisionDef>& collisions, double mass);

/// Makes the inertias of a tree such that every motion of its joints meets some, and nothing else: a link that has none, or one that is
/// singular, stays as it is where the joints cannot tell (excited_inertia.h). Where they can, its mass is spread over its shapes; without
/// shapes it is a ball of 20 mm. A link without <inertial> has the mass of its shapes at `density` (1000 kg/m³ for 0), without shapes
/// none. Negative moments are always replaced. Each replacement is said. A moment larger than the sum of the others (no mass distribution
/// has it, but published robots do, and it can be computed with) is a warning. `places` holds "file:line: link" per link, `given` whether
/// the file has an <inertial> there. Throws SetupError: no moving link of the tree has an inertia, and `density` is 0; or one is so large
/// that the others are lost in rounding.
void completeInertias(ArticulationDef& tree, const std::vector<std::string>& places, const std::vector<bool>& given, double density,
                      const OptionWords& words, LoadReport& said);

}  // namespace haptic
