/// Inertia of links: reading, merging across fixed joints, checking, and what stands in where a file gives
/// none.
#pragma once
#include <string>
#include <vector>

#include "haptic_core/world/definition.h"
#include "scene/robot_file.h"

namespace haptic {

/// From urdfdom's <inertial>, in the link's frame; mass 0 when there is none.
LinkInertia readInertia(const urdf::Link& link);

/// Adds `added`, given in frame M of a link fixed at X_LM, to `inertia` in L (parallel axes).
void merge(const LinkInertia& added, const Pose& X_LM, LinkInertia& inertia);

/// Of the collision shapes at a uniform density [kg/m³]; overlapping shapes count twice. Mass 0 without
/// shapes.
LinkInertia inertiaOfShapes(const std::vector<CollisionDef>& collisions, double density);

/// Throws SetupError unless the mass is > 0 and the inertia positive definite; a violated triangle inequality
/// (no mass distribution has it, but published robots do, and it can be computed with) is a warning.
void checkInertia(const LinkInertia& inertia, const std::string& where, std::vector<std::string>& warnings);

/// Gives every moving link of `articulation` that has no inertia one: from its shapes at `density` (> 0), or,
/// where others of the same robot have one (density 0), an estimate that disturbs little. A robot that has
/// none at all is refused without density. `places` holds "file:line: link" per link, `given` whether the
/// file has an <inertial> there.
void fillMissingInertias(ArticulationDef& articulation, const std::vector<std::string>& places,
                         const std::vector<bool>& given, double density, std::vector<std::string>& warnings);

}  // namespace haptic
