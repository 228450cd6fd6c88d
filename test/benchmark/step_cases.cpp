/// Single motions whose outcome is known: a turntable, a marble, a rod that is hit, bounces.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "../scenes/balls.h"
#include "../scenes/bounce.h"
#include "../scenes/carriers.h"
#include "../scenes/moving.h"
#include "figure.h"
#include "step_figures.h"

namespace haptic::bench {
namespace {

/// Time at which the cube first slips, less the exact one [s]; k_eff 1e7 N/m.
double slipError(Attempts attempts) {
  scenes::CarriedCube cube;
  cube.stiffness = 1e7 / (cube.size * cube.size);
  const double limit = cube.mu * scenes::kGravity / cube.radius;  // ω⁴ + α² at the slip
  const double exact = std::sqrt(std::sqrt(limit * limit - scenes::kSpinUp * scenes::kSpinUp)) / scenes::kSpinUp;
  World world(scenes::carried(scenes::Carrier::kTurntable, cube, stepSettings(attempts)));
  bool slips = false;
  while (world.time() < 26 && !slips) {
    world.step();
    slips = world.contactCount() > 0 && !world.contact(0).sticking;
  }
  return world.time() - exact;
}

/// Speed that a glass ball of 1 cm radius loses while it rolls for a second at 0.5 m/s; defaults.
double marbleLoss(double k) {
  constexpr double kRadius = 0.01, kDensity = 2500, kSpeed = 0.5;
  const double mass = 4.0 / 3 * M_PI * kRadius * kRadius * kRadius * kDensity;
  WorldDef def;
  def.settings = stepSettings();
  def.settings.default_material.stiffness = k;
  def.articulations.push_back(scenes::groundPlane());
  const double depth = std::sqrt(mass * scenes::kGravity / (k * M_PI * kRadius));
  def.articulations.push_back(scenes::freeBody("marble", std::make_shared<Ball>(kRadius), mass,
                                               0.4 * mass * kRadius * kRadius * Matrix3::Identity(),
                                               Pose(Vector3(0, 0, kRadius - depth)),
                                               {Vector3(0, kSpeed / kRadius, 0), Vector3(kSpeed, 0, 0)}));
  World world(def);
  for (int i = 0; i < 1000; ++i) world.step();
  return 1 - world.linkTwist(1).linear.x() / kSpeed;
}

/// 1: the impact of a cube on a hanging rod comes out within 5 %, or the step says that it is not resolved.
bool saysRodImpact(Attempts attempts) {
  World world(scenes::rodAndCube(stepSettings(attempts)));
  bool said = false;
  for (int i = 0; i < 100; ++i) {
    world.step();
    said |= (world.report().flags & (kImpactUnresolved | kNotConverged)) != 0;
  }
  const double off = std::abs(world.linkTwist(0).angular.norm() / scenes::kRodRate - 1);
  std::printf("rod and cube: %.3g of the rate off, %s\n", off, said ? "said" : "not said");
  return said || off < 0.05;
}

/// Largest error of the speed after a bounce, of the speed before, over laws, dampings, masses and stiffnesses.
double bounceError() {
  double worst = 0;
  const std::pair<PressureLaw, double> kinds[] = {
      {PressureLaw::kLinear, 0.0}, {PressureLaw::kLinear, 0.3}, {PressureLaw::kHuntCrossley, 0.3}, {PressureLaw::kHuntCrossley, 1.0}};
  for (const auto& [law, damping] : kinds) {
    for (const double mass : {0.1, 2.0}) {
      for (const double k_eff : {1e4, 2e5}) {
        const double error = scenes::worstExit({law, damping, mass, k_eff});
        std::printf("bounce: law %d, damping %g, %g kg, %g N/m: %.3g %%\n", static_cast<int>(law), damping, mass, k_eff, 100 * error);
        worst = std::max(worst, error);
      }
    }
  }
  return worst;
}

}  // namespace

void runCases() {
  double slip = 0;
  const std::pair<Attempts, const char*> methods[] = {
      {Attempts::kAll, "automatic"}, {Attempts::kSdirk2, "sdirk2"}, {Attempts::kImplicitEuler, "implicit"}};
  for (const auto& [attempts, name] : methods) {
    const double error = slipError(attempts);
    figure(std::string("turntable.slip_err_s_") + name, error, "s");
    slip = std::max(slip, std::abs(error));
  }
  figure("turntable.slip_err_s", slip, "s");
  figure("marble.loss_pct", 100 * marbleLoss(1e7), "%");
  bool said = true;
  for (const auto& [attempts, name] : methods) said &= saysRodImpact(attempts);
  figure("rod_impact.said", said ? 1 : 0, "1");
  figure("bounce.speed_err_pct", 100 * bounceError(), "%");
}

}  // namespace haptic::bench
