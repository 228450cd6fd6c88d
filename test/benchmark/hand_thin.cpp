#include "hand_thin.h"

#include <algorithm>
#include <cstdio>

#include "../scenes/thin_presses.h"
#include "figure.h"
#include "haptic_core/base/error.h"

namespace haptic::bench {
namespace {

constexpr double kMostGiven = 0.01;   ///< [J], what the figure asks for
constexpr double kLeastFelt = 0.8;    ///< share, likewise

/// Worst of all presses.
struct ThinWorst {
  double given = 0, given_direct = 0, moving = 0, moving_direct = 0, held = 0, jump = 0, felt = 1;
  int done = 0, refused = 0, infinite = 0;
  int rings = 0, rings_direct = 0, jumps = 0, gives = 0, felt_less = 0, passed_and_rang = 0, softened = 0, doubted = 0;
};

TrialResult tried(const scenes::ThinPress& p, const DeviceDef& device) { return tryHand(p.world, 0, p.settings, device, p.way); }

void add(const scenes::ThinPress& p, int number, ThinWorst& worst) {
  const DeviceDef device = loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + p.device + ".yaml");
  const TrialResult r = tried(p, device);
  ++worst.done;
  double felt = 1;
  if (p.isVirtual()) {
    scenes::ThinPress direct = p;
    direct.world.pointers.back().coupling.mode = PointerCoupling::Mode::kDirect;
    const TrialResult d = tried(direct, device);
    if (d.steady() && d.strongest > 0) felt = r.strongest / d.strongest;
  }
  const bool rang = r.rings, gave = r.energy_given > kMostGiven, jumped = r.jump > kQuietJump;
  worst.rings += rang, worst.jumps += jumped, worst.gives += gave, worst.felt_less += felt < kLeastFelt;
  worst.rings_direct += rang && !p.isVirtual(), worst.infinite += !r.finite;
  worst.softened += r.weakened > 0;
  worst.doubted += r.doubted > 0;
  worst.jump = std::max(worst.jump, r.jump);
  worst.felt = std::min(worst.felt, felt);
  worst.given = std::max(worst.given, r.energy_given);
  worst.moving = std::max(worst.moving, r.energy_moving);
  worst.held = std::max(worst.held, r.energy_held);
  if (!p.isVirtual() && r.steady()) {
    worst.given_direct = std::max(worst.given_direct, r.energy_given);
    worst.moving_direct = std::max(worst.moving_direct, r.energy_moving);
  }
  if (rang) worst.passed_and_rang += pressHand(p.world, 0, p.settings, device).steady();
  if (!rang && !gave && !jumped && r.finite && felt >= kLeastFelt && r.doubted == 0) return;
  std::printf("thin %d:%s%s%s jump %.2f N, gave %.4f (%.4f less motion, %.4f beyond held) J, most %.2f N, felt %.2f: %s\n", number,
              rang ? " RINGS" : "", r.finite ? "" : " NOT FINITE", r.doubted > 0 ? " DOUBTED" : "", r.jump, r.energy_given,
              r.energy_moving, r.energy_held, r.strongest, felt, p.text.c_str());
  std::fflush(stdout);
}

}  // namespace

void measureThinPresses(int presses, int first) {
  ThinWorst worst;
  for (int i = first; i < first + presses; ++i) {
    const scenes::ThinPress p = scenes::ThinPresses(static_cast<unsigned>(i)).press();
    try {
      add(p, i, worst);
    } catch (const SetupError& error) {
      std::printf("thin %d refused: %s\n", i, error.what());
      ++worst.refused;
    }
  }
  std::printf("%d thin presses, %d refused, %d not finite; %d ring (%d direct), %d jump, %d give energy, %d are felt less\n", worst.done,
              worst.refused, worst.infinite, worst.rings, worst.rings_direct, worst.jumps, worst.gives, worst.felt_less);
  figure("hand.thin.rings", worst.rings, "1");
  figure("hand.thin.energy_given_j_max", worst.given, "J");
  figure("hand.thin.energy_given_direct_j_max", worst.given_direct, "J");
  figure("hand.thin.energy_given_less_motion_j_max", worst.moving, "J");
  figure("hand.thin.energy_given_less_motion_direct_j_max", worst.moving_direct, "J");
  figure("hand.thin.energy_given_beyond_held_j_max", worst.held, "J");
  figure("hand.thin.jump_over_stiffness_n", worst.jump, "N");
  figure("hand.thin.check_says_pass_and_rings", worst.passed_and_rang, "1");
  figure("hand.thin.felt_share_min", worst.felt, "1");
  figure("hand.false_reduced", worst.doubted, "1");
  figure("hand.thin.softened_pct", 100.0 * worst.softened / std::max(1, worst.done), "%");
}

}  // namespace haptic::bench
