/// A hand on its scripted path, without device: the pointer is where the grip should be.
#pragma once
#include <cmath>

#include "haptic_core/loop/workspace_map.h"
#include "haptic_core/world/world.h"
#include "scene/scene_file.h"

namespace haptic {

/// Where a pointer is whose hand follows its scripted path, over and over, at time `t` [s].
inline WorkspaceMap mapOnPath(const HandDef& hand, double t) {
  const double period = hand.path.duration();
  const double time = period > 0 ? std::fmod(t, period) : 0;
  const double dt = 1e-5;  // [s]: the path is a quintic; the error of the quotient is 1e-9 of its speed
  const GripPose grip = hand.path.at(time), later = hand.path.at(time + dt);
  const Twist V_BG{vectorFromRotation(Quaternion(later.X_BG.R) * Quaternion(grip.X_BG.R).conjugate()) / dt,
                   (later.X_BG.p - grip.X_BG.p) / dt};
  WorkspaceMap map(hand.workspace);
  map.update(grip.X_BG, V_BG, false);
  return map;
}

/// Moves all pointers to where their hands' paths are at the end of the next step.
inline void followPaths(const SceneDef& scene, World& world) {
  for (const HandDef& hand : scene.hands) {
    const WorkspaceMap map = mapOnPath(hand, world.time() + world.settings().step);
    world.setPointerTarget(hand.pointer, map.X_WP(), map.V_WP());
  }
}

}  // namespace haptic
