/// CENIC's scenes: judged by the distance from the same simulator at a tiny step, or by what is conserved.
#pragma once
#include <vector>

#include "report_scene.h"

namespace haptic::report {

struct CenicScene {
  Scene scene;      ///< without an exact motion; `chaotic`: without a reference of its own either
  Vector3 mark;     ///< the point of each body that is compared, in its frame [m]
};

/// clutter_soft, clutter_stiff, top, gripper, rods. Their measures are not among the report's metrics: units are in the figures' table.
std::vector<CenicScene> cenicScenes();

}  // namespace haptic::report
