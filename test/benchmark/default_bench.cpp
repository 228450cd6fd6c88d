/// The integrator that users get: its cost where nothing is stiff, over that of velocity Verlet, and whether bodies leave a bounce with the
/// speed that they should have. `bench_default count AUTOMATIC` is its own child.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>

#include "../comparators/velocity_verlet.h"
#include "../scenes/bounce.h"
#include "figure.h"
#include "instruction_count.h"

namespace haptic::bench {
namespace {

using namespace scenes;

constexpr double kStep = 1e-3;  // [s]
constexpr double kEdge = 0.1;   // [m]

void runBounces() {
  double worst = 0, resolved = 0;
  std::printf("%-14s %7s %8s %9s %7s %10s\n", "law", "damping", "mass kg", "k A N/m", "steps", "error %");
  for (const auto& [law, damping] : {std::pair{PressureLaw::kLinear, 0.0}, {PressureLaw::kLinear, 0.1},
                                     {PressureLaw::kLinear, 0.3}, {PressureLaw::kLinear, 0.6},
                                     {PressureLaw::kHuntCrossley, 0.3}, {PressureLaw::kHuntCrossley, 0.6},
                                     {PressureLaw::kHuntCrossley, 1.0}, {PressureLaw::kHuntCrossley, 2.0}}) {
    for (double mass : {0.1, 2.0}) {
      for (double k_eff : {1e4, 2e5}) {
        const Bounce bounce{law, damping, mass, k_eff};
        const double error = worstExit(bounce), steps = bounce.exactExit(0.45)[1] / kStep;
        std::printf("%-14s %7.2f %8.1f %9.0f %7.1f %10.3f\n", kindOf(law).name, damping, mass, k_eff, steps, 100 * error);
        worst = std::max(worst, error);
        if (steps >= 10) resolved = std::max(resolved, error);
      }
    }
  }
  figure("bounce.exit_err_pct_max", 100 * worst, "%");
  figure("bounce.exit_err_resolved_pct_max", 100 * resolved, "%");  // contacts of ten steps and more
}

/// Cubes on a floor, some spinning on it, all soft.
WorldDef softScene(MakeComparator comparator, int cubes) {
  WorldDef def;
  def.name = "soft";
  def.settings.step = kStep;
  def.settings.comparator = comparator;
  def.settings.default_material.stiffness = 1e6;
  def.articulations.push_back(floorBox());
  for (int i = 0; i < cubes; ++i) {
    const Vector3 place(0.3 * (i % 4), 0.3 * (i / 4), kEdge / 2 + 0.002 * i);
    def.articulations.push_back(freeBox("cube" + std::to_string(i), Vector3::Constant(kEdge), 0.1, Pose(place),
                                        {Vector3(0, 0, i), Vector3(0.2 * i, 0, 0)}));
  }
  return def;
}

constexpr int kCounted = 500;  // steps

void countSoft(MakeComparator comparator) {
  World world(softScene(comparator, 8));
  for (int i = 0; i < 200; ++i) world.step();
  countedPass([&] {
    for (int i = 0; i < kCounted; ++i) world.step();
  });
}

void runCosts() {
  const double automatic = instructionsOf("count automatic"), verlet = instructionsOf("count verlet");
  std::printf("a soft step: %.0f instructions automatic, %.0f velocity Verlet\n", automatic / kCounted, verlet / kCounted);
  figure("default.soft_overhead_pct", 100 * (automatic / verlet - 1), "%");
}

}  // namespace
}  // namespace haptic::bench

int main(int argc, char** argv) {
  using namespace haptic;
  using namespace haptic::bench;
  if (argc > 2 && std::strcmp(argv[1], "count") == 0) {
    countSoft(std::strcmp(argv[2], "automatic") == 0 ? nullptr : comparators::velocityVerlet);
    return 0;
  }
  runBounces();
  runCosts();
  return 0;
}
