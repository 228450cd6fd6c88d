/// `scene_check FILE|NAME`: loads a scene, compiles its world and prints what became of it.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <string>

#include "haptic_core/base/error.h"
#include "haptic_core/world/certificate.h"
#include "haptic_core/world/world.h"
#include "scene/scene_file.h"

namespace {

constexpr char kUsage[] =
    "usage: scene_check [--default-density KG_PER_M3] [--srdf FILE] [--scenes FOLDER] SCENE|FILE\n"
    "exit code: 0 loaded, 1 loaded with warnings and --strict, 2 refused or wrong usage\n";

}  // namespace

int main(int argc, char** argv) {
  haptic::SceneOptions options;
  std::string name;
  bool strict = false;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const bool has_value = i + 1 < argc;
    if (argument == "--strict") {
      strict = true;
    } else if (argument == "--default-density" && has_value) {
      char* end = nullptr;
      options.default_density = std::strtod(argv[++i], &end);
      if (*end != '\0' || !(options.default_density > 0)) {
        std::fprintf(stderr, "scene_check: --default-density '%s' is not a density > 0 in kg/m³\n", argv[i]);
        return 2;
      }
    } else if (argument == "--srdf" && has_value) {
      options.srdf = argv[++i];
    } else if (argument == "--scenes" && has_value) {
      options.scene_folders.push_back(argv[++i]);
    } else if (name.empty() && argument.rfind("--", 0) != 0) {
      name = argument;
    } else {
      std::fprintf(stderr, "scene_check: unexpected '%s'\n%s", argument.c_str(), kUsage);
      return 2;
    }
  }
  if (name.empty()) {
    std::fputs(kUsage, stderr);
    return 2;
  }
  try {
    const haptic::SceneDef scene = haptic::loadScene(name, options);
    std::fputs(haptic::sceneText(scene).c_str(), stdout);
    const haptic::World world(scene.world);
    std::fputs(world.planText().c_str(), stdout);
    const haptic::Certificate certificate = haptic::certify(scene.world);
    std::fputs(certificate.text().c_str(), stdout);
    std::printf("figure check.collisions_lost %d 1\nfigure check.warnings %zu 1\n",
                scene.collisions_tried - scene.collisions_loaded, scene.warnings.size());
    return strict && !scene.warnings.empty() ? 1 : 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "scene_check: %s\n", error.what());
    return 2;
  }
}
