/// Where a camera looks at first: at the pointers and at what they may touch.
#pragma once
#include <vector>

#include "scene/scene_file.h"

namespace haptic {

/// At the start of a scene, in W.
struct SceneView {
  std::vector<Vector3> hand;     ///< corners of boxes around the pointers and the bodies in their reach [m]
  std::vector<Vector3> scene;    ///< corners of boxes around all pointers and moving bodies [m]
  std::vector<Vector3> largest;  ///< corners of the box around the largest body that `hand` holds beside the pointers [m]
  double yaw = 0;                ///< of a camera about z, from which the fewest shapes hide the pointers [rad]
  double ground = 0;             ///< height of a grid under the bodies [m]
};

inline constexpr double kViewPitch = 0.45;  ///< of the camera that `yaw` is chosen for [rad]

/// Without a hand `hand` is empty; without anything that moves, so is `scene`.
SceneView viewOf(const SceneDef& scene);

}  // namespace haptic
