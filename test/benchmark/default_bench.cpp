/// The integrator that users get: what it costs where nothing is stiff, what changes when it changes its mind, and whether
/// bodies leave a bounce with the speed that they should have. `bench_default count AUTOMATIC` is its own child.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>

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
WorldDef softScene(Attempts attempts, int cubes) {
  WorldDef def;
  def.name = "soft";
  def.settings.step = kStep;
  def.settings.attempts = attempts;
  def.settings.default_material.stiffness = 1e6;
  def.articulations.push_back(floorBox());
  for (int i = 0; i < cubes; ++i) {
    const Vector3 place(0.3 * (i % 4), 0.3 * (i / 4), kEdge / 2 + 0.002 * i);
    def.articulations.push_back(freeBox("cube" + std::to_string(i), Vector3::Constant(kEdge), 0.1, Pose(place),
                                        {Vector3(0, 0, i), Vector3(0.2 * i, 0, 0)}));
  }
  return def;
}

/// A cube that sticks on a slope, its contact at `k` [N/m³], with a pointer whose virtual coupling holds it where it rests.
WorldDef slopedScene(double k) {
  WorldDef def = softScene(Attempts::kAll, 1);
  def.settings.gravity = kGravity * Vector3(std::sin(0.3), 0, -std::cos(0.3));
  def.settings.default_material.stiffness = k;
  const double depth = 0.1 * kGravity * std::cos(0.3) / (k * kEdge * kEdge);
  def.articulations[1] = freeBox("cube", Vector3::Constant(kEdge), 0.1, Pose(Vector3(0, 0, kEdge / 2 - depth)));
  PointerDef pointer;
  pointer.articulation = 1;
  pointer.link = 0;
  pointer.coupling.mode = PointerCoupling::Mode::kVirtual;
  def.pointers.push_back(pointer);
  return def;
}

/// The coupling off and on makes the island soft and stiff again, while the cube rests and the coupling pulls nothing: the
/// largest change of the contact's wrench over a step that changed the mode.
void runSwitches() {
  // A stiffness that leaves the island to either mode, and which the coupling's share carries over the bound.
  double k = 1e6;
  const auto numberAt = [](double stiffness) {
    World world(slopedScene(stiffness));
    WorldTuning off = world.tuning();
    off.coupling[0].stiffness = off.coupling[0].damping = 0;
    off.coupling[0].rotational_stiffness = off.coupling[0].rotational_damping = 0;
    world.tune(off);
    for (int i = 0; i < 3; ++i) world.step();
    return world.report().stability;
  };
  while (numberAt(1.05 * k) < 0.69) k *= 1.05;
  World world(slopedScene(k));
  const WorldTuning on = world.tuning();
  WorldTuning off = on;
  off.coupling[0].stiffness = off.coupling[0].damping = 0;
  off.coupling[0].rotational_stiffness = off.coupling[0].rotational_damping = 0;
  world.tune(off);
  double worst = 0;
  int switches = 0;
  bool implicit = false;
  Vector3 last = Vector3::Zero();
  for (int i = 0; i < 6000; ++i) {
    if (i >= 3000) {  // settled
      if (i % 200 == 0) world.setPointerTarget(0, world.linkPose(world.pointerLink(0)), Twist{});
      world.tune(i % 200 < 100 ? on : off);
    }
    world.step();
    const Vector3 force = world.contactCount() > 0 ? world.contact(0).F_BP_W.force : Vector3::Zero();
    const bool now = world.report().implicit_islands > 0;
    if (i >= 3000 && now != implicit) {
      worst = std::max(worst, (force - last).norm());
      ++switches;
    }
    implicit = now;
    last = force;
  }
  std::printf("k %.3g N/m3: %d changes of mode while %.4f N rest on the slope\n", k, switches, last.norm());
  figure("default.switches", switches, "1");
  figure("default.switch_jump_n", switches > 0 ? worst : std::nan(""), "N");
}

constexpr int kCounted = 500;  // steps

void countSoft(Attempts attempts) {
  World world(softScene(attempts, 8));
  for (int i = 0; i < 200; ++i) world.step();
  countedPass([&] {
    for (int i = 0; i < kCounted; ++i) world.step();
  });
  if (world.report().implicit_islands > 0) std::fprintf(stderr, "bench_default: the soft scene became stiff\n");
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
    countSoft(std::strcmp(argv[2], "automatic") == 0 ? Attempts::kAll : Attempts::kVerlet);
    return 0;
  }
  runBounces();
  runCosts();
  runSwitches();
  return 0;
}
