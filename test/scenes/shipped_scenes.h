/// The scenes of urdf/scenes, and hands that follow their scripted paths: what programs compare builds with.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/workspace_map.h"
#include "haptic_core/world/world.h"
#include "scene/scene_file.h"

namespace haptic::scenes {

struct ShippedScene {
  std::string name;  ///< of the file
  SceneDef def;
};

/// All files of `folder` that load on this system, by name; the others are named on stderr with the reason.
inline std::vector<ShippedScene> shippedScenes(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::filesystem::path& file = entry.path();
    if (file.extension() == ".urdf" || file.extension() == ".yaml") files.push_back(file);
  }
  std::sort(files.begin(), files.end());
  std::vector<ShippedScene> scenes;
  for (const std::filesystem::path& file : files) {
    try {
      ShippedScene scene{file.filename().string(), loadScene(file.string())};
      const World world(scene.def.world);  // a scene whose world is refused runs nowhere
      scenes.push_back(std::move(scene));
    } catch (const SetupError& error) {
      std::fprintf(stderr, "skipped %s: %s\n", file.filename().c_str(), error.what());
    }
  }
  return scenes;
}

/// Where a pointer is whose hand follows its scripted path, over and over.
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

}  // namespace haptic::scenes
