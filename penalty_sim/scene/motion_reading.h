/// <haptic:motion>: bodies whose motion is given; <haptic:belt>: surfaces that move over their shapes.
#pragma once
#include "scene/robot_tree.h"

namespace haptic {

/// Reads <haptic:motion link=...> with one of `file` (CSV: time,x,y,z or time,x,y,z,roll,pitch,yaw, poses of the link in the model's
/// world [s, m, rad]; `repeat`), `topic` and `tf`. The body starts at the first row. Throws SetupError that names file and line: no such
/// link or file, a body on joints or fixed, columns and rows that do not fit, a turn of more than 3 rad from row to row, a path that
/// repeats and does not close.
void readMotion(const RobotFile& robot, const XmlElement& tag, const ModelSettings& settings, LoadContext& context);

/// The <haptic:belt velocity="x y z" spin="x y z"> of a collision, of its link's frame, in a link in which that frame lies at X_LM; still
/// where there is none. Throws SetupError.
SurfaceVelocity readBelt(const XmlFile& file, const XmlElement& collision, const Pose& X_LM);

}  // namespace haptic
