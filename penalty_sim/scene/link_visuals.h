/// What a link looks like.
#pragma once
#include <string>
#include <vector>

#include "scene/material_colours.h"
#include "scene/robot_file.h"
#include "scene/scene_file.h"

namespace haptic {

/// The visuals of one URDF link, X_LV in that link's frame. A mesh that is not found is left out, and its
/// name added to `missing` once: it changes the picture, not the physics. A shape that cannot be drawn is
/// left out with a warning in `said`. Throws SetupError where an origin has no numbers.
std::vector<VisualDef> readVisuals(const RobotFile& robot, const LinkXml& link,
                                   const MaterialColours& colours, std::vector<std::string>& missing,
                                   LoadReport& said);

}  // namespace haptic
