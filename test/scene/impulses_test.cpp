// What a step reports of contacts and hands is what moved the bodies, in every shipped scene.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "../scenes/reported_force.h"
#include "../scenes/shipped_scenes.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/work.h"

namespace haptic {
namespace impulses_test {

/// Trees of one free body.
std::vector<int> freeBodies(const Model& model) {
  std::vector<int> trees;
  for (int t = 0; t < static_cast<int>(model.trees.size()); ++t) {
    if (model.isFree(model.trees[static_cast<std::size_t>(t)])) trees.push_back(t);
  }
  return trees;
}

/// Of the centre of mass [m/s].
Vector3 velocityOf(const World& world, int link) {
  const LinkWork& work = world.work().placement.link[static_cast<std::size_t>(link)];
  return work.twistAt(work.p_WC()).linear;
}

/// Of contacts and couplings on a link, as they are reported: mean over the step [N].
Vector3 forceOn(const World& world, int link) {
  Vector3 F = scenes::reportedForceOn(world, link);
  for (int p = 0; p < world.pointerCount(); ++p) {
    if (world.pointerLink(p) == link) F -= world.pointerWrench(p).force;
  }
  return F;
}

/// How far the work of the impulses of a step may be from the change of the kinetic energy [1]: roundings of some ten additions, of the
/// largest energy that a body of the scene exchanged in a step, or that falling for a step gives it, whichever is more.
constexpr double kRounding = 1e-12;

// Σ impulse × mean velocity = Δ ½ m v² of every free body in every step, of motion along W. (Of turns it is no identity: I_W turns with the
// body.) Left out: steps in which an island is brought to rest, whose motion is booked as stilled.
TEST(Impulses, AreTheChangeOfKineticEnergyInShippedScenes) {
  constexpr int kSteps = 600;
  const auto all = scenes::shippedScenes(HAPTIC_SCENES);
  ASSERT_GT(all.size(), 20u);
  int compared = 0;
  for (const scenes::ShippedScene& scene : all) {
    World world(scene.def.world);
    const Model& model = world.model();
    const std::vector<int> bodies = freeBodies(model);
    const double h = world.settings().step;
    const Vector3 g = world.settings().gravity;
    std::vector<Vector3> before;
    for (const int t : bodies) before.push_back(velocityOf(world, model.trees[t].link));
    double worst = 0, largest = 0;
    for (int i = 0; i < kSteps && world.report().finite; ++i) {
      const double stilled = world.report().energy.stilled;
      followPaths(scene.def, world);
      world.step();
      const bool brought_to_rest = world.report().energy.stilled != stilled;
      for (std::size_t n = 0; n < bodies.size(); ++n) {
        const int link = model.trees[bodies[n]].link;
        const Vector3 v = velocityOf(world, link), was = before[n];
        before[n] = v;
        if (brought_to_rest || !world.work().hands.movesByItself(model.trees[bodies[n]])) continue;
        const double m = model.links[link].mass, gained = 0.5 * m * (v.squaredNorm() - was.squaredNorm());
        const double work = h * (forceOn(world, link) + m * g).dot(0.5 * (v + was));
        worst = std::max(worst, std::abs(gained - work));
        largest = std::max({largest, std::abs(gained), 0.5 * m * h * h * g.squaredNorm()});
        ++compared;
      }
    }
    EXPECT_LE(worst, kRounding * largest) << scene.name;
  }
  EXPECT_GT(compared, 10000);
}

}  // namespace impulses_test
}  // namespace haptic
