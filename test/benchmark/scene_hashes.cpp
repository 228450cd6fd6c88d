// `scene_hashes [--scheme S] [STEPS]`: World::hash() of every shipped scene after STEPS steps (1000), its hands on their
// paths. Two builds compute the same bits when the same lines come out (`diff`). S leaves it fewer attempts than all:
// verlet, implicit, sdirk2 or automatic.
#include <cinttypes>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>

#include "../comparators/named_attempts.h"
#include "../scenes/shipped_scenes.h"
#include "haptic_core/base/build_info.h"

/// Bits of the C library's own functions, which differ between the variants that it chooses from by processor.
std::uint64_t bitsOfCLibrary() {
  std::uint64_t bits = 0;
  for (int i = 1; i < 20000; ++i) {
    const volatile double x = 1e-3 * i;
    for (const double y : {std::sin(x), std::cos(x), std::exp(x), std::log(x), std::atan2(x, 0.7)}) {
      std::uint64_t word;
      std::memcpy(&word, &y, sizeof word);
      bits = bits * 31 + word;
    }
  }
  return bits;
}

int main(int argc, char** argv) {
  std::fprintf(stderr, "%s; C library %016" PRIx64 "\n", haptic::buildFlags().c_str(), bitsOfCLibrary());
  std::map<std::string, haptic::comparators::NamedAttempts> schemes;
  for (const auto& each : haptic::comparators::kNamedAttempts) schemes[each.name] = each;
  const haptic::comparators::NamedAttempts* scheme = nullptr;
  long steps = 1000;
  for (int i = 1; i < argc; ++i) {
    if (!std::strcmp(argv[i], "--scheme") && i + 1 < argc && schemes.count(argv[i + 1])) {
      scheme = &schemes.at(argv[++i]);
    } else if ((steps = std::atol(argv[i])) <= 0) {
      std::fputs("usage: scene_hashes [--scheme verlet|implicit|sdirk2|automatic] [STEPS]\n", stderr);
      return 2;
    }
  }
  for (haptic::scenes::ShippedScene& scene : haptic::scenes::shippedScenes(HAPTIC_SOURCE_DIR "/urdf/scenes")) {
    if (scheme) scheme->into(scene.def.world.settings);
    try {
      haptic::World world(scene.def.world);
      for (long i = 0; i < steps; ++i) {
        haptic::followPaths(scene.def, world);
        world.step();
      }
      std::printf("%-24s %016" PRIx64 "\n", scene.name.c_str(), world.hash());
    } catch (const haptic::SetupError& error) {
      std::printf("%-24s refused: %s\n", scene.name.c_str(), error.what());
    }
    std::fflush(stdout);
  }
}
