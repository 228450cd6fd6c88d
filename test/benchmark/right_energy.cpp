/// Energy that nobody put in: scenes in motion with every integrator, and the shipped scenes as they are.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "../comparators/velocity_verlet.h"
#include "../scenes/heap.h"
#include "../scenes/moving.h"
#include "../scenes/shipped_scenes.h"
#include "energy_gain.h"
#include "figure.h"
#include "right_figures.h"

namespace haptic::bench {
namespace {

using namespace scenes;

constexpr double kGainAsked = 1e-3;  // of energy.gain_rel; scenes beyond it are listed

/// The defined one and that of the whole run.
struct Gains {
  double so_far = 0, of_run = 0;
  void worst(const Gains& o) {
    so_far = std::max(so_far, o.so_far);
    of_run = std::max(of_run, o.of_run);
  }
};

Gains printed(const std::string& name, const EnergyGain& gain, bool finite) {
  const Gains out = finite ? Gains{gain.worst(), gain.worstOfRun()} : Gains{1e9, 1e9};
  figure("energy.gain_rel_" + name, out.so_far, "1");
  figure("energy.gain_of_run_" + name, out.of_run, "1");
  if (out.so_far > kGainAsked) std::fprintf(stderr, "  beyond %g: %s\n", kGainAsked, name.c_str());
  return out;
}

Gains gainOf(const std::string& name, const WorldDef& def, double seconds) {
  World world(def);
  EnergyGain gain;
  for (double t = 0; t < seconds && world.report().finite; t += def.settings.step) {
    world.step();
    gain.look(world.report().energy);
  }
  return printed(name, gain, world.report().finite);
}

Gains runShipped() {
  Gains worst;
  for (const ShippedScene& scene : shippedScenes(std::string(HAPTIC_SOURCE_DIR) + "/urdf/scenes")) {
    if (!scene.def.world.settings.energy_ledger) continue;
    World world(scene.def.world);
    EnergyGain gain;
    for (double t = 0; t < 2 && world.report().finite; t += world.settings().step) {
      followPaths(scene.def, world);
      world.step();
      gain.look(world.report().energy);
    }
    worst.worst(printed(scene.name.substr(0, scene.name.rfind('.')), gain, world.report().finite));
  }
  return worst;
}

/// Work that a normal that turns did from nothing, over the largest kinetic energy exchanged: the crosses, at ever smaller steps,
/// by the law.
void runTurning() {
  for (const PressureLaw law : {PressureLaw::kHuntCrossley, PressureLaw::kPotential}) {
    const std::string suffix = kindOf(law).potential ? "_potential" : "";
    for (const double h : {1e-3, 1e-4, 1e-5}) {
      WorldSettings settings;
      settings.comparator = comparators::velocityVerlet;
      settings.step = h;
      settings.pressure_law = law;
      World world(crosses(settings));
      EnergyGain gain;
      double turning = 0, most = 0, exchanged = 0, first = 0;
      for (double t = 0; t < 0.6; t += h) {
        world.step();
        const EnergyLedger& e = world.report().energy;
        gain.look(e);
        if (first == 0) first = e.kinetic;
        turning = e.turning;
        most = std::max(most, std::abs(turning));
        exchanged = std::max(exchanged, std::abs(e.kinetic - first));
      }
      char step[16];
      std::snprintf(step, sizeof step, "_1e%d", static_cast<int>(std::lround(std::log10(h))));
      figure("energy.turning_rel" + suffix + step, most / exchanged, "1");
      figure("energy.crosses_gain_rel" + suffix + step, gain.worstOfRun(), "1");
    }
  }
}

}  // namespace

void runEnergy() {
  runTurning();
  Gains worst, of_default;
  const auto run = [&](const std::string& name, const NamedAttempts& i, const WorldDef& def, double seconds) {
    const Gains gains = gainOf(name + "_" + i.name, def, seconds);
    worst.worst(gains);
    if (i.attempts == WorldSettings{}.attempts) of_default.worst(gains);
  };
  for (const NamedAttempts& i : kNamedAttempts) {
    WorldSettings settings;
    i.into(settings);
    run("crosses", i, crosses(settings), 0.6);
    const double lower = 5e-5, depth = 0;  // m g/K = 196 µm
    run("table", i, table(settings, lower, depth), 1);
    settings.step = i.comparator ? 2e-4 : 1e-3;
    run("dominoes", i, dominoes(settings, 1.05), 1);
    run("hexagon", i, hexagon(settings, 1e7, 6.44), 1);
    HeapParameters heap10;
    heap10.stiffness = i.comparator ? 1e6 : 1e8;
    run("heap", i, heap(heap10, settings), 1);
    std::fprintf(stderr, "  %s\n", i.name);
  }
  const Gains shipped = runShipped();
  worst.worst(shipped);
  of_default.worst(shipped);
  figure("energy.gain_rel_max_default", of_default.so_far, "1");  // the scenes by all attempts, and the shipped ones
  figure("energy.gain_of_run_max_default", of_default.of_run, "1");
  figure("energy.gain_rel_max", worst.so_far, "1");
  figure("energy.gain_of_run_max", worst.of_run, "1");
}

}  // namespace haptic::bench
