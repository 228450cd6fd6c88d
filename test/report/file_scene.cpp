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

/// What no peer is told, or none can be.
std::string reasonAgainstPeers(const WorldDef& def) {
  if (!def.loops.empty()) return "it has closed loops";
  if (!def.motions.empty()) return "motions lead its bodies";
  if (!def.forces.empty()) return "it has force elements";
  for (const PointerDef& pointer : def.pointers) {
    const ArticulationDef& tool = def.articulations[static_cast<std::size_t>(pointer.articulation)];
    if (tool.links.size() > 1) return "a hand holds link " + tool.links[static_cast<std::size_t>(pointer.link)].name + " of an arm";
  }
  try {
    WorldDef without_hands = def;
    without_hands.pointers.clear();
    peers::peerBodies(without_hands, {}, true);
  } catch (const SetupError& error) {
    return error.what();
  }
  return "";
}

/// One pass of a path that the scene repeats [s]: the shortest beginning that the rest consists of.
double onePass(const HandPath& path) {
  const std::vector<HandKey>& keys = path.keys;
  for (std::size_t n = 1; n < keys.size(); ++n) {
    if (keys.size() % n != 0) continue;
    bool repeats = true;
    for (std::size_t i = n; repeats && i < keys.size(); ++i) {
      repeats = keys[i].p_BG == keys[i - n].p_BG && keys[i].rotation == keys[i - n].rotation &&
                std::abs(keys[i].time - keys[i - n].time - keys[n - 1].time) < 1e-9;
    }
    if (repeats) return keys[n - 1].time;
  }
  return path.duration();
}

/// Of a peer's tool, which a spring pulls along the hand's path: as stiff as the scene's own step follows with 8 steps a radian.
HandSpring springFor(const SceneDef& scene, const HandDef& hand, int link) {
  const PointerDef& pointer = scene.world.pointers[static_cast<std::size_t>(hand.pointer)];
  const ArticulationDef& tool = scene.world.articulations[static_cast<std::size_t>(pointer.articulation)];
  const LinkInertia& inertia = tool.links[static_cast<std::size_t>(pointer.link)].inertia;
  const double omega = 0.125 / 1e-3, moment = inertia.I_C.diagonal().maxCoeff();
  HandSpring spring;
  spring.link = link;
  spring.stiffness = inertia.mass * omega * omega, spring.damping = 2 * inertia.mass * omega;
  spring.rotational_stiffness = moment * omega * omega, spring.rotational_damping = 2 * moment * omega;
  return spring;
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
  for (const HandDef& hand : loaded->hands) s.seconds = std::max(s.seconds, onePass(hand.path));
  s.samples = 20 * static_cast<int>(std::ceil(s.seconds));
  s.bodies = movingLinks(world);
  if (s.bodies.empty()) throw SetupError(file, "nothing in it moves", "give the report a scene with a free body or joint");
  s.size = smallestBody(world);
  s.stiffer_is_truer = false;
  s.not_for_peers = reasonAgainstPeers(world);
  s.make = [loaded](const Choice& choice) {
    WorldDef def = loaded->world;
    def.settings = settingsOf(choice, def.settings);
    return def;
  };
  if (!loaded->hands.empty()) {
    s.held = [loaded](int pointer, double t) {
      for (const HandDef& hand : loaded->hands) {
        if (hand.pointer == pointer) return onPath(hand, t);
      }
      return BodyState{};
    };
    s.parameters += "; peers: a spring pulls the tool along the hand's path, for they have no led bodies";
    const World links(world);
    for (const HandDef& hand : loaded->hands) {
      s.peer_hands.push_back(springFor(*loaded, hand, links.pointerLink(hand.pointer)));
      const Pose X_PL = world.pointers[static_cast<std::size_t>(hand.pointer)].X_LP.inverse();
      s.peer_hands.back().path = [pointer = hand.pointer, X_PL, held = s.held](double t) {
        const BodyState P = held(pointer, t);
        return BodyState{P.X_WL * X_PL, P.V_WL.shifted(P.X_WL.R * X_PL.p)};
      };
    }
  }
  return s;
}

}  // namespace haptic::report
