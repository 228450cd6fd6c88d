/// Closed chains: energy of rings that nothing touches, their order, and a roller chain by two closures.
#include <algorithm>
#include <cmath>
#include <vector>

#include "../scenes/rings.h"
#include "figure.h"
#include "right_figures.h"

namespace haptic::bench {
namespace {

using namespace scenes;

Matrix3 oblique() { return Quaternion(0.7, 0.3, -0.5, 0.4).normalized().toRotationMatrix(); }

/// Largest |E − E₀|/E₀ in 10 s at 1 ms; E₀: when the first step has closed the ring.
double energyError(int links, LoopDef::Type closure, double rate, const Matrix3& R) {
  World world(freeRing(links, closure, rate, R));
  world.step();
  const double start = world.report().energy.total();
  double worst = 0;
  for (int i = 0; i < 10000; ++i) {
    world.step();
    if (!world.report().finite) return 1e9;
    worst = std::max(worst, std::abs(world.report().energy.total() / start - 1));
  }
  return worst;
}

/// q after .24 s by steps of h.
std::vector<double> endOf(int links, double h) {
  WorldDef def = freeRing(links, LoopDef::Type::kHinge, 20, oblique());
  def.settings.step = h;
  World world(def);
  for (int i = 0; i < std::lround(0.24 / h); ++i) world.step();
  return world.q();
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

struct ChainRun {
  double turned = 0;   ///< of the first sprocket in 3 s [rad]
  double balance = 0;  ///< |numerical| over the work of the drive
};

ChainRun runChain(LoopDef::Type closure) {
  World world(rollerChain(closure));
  JointCommand command;
  command.drive = JointDef::Drive::kEffort;
  command.effort = 0.5;
  world.setJointCommand(0, command);
  for (int i = 0; i < 3000; ++i) world.step();
  const EnergyLedger& energy = world.report().energy;
  return {world.q()[0], std::abs(energy.numerical) / energy.external};
}

}  // namespace

void runRings() {
  double worst = 0, least = 1e9;
  for (const int links : {4, 6, 12, 16}) {
    for (const LoopDef::Type closure : {LoopDef::Type::kPoint, LoopDef::Type::kHinge}) {
      for (const double rate : {3., 10., 30.}) {
        for (const Matrix3& R : {Matrix3(Matrix3::Identity()), oblique()}) worst = std::max(worst, energyError(links, closure, rate, R));
      }
    }
    if (links == 4) continue;  // a rhombus folds flat, and its way on from there is not determined
    const std::vector<double> exact = endOf(links, 2.5e-4);
    least = std::min(least, std::log2(distance(endOf(links, 4e-3), exact) / distance(endOf(links, 2e-3), exact)));
  }
  figure("ring.free_energy_rel", worst, "1");
  figure("ring.order", least, "1");
  const ChainRun point = runChain(LoopDef::Type::kPoint), hinge = runChain(LoopDef::Type::kHinge);
  figure("ring.chain_turns", point.turned / (2 * M_PI), "1");
  figure("ring.closures_differ_rel", std::abs(hinge.turned / point.turned - 1), "1");
  figure("ring.chain_balance_rel", std::max(point.balance, hinge.balance), "1");
}

}  // namespace haptic::bench
