// Any scene or robot that the simulator loads. Nothing is asked of its user: the simulated time, the compared bodies and
// the hands' paths come from the file.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "../scenes/shipped_scenes.h"
#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/world/world.h"
#include "report_scene.h"
#include "scene/scene_file.h"

namespace haptic::report {
namespace {

/// Pose and twist of a pointer whose hand follows its scripted path.
BodyState onPath(const HandDef& hand, double t) {
  const WorkspaceMap map = mapOnPath(hand, t);
  return {map.X_WP(), map.V_WP()};
}

/// The bodies that move, at most the first few of a large scene: every one of them follows from the others' contacts.
std::vector<int> movingLinks(const WorldDef& def) {
  constexpr std::size_t kMost = 16;
  std::vector<int> links;
  int index = 0;
  for (const ArticulationDef& articulation : def.articulations) {
    for (const LinkDef& link : articulation.links) {
      const bool moves = link.joint.type != JointType::kFixed || link.parent >= 0;
      if (moves && links.size() < kMost) links.push_back(index);
      ++index;
    }
  }
  return links;
}

/// Largest extent of the smallest body that moves [m].
double smallestBody(const WorldDef& def) {
  double size = std::numeric_limits<double>::infinity();
  for (const ArticulationDef& articulation : def.articulations) {
    for (const LinkDef& link : articulation.links) {
      if (link.collisions.empty() || (link.joint.type == JointType::kFixed && link.parent < 0)) continue;
      Vector3 low = Vector3::Constant(1e300), high = -low;
      for (const CollisionDef& collision : link.collisions) {
        const ConvexShape::Box box = collision.shape->aabb(collision.X_LS);
        low = low.cwiseMin(box.lower);
        high = high.cwiseMax(box.upper);
      }
      size = std::min(size, (high - low).maxCoeff());
    }
  }
  return std::isfinite(size) ? size : 1;
}

std::string reasonAgainstPeers(const WorldDef& def) {
  if (!def.pointers.empty()) return "a hand holds a link by its pose; peers run free and fixed bodies";
  if (!def.loops.empty()) return "it has closed loops; peers run free and fixed bodies";
  for (const ArticulationDef& articulation : def.articulations) {
    for (const LinkDef& link : articulation.links) {
      if (link.parent >= 0 || (link.joint.type != JointType::kFloating && link.joint.type != JointType::kFixed)) {
        return "it has joints (link " + link.name + "); peers run free and fixed bodies";
      }
    }
  }
  return "";
}

}  // namespace

Scene fileScene(const std::string& file) {
  SceneOptions options;
  options.add_pointer = false;  // a robot's own motion; a hand that nobody scripted says nothing
  const auto loaded = std::make_shared<const SceneDef>(loadScene(file, options));
  const WorldDef& world = loaded->world;
  Scene s;
  const std::size_t slash = file.rfind('/'), dot = file.rfind('.');
  s.name = file.substr(slash == std::string::npos ? 0 : slash + 1,
                       dot == std::string::npos ? dot : dot - (slash == std::string::npos ? 0 : slash + 1));
  s.title = "Scene file " + s.name;
  s.parameters = "as in the file";
  s.seconds = 1;
  s.samples = 20;
  s.bodies = movingLinks(world);
  if (s.bodies.empty()) throw SetupError(file, "nothing in it moves", "give the report a scene with a free body or joint");
  s.size = smallestBody(world);
  s.stiffer_is_truer = false;
  s.not_for_peers = reasonAgainstPeers(world);
  s.make = [loaded](const Choice& choice) {
    WorldDef def = loaded->world;
    def.settings = settingsOf(choice, def.settings);
    def.settings.substeps = 1;  // the report's steps are what is computed
    return def;
  };
  if (!loaded->hands.empty()) {
    s.held = [loaded](int pointer, double t) {
      for (const HandDef& hand : loaded->hands) {
        if (hand.pointer == pointer) return onPath(hand, t);
      }
      return BodyState{};
    };
  }
  return s;
}

}  // namespace haptic::report
