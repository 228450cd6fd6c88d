/// Links by the names that the scene's files give them, merged ones too.
#pragma once
#include <string>

#include "haptic_core/base/spatial.h"

namespace haptic {

struct SceneDef;
class World;

/// A link as a file names it: a link of the world, or one that was merged into it.
struct NamedLink {
  int link = -1;  ///< world link index
  Pose X_LM;      ///< the named link's frame in it
};

/// Throws SetupError that lists the links there are.
NamedLink namedLink(const SceneDef& scene, const World& world, const std::string& name);

}  // namespace haptic
