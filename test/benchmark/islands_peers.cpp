/// The scene `city` beside ODE with auto-disable and Bullet with deactivation: CPU time of a world that has come to rest but for its hand.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "../peers/peer_world.h"
#include "figure.h"
#include "haptic_core/base/cpu_time.h"
#include "haptic_core/base/error.h"
#include "haptic_core/world/world.h"
#include "islands_scenes.h"
#include "scene/hand_on_path.h"
#include "scene/scene_file.h"

namespace haptic::bench {
namespace {

constexpr double kStep = 1e-3, kSettles = 6, kSeconds = 60;  // [s]: all that falls lies after 6 s, or is put to sleep
constexpr int kTurn = 250;                                   // steps of one engine before the next one's: the machine changes its speed
// The hand of a peer, which has none that is led: a critically damped spring, ω h = 0.1 for 0.05 kg, and its weight.
constexpr double kStiffness = 500, kDamping = 10;  // [N/m], [N·s/m]

/// An engine that steps the scene, and what it takes.
struct Runner {
  std::string name;
  std::unique_ptr<World> ours;
  std::unique_ptr<peers::PeerWorld> peer;
  double seconds = 0;

  void step(const SceneDef& scene, double t, int pointer_link, double weight) {
    if (ours) {
      followPaths(scene, *ours);
      ours->step();
      return;
    }
    const WorkspaceMap map = mapOnPath(scene.hands[0], t + kStep);
    const Pose X = peer->linkPose(pointer_link);
    const Vector3 f = kStiffness * (map.X_WP().p - X.p) + kDamping * (map.V_WP().linear - peer->linkTwist(pointer_link).linear);
    peer->applyForce(pointer_link, f + Vector3(0, 0, weight), X.p);
    peer->step();
  }
};

/// Free and fixed bodies alone, which every engine has: without robots, door and drawer. The first pointer stays.
WorldDef bodiesOf(const WorldDef& def) {
  WorldDef bodies;
  bodies.name = def.name, bodies.settings = def.settings;
  for (std::size_t i = 0; i < def.articulations.size(); ++i) {
    const ArticulationDef& tree = def.articulations[i];
    const JointType joint = tree.links[0].joint.type;
    if (tree.links.size() > 1 || (joint != JointType::kFloating && joint != JointType::kFixed)) continue;
    if (static_cast<int>(i) == def.pointers[0].articulation) {
      bodies.pointers = {def.pointers[0]};
      bodies.pointers[0].articulation = static_cast<int>(bodies.articulations.size());
    }
    bodies.articulations.push_back(tree);
  }
  return bodies;
}

/// Index of the first pointer's link through all articulations, and its weight [N].
std::pair<int, double> pointerOf(const WorldDef& def) {
  int link = 0;
  const PointerDef& pointer = def.pointers[0];
  for (int i = 0; i < pointer.articulation; ++i) link += static_cast<int>(def.articulations[static_cast<std::size_t>(i)].links.size());
  const ArticulationDef& tree = def.articulations[static_cast<std::size_t>(pointer.articulation)];
  return {link + pointer.link, tree.links[static_cast<std::size_t>(pointer.link)].inertia.mass * def.settings.gravity.norm()};
}

/// Side by side over the same simulated time, ours with `def` and the peer with `theirs`.
void compare(const SceneDef& scene, const WorldDef& def, const WorldDef& theirs, const std::string& peer, const std::string& figure_name) {
  std::vector<Runner> runners(2);
  const auto found = std::find_if(peers::peerTable().begin(), peers::peerTable().end(), [&](const auto& p) { return peer == p.name; });
  try {
    peers::PeerSettings settings = found->settings;
    settings.step = kStep;
    runners[0].name = "ours", runners[0].ours = std::make_unique<World>(def);
    runners[1].name = peer, runners[1].peer = peers::makePeer(theirs, settings);
  } catch (const SetupError& error) {
    std::printf("%s left out of %s: %s\n", peer.c_str(), figure_name.c_str(), error.what());
    return;
  }
  const auto [link, weight] = pointerOf(theirs);
  const int settles = static_cast<int>(kSettles / kStep), steps = static_cast<int>((kSettles + kSeconds) / kStep);
  for (int done = 0; done < steps; done += kTurn) {
    for (Runner& runner : runners) {
      const double start = cpuSeconds();
      for (int i = 0; i < kTurn; ++i) runner.step(scene, kStep * (done + i), link, weight);
      if (done >= settles) runner.seconds += cpuSeconds() - start;
    }
  }
  for (const Runner& runner : runners) figure(figure_name + "." + runner.name + "_cpu_s", runner.seconds, "s");
  figure(figure_name, runners[0].seconds / runners[1].seconds, "1");
  std::fflush(stdout);
}

}  // namespace

void measureCityBesidePeers() {
  SceneDef scene;
  try {
    scene = loadScene(HAPTIC_SOURCE_DIR "/urdf/scenes/large/city.yaml");
  } catch (const SetupError& error) {
    std::printf("city left out: %s\n", error.what());
    return;
  }
  scene.world.settings.step = kStep;
  const WorldDef bodies = bodiesOf(scene.world);
  // The peers have no friction in joints and none that follow others: theirs is without robots, door and drawer, which favours them.
  compare(scene, scene.world, bodies, "bullet10_sleeps", "city.cpu_vs_bullet");
  compare(scene, bodies, bodies, "bullet10_sleeps", "city.bodies_cpu_vs_bullet");
  compare(scene, bodies, bodies, "ode_quick20_sleeps", "city.bodies_cpu_vs_ode");
}

}  // namespace haptic::bench
