/// The scenes of urdf/scenes, whose hands follow their scripted paths (scene/hand_on_path.h): what programs compare builds with.
#pragma once
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "haptic_core/base/error.h"
#include "haptic_core/world/world.h"
#include "scene/hand_on_path.h"
#include "scene/scene_file.h"

namespace haptic::scenes {

struct ShippedScene {
  std::string name;  ///< of the file
  SceneDef def;
};

/// All files of `folder` that load on this system, by name; the others are named on stderr with the reason.
inline std::vector<ShippedScene> shippedScenes(const std::string& folder, const SceneOptions& options = {}) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::filesystem::path& file = entry.path();
    if (file.extension() == ".urdf" || file.extension() == ".yaml") files.push_back(file);
  }
  std::sort(files.begin(), files.end());
  std::vector<ShippedScene> scenes;
  for (const std::filesystem::path& file : files) {
    try {
      ShippedScene scene{file.filename().string(), loadScene(file.string(), options)};
      const World world(scene.def.world);  // a scene whose world is refused runs nowhere
      scenes.push_back(std::move(scene));
    } catch (const SetupError& error) {
      std::fprintf(stderr, "skipped %s: %s\n", file.filename().c_str(), error.what());
    }
  }
  return scenes;
}

}  // namespace haptic::scenes
