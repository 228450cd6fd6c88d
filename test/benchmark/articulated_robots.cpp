#include "articulated_robots.h"

#include <cstdio>
#include <string>

#include "figure.h"
#include "haptic_core/base/error.h"
#include "haptic_core/world/world.h"
#include "scene/scene_file.h"

namespace haptic::bench {
namespace {

/// Median over blocks of 50 steps of one second of simulated time, free of what the loading left in the
/// caches.
double stepSeconds(const std::string& name) {
  const SceneDef scene = loadScene(std::string(HAPTIC_SOURCE_DIR) + "/urdf/scenes/" + name);
  World world(scene.world);
  for (int i = 0; i < 200; ++i) world.step();
  const double seconds = secondsPerCall([&](int) { world.step(); }, 50, 20);
  if (!world.report().finite) throw SetupError(name, "became non-finite", "");
  return seconds;
}

}  // namespace

void measureRobots() {
  try {
    const double panda = stepSeconds("panda_touch.yaml");
    figure("panda.step_us", panda * 1e6, "us");
    figure("panda.realtime_factor", 1e-3 / panda, "1");
    figure("allegro.step_us", stepSeconds("allegro_grasp.yaml") * 1e6, "us");
  } catch (const SetupError& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
}

}  // namespace haptic::bench
