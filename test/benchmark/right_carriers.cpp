/// What friction holds on a carrier stays where it is; what it does not hold slips when it must.
#include <algorithm>
#include <cmath>

#include "../scenes/carriers.h"
#include "figure.h"
#include "right_figures.h"

namespace haptic::bench {
namespace {

using namespace scenes;

WorldSettings settingsOf(const NamedAttempts& method) {
  WorldSettings settings;
  method.into(settings);
  settings.step = 1e-3;
  return settings;
}

/// Mean of the cube's place over one period, in which the elastic share comes and goes [m].
Vector3 meanPlace(World& world, const CarriedCube& cube, double period) {
  const int steps = static_cast<int>(std::lround(period / world.settings().step));
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < steps; ++i) {
    world.step();
    sum += placeOnCarrier(world, cube);
  }
  return sum / steps;
}

/// On a carrier that goes to and fro: drift of the mean from the second period to the last, along the carrier [m].
double driftToAndFro(Carrier carrier, const NamedAttempts& method) {
  const CarriedCube cube;
  World world(carried(carrier, cube, settingsOf(method)));
  const double period = periodOf(carrier);
  meanPlace(world, cube, period);
  const Vector3 first = meanPlace(world, cube, period);
  Vector3 last = first;
  for (double t = 2 * period; t < 20; t += period) last = meanPlace(world, cube, period);
  return (last - first).head<2>().norm();
}

struct Turned {
  double drift = 0;       ///< at 0.98 of the slip's time, beyond the elastic share [m]
  double slip_error = 0;  ///< of the rate at which it slips, relative
};

/// m a/(k_t A0): what the layer gives way, in the carrier's frame; ω² r inwards, α r along [m].
Vector3 elasticPlace(const World& world, const CarriedCube& cube) {
  const double omega = world.linkTwist(0).angular.z(), kt = DefaultMaterial::kTangentialRatio * cube.stiffness;
  const Vector3 force = cube.mass * cube.radius * Vector3(-omega * omega, kSpinUp, 0);
  return world.contactCount() > 0 ? Vector3(-force / (kt * world.contact(0).area)) : Vector3::Zero();
}

Turned turntable(const NamedAttempts& method) {
  const CarriedCube cube;
  World world(carried(Carrier::kTurntable, cube, settingsOf(method)));
  const double limit = cube.mu * kGravity / cube.radius;  // ω⁴ + α² at the slip
  const double slips = std::sqrt(std::sqrt(limit * limit - kSpinUp * kSpinUp));
  Turned out;
  Vector3 first;
  for (int i = 0; i < 200; ++i) world.step();
  first = placeOnCarrier(world, cube) - elasticPlace(world, cube);
  bool measured = false;
  int sliding = 0;
  double began = 0;
  while (world.time() < 26 && sliding < 50) {
    world.step();
    const double omega = world.linkTwist(0).angular.z();
    if (!measured && omega >= 0.98 * slips) {
      measured = true;
      out.drift = (placeOnCarrier(world, cube) - elasticPlace(world, cube) - first).head<2>().norm();
    }
    const bool slides = world.contactCount() > 0 && !world.contact(0).sticking;
    if (slides && sliding == 0) began = omega;
    sliding = slides ? sliding + 1 : 0;
  }
  out.slip_error = std::abs(began / slips - 1);
  return out;
}

}  // namespace

void runCarriers() {
  double worst_drift = 0, worst_slip = 0;
  for (const NamedAttempts& i : kNamedAttempts) {
    const Turned turned = turntable(i);
    const double platform = driftToAndFro(Carrier::kPlatform, i), ramp = driftToAndFro(Carrier::kRamp, i);
    const std::string name = std::string("carrier.drift_um_");
    figure(name + "turntable_" + i.name, 1e6 * turned.drift, "um");
    figure(name + "platform_" + i.name, 1e6 * platform, "um");
    figure(name + "ramp_" + i.name, 1e6 * ramp, "um");
    figure(std::string("carrier.slip_err_pct_") + i.name, 100 * turned.slip_error, "%");
    worst_drift = std::max({worst_drift, turned.drift, platform, ramp});
    worst_slip = std::max(worst_slip, turned.slip_error);
  }
  figure("carrier.drift_um", 1e6 * worst_drift, "um");
  figure("carrier.slip_err_pct", 100 * worst_slip, "%");
}

}  // namespace haptic::bench
