/// Scenes whose bodies become more or fewer while they run: definitions with indices that fit again, for World::exchange.
#pragma once
#include <string>
#include <vector>

#include "scene/scene_file.h"

namespace haptic {

/// A scene with other bodies.
struct ChangedScene {
  SceneDef scene;                   ///< as it is to be
  std::vector<int> kept;            ///< by articulation: that of the scene before; −1: it comes. As NextWorld takes it
  std::vector<std::string> links;   ///< that come or go
};

/// The scene and, behind it, all of `model` (loadModel): bodies, loops, motions, sensors, visuals. Throws SetupError: a name of a link or
/// joint that is taken, a model with hands of its own.
ChangedScene withModel(const SceneDef& scene, const SceneDef& model);

/// The scene without what is called `name`: the bodies and trees that a link of this name, or one called NAME/..., belongs to, and what
/// refers to them. Throws SetupError: there is none.
ChangedScene withoutModel(const SceneDef& scene, const std::string& name);

/// The scene with the bodies of `def`, as a replay knows them: links of the same name are drawn as before, others as what collides.
SceneDef withBodies(const SceneDef& scene, const WorldDef& def);

}  // namespace haptic
