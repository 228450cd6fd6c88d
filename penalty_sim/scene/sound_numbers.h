/// Numbers of a URDF that cannot be right, made sound before anything reads them.
#pragma once
#include "scene/robot_file.h"

namespace haptic {

/// Judges every number of links, joints and their shapes by number_bounds.h, and mends the XML: an impossible number becomes the nearest
/// sound one, or its element is left out, with a line in `replaced` that names link or joint, tag and number; an improbable one is a
/// warning. Text that is no number stays, for its reader to refuse. Afterwards all sizes are > 0, all masses ≥ 0, all drives' limits ≥ 0,
/// no axis is zero, no lower limit is above its upper one.
void makeNumbersSound(RobotFile& robot);

}  // namespace haptic
