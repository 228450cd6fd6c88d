/// What a link looks like.
#pragma once
#include <string>
#include <vector>

#include "scene/robot_file.h"
#include "scene/scene_file.h"

namespace urdf {
class Link;
}

namespace haptic {

/// The visuals of one URDF link, X_LV in that link's frame. A mesh that is not found is left out, and its name added to `missing`
/// once: it changes the picture, not the physics.
std::vector<VisualDef> readVisuals(const urdf::Link& link, const RobotFile& robot, std::vector<std::string>& missing);

}  // namespace haptic
