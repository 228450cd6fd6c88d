/// Energy that nobody put in: scenes in motion with every integrator, and the shipped scenes as they are.
#include <algorithm>
#include <cmath>
#include <string>

#include "../scenes/heap.h"
#include "../scenes/moving.h"
#include "../scenes/shipped_scenes.h"
#include "figure.h"
#include "right_figures.h"

namespace haptic::bench {
namespace {

using namespace scenes;

/// Positive part of E(t) - E(0) - W(t) + D(t), over the largest energy exchanged so far.
class Gain {
 public:
  void look(const EnergyLedger& e) {
    if (!started_) first_ = e;
    started_ = true;
    const double dissipated = std::max(0.0, e.damping + e.friction - first_.damping - first_.friction);
    const double external = e.external - first_.external;
    exchanged_ = std::max({exchanged_, std::abs(e.kinetic - first_.kinetic), std::abs(e.potential - first_.potential),
                           std::abs(e.elastic - first_.elastic), std::abs(e.tangential - first_.tangential), std::abs(external),
                           dissipated});
    const double rounding = 1e-13 * (e.kinetic + std::abs(e.potential) + e.elastic + e.tangential + std::abs(external) + dissipated);
    const double gain = e.total() - first_.total() - external + dissipated - rounding;
    if (exchanged_ > 0) worst_ = std::max(worst_, gain / exchanged_);
  }
  double worst() const { return worst_; }

 private:
  EnergyLedger first_;
  bool started_ = false;
  double exchanged_ = 0, worst_ = 0;
};

double gainOf(const WorldDef& def, double seconds) {
  World world(def);
  Gain gain;
  for (double t = 0; t < seconds && world.report().finite; t += def.settings.step) {
    world.step();
    gain.look(world.report().energy);
  }
  return world.report().finite ? gain.worst() : 1e9;
}

double runShipped() {
  double worst = 0;
  for (const ShippedScene& scene : shippedScenes(std::string(HAPTIC_SOURCE_DIR) + "/urdf/scenes")) {
    if (!scene.def.world.settings.energy_ledger) continue;
    World world(scene.def.world);
    Gain gain;
    for (double t = 0; t < 2 && world.report().finite; t += world.settings().step) {
      followPaths(scene.def, world);
      world.step();
      gain.look(world.report().energy);
    }
    figure("energy.gain_rel_" + scene.name.substr(0, scene.name.rfind('.')), gain.worst(), "1");
    worst = std::max(worst, gain.worst());
  }
  return worst;
}

}  // namespace

void runEnergy() {
  double worst = 0;
  const auto run = [&](const std::string& name, const NamedIntegrator& i, const WorldDef& def, double seconds) {
    const double gain = gainOf(def, seconds);
    figure("energy.gain_rel_" + name + "_" + i.name, gain, "1");
    worst = std::max(worst, gain);
  };
  for (const NamedIntegrator& i : kIntegrators) {
    WorldSettings settings;
    settings.integrator = i.integrator;
    run("crosses", i, crosses(settings), 0.6);
    const double lower = 5e-5, depth = 0;  // m g/K = 196 µm
    run("table", i, table(settings, lower, depth), 1);
    settings.step = isExplicit(i.integrator) ? 2e-4 : 1e-3;
    run("dominoes", i, dominoes(settings, 1.05), 1);
    run("hexagon", i, hexagon(settings, 1e7, 6.44), 1);
    HeapParameters heap10;
    heap10.stiffness = isExplicit(i.integrator) ? 1e6 : 1e8;
    run("heap", i, heap(heap10, settings), 1);
    std::fprintf(stderr, "  %s\n", i.name);
  }
  worst = std::max(worst, runShipped());
  figure("energy.gain_rel_max", worst, "1");
}

}  // namespace haptic::bench
