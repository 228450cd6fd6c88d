/// `world_cost SCENE`: instructions of one step and the state's hash after it, for `./run bench plan`. Two programs are
/// made of this source: one with the whole world, one with the plain world (haptic_core/world/features.h).
#include <cinttypes>
#include <cstdio>
#include <cstring>

#include "../scenes/blocks.h"
#include "single_stepping.h"

int main(int argc, char** argv) {
  using namespace haptic;
  if (argc != 2) return 2;
  // Free bodies and contacts, no ledger, an explicit step: what both worlds can do.
  constexpr int kWarmUp = 200;  // steps: the contacts have settled, no first call is left
  const scenes::CubeParameters c;
  WorldSettings settings;
  settings.step = 0.25e-3;
  settings.energy_ledger = false;
  if (std::strstr(argv[1], "verlet")) settings.integrator = Integrator::kVelocityVerlet;
  World world(std::strstr(argv[1], "stack") ? scenes::stack(15, c, settings) : scenes::cubeOnFloor(c, settings));
  for (int i = 0; i < kWarmUp; ++i) world.step();
  const long count = bench::singleStepped([&] { world.step(); });
  world.step();
  std::printf("%ld %" PRIu64 "\n", count, world.hash());
  return count < 0;
}
