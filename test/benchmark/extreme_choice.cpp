/// Instructions of the default where nothing is stiff, over those of velocity Verlet.
#include <cstring>

#include "../comparators/velocity_verlet.h"
#include "../scenes/blocks.h"
#include "extreme_figures.h"
#include "figure.h"
#include "instruction_count.h"

namespace haptic::bench {

using namespace scenes;

void countSoft(const char* attempts) {
  const bool automatic = std::strcmp(attempts, "automatic") == 0;
  CubeParameters c;
  c.ratio = 0.05;
  c.tangential_ratio = 0.1;
  WorldSettings s = implicitSettings(1e-3, Attempts::kAll);
  if (!automatic) s.comparator = comparators::velocityVerlet;
  s.energy_ledger = false;
  WorldDef def = stack(3, c, s);
  for (int i = 0; i < 5; ++i) {
    def.articulations.push_back(cube("apart" + std::to_string(i), c,
                                     Pose(Vector3(0.3 * (i + 1), 0, c.size / 2 - c.restDepth()))));
  }
  World world(def);
  for (int i = 0; i < 300; ++i) world.step();
  countedPass([&] {
    for (int i = 0; i < 512; ++i) world.step();
  });
}

void softOverhead() {
  const double automatic = instructionsOf("--count automatic"), plain = instructionsOf("--count plain");
  instructionFigure("soft.step_instructions", automatic / 512);
  if (std::isfinite(automatic / plain)) figure("soft.overhead_ratio", automatic / plain, "1");
}

}  // namespace haptic::bench
