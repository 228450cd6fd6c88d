/// Contacts only press: 2000 cards, plates, needles and prisms are dropped on ground that is smooth or rough by micrometres, at 1e8 to
/// 1e14 N/m³.
///
/// Of each run: whether a reported normal force pulls by more than 1e-9 of the largest, and whether the world stopped. Of each step:
/// whether the contacts miss m a of the states by more than 1 % of the largest force, and no flag says so.
#include <algorithm>
#include <cmath>

#include "../scenes/drops.h"
#include "../scenes/reported_force.h"
#include "figure.h"
#include "right_figures.h"

namespace haptic::bench {
namespace {

using namespace scenes;

constexpr int kDrops = 2000, kSteps = 300;

}  // namespace

void runDrops() {
  double pulls = 0, unbalanced = 0, stopped = 0, unconverged = 0, steps = 0;
  for (int seed = 0; seed < kDrops; ++seed) {
    const WorldDef def = drop(seed);
    World world(def);
    const double mass = def.articulations[1].links[0].inertia.mass, h = def.settings.step;
    double largest = mass * kGravity, lowest = 0;
    int off = 0;
    for (int i = 0; i < kSteps; ++i) {
      const Eigen::Map<const Vector3> v(world.v().data() + 3);
      const Vector3 before = v;
      world.step();
      if (world.report().flags & kRunaway || !world.report().finite) {
        ++stopped;
        break;
      }
      ++steps;
      for (int c = 0; c < world.contactCount(); ++c) {
        largest = std::max(largest, world.contact(c).normal_force);
        lowest = std::min(lowest, world.contact(c).normal_force);
      }
      unconverged += (world.report().flags & kNotConverged) != 0;
      const Vector3 missed = mass * ((v - before) / h + Vector3(0, 0, kGravity)) - reportedForceOn(world, 1);
      off += world.report().flags == 0 && missed.norm() > 0.01 * largest;
    }
    pulls += lowest < -1e-9 * largest;
    unbalanced += off;
    if (lowest < -1e-9 * largest || off > 0) {
      std::fprintf(stderr, "  drop %d: lowest %.3g N, largest %.3g N, off in %d\n", seed, lowest, largest, off);
    }
  }
  figure("contact.drops", kDrops, "1");
  figure("contact.pulls", pulls, "1");
  figure("contact.stopped_worlds", stopped, "1");
  figure("contact.unbalanced_steps", unbalanced, "1");
  figure("contact.unconverged_share", unconverged / steps, "1");
}

}  // namespace haptic::bench
