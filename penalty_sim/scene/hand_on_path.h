/// The hands of a scene on their scripted paths, without device.
#pragma once
#include "haptic_core/loop/pointer_on_path.h"
#include "haptic_core/world/world.h"
#include "scene/scene_file.h"

namespace haptic {

/// Where a pointer is whose hand follows its scripted path, over and over, at time `t` [s].
inline WorkspaceMap mapOnPath(const HandDef& hand, double t) { return pointerOnPath(hand.workspace, hand.path, t); }

/// Moves all pointers to where their hands' paths are at the end of the next step.
inline void followPaths(const SceneDef& scene, World& world) {
  for (const HandDef& hand : scene.hands) {
    const WorkspaceMap map = mapOnPath(hand, world.time() + world.settings().step);
    world.setPointerTarget(hand.pointer, map.X_WP(), map.V_WP());
  }
}

}  // namespace haptic
