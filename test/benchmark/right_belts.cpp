/// A block that stands on a disc whose surface turns as a belt does, at .8 of friction's limit: it goes in a circle.
#include <algorithm>
#include <cmath>

#include "../scenes/turntable.h"
#include "figure.h"
#include "right_figures.h"

namespace haptic::bench {
namespace {

using namespace scenes;

constexpr double kTime = 2;     ///< [s]
constexpr double kShare = 0.8;  ///< of friction's limit

struct Ride {
  Turned end;            ///< of the block
  double given = 0;      ///< largest fall of the account of friction [J]
};

Ride ride(double h) {
  WorldDef def = onTurntable(kShare);
  def.settings.step = h;
  World world(def);
  Ride out;
  double most = 0;
  for (int i = 0; i < std::lround(kTime / h); ++i) {
    world.step();
    most = std::max(most, world.report().energy.friction);
    out.given = std::max(out.given, most - world.report().energy.friction);
  }
  out.end = turnedTo(world, kShare);
  return out;
}

}  // namespace

void runBelts() {
  const auto away = [](const Ride& r) { return 1e6 * std::abs(r.end.radius - kTurntableRadius); };
  const auto lag = [](const Ride& r) { return 1e6 * kTurntableRadius * std::abs(r.end.beyond); };
  const Ride fine = ride(1e-4), usual = ride(1e-3), coarse = ride(2e-3);
  figure("belt.turning_um", away(usual), "um");
  figure("belt.turning_um_h100us", away(fine), "um");
  figure("belt.turning_um_h2ms", away(coarse), "um");
  figure("belt.elastic_um", 1e6 * turntableSlip(kShare), "um");  // how far the layer under the block yields
  figure("belt.lag_um", lag(usual), "um");                       // along the circle
  figure("belt.order", std::log2(lag(coarse) / lag(usual)), "1");
  figure("belt.friction_given_j", std::max({fine.given, usual.given, coarse.given}), "J");
}

}  // namespace haptic::bench
