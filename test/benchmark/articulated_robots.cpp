#include "articulated_robots.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "figure.h"
#include "haptic_core/base/error.h"
#include "haptic_core/world/world.h"
#include "scene/scene_file.h"

namespace haptic::bench {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> robotFiles() {
  const char* chosen = std::getenv("HAPTIC_ROBOTS");
  const fs::path folder =
      chosen ? fs::path(chosen) : fs::path(HAPTIC_SOURCE_DIR) / ".." / "shared" / "example-robot-data";
  std::vector<std::string> files;
  std::error_code code;
  for (fs::recursive_directory_iterator entry(folder, code), end; !code && entry != end;
       entry.increment(code)) {
    if (entry->path().extension() == ".urdf") files.push_back(entry->path().lexically_normal().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

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
  int tried = 0, loaded = 0, lost = 0;
  for (const std::string& file : robotFiles()) {
    ++tried;
    try {
      const SceneDef scene = loadScene(file);
      const World world(scene.world);
      lost += scene.collisions_tried - scene.collisions_loaded;
      ++loaded;
    } catch (const SetupError& error) {
      std::fprintf(stderr, "%s\n", error.what());
    }
  }
  figure("robots.tried", tried, "1");
  figure("robots.loaded", loaded, "1");
  figure("robots.collisions_lost", lost, "1");
  if (tried == 0) return;
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
