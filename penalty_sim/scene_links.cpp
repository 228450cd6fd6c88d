#include "penalty_sim/scene_links.h"

#include "haptic_core/base/error.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/world.h"
#include "scene/scene_file.h"

namespace haptic {

NamedLink namedLink(const SceneDef& scene, const World& world, const std::string& name) {
  const int link = world.linkIndex(name);
  if (link >= 0) return {link, Pose()};
  for (std::size_t a = 0; a < scene.world.articulations.size(); ++a) {
    const std::vector<LinkDef>& links = scene.world.articulations[a].links;
    for (std::size_t l = 0; l < links.size(); ++l) {
      for (const MergedLink& merged : links[l].merged) {
        if (merged.name == name) return {world.model().link(static_cast<int>(a), static_cast<int>(l)), merged.X_LM};
      }
    }
  }
  std::string known;
  for (int i = 0; i < world.linkCount(); ++i) known += (i > 0 ? ", " : "") + world.linkName(i);
  throw SetupError("link '" + name + "'", "is not in this scene", "there are: " + known);
}

}  // namespace haptic
