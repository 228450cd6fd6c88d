/// <haptic:force>: springs between links and viscous fields of a model.
#pragma once
#include "scene/robot_tree.h"

namespace haptic {

/// Reads one tag; the links of the model are in `context`. Throws SetupError naming file, line and attribute.
void readForce(const RobotFile& robot, const XmlElement& tag, const ModelSettings& settings, LoadContext& context);

}  // namespace haptic
