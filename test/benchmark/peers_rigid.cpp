// How deep bodies rest in surfaces that are said to be rigid, and what their steps cost beside those of the scenes as published.
#include <algorithm>
#include <cmath>
#include <random>

#include "../scenes/shipped_scenes.h"
#include "figure.h"
#include "haptic_core/base/cpu_time.h"
#include "peers_figures.h"
#include "random_stack.h"

namespace haptic::bench {
namespace {

constexpr int kStacks = 200;
constexpr char kSaysRigid[] = "<haptic:contact stiffness=\"rigid\"/>";

/// Least extent of the one collision of each link [m].
std::vector<double> extentsOf(const WorldDef& def) {
  std::vector<double> extents;
  for (const ArticulationDef& tree : def.articulations) {
    for (const LinkDef& link : tree.links) {
      const auto box = link.collisions.empty() ? ConvexShape::Box{} : link.collisions[0].shape->aabb();
      extents.push_back(link.collisions.empty() ? INFINITY : (box.upper - box.lower).minCoeff());
    }
  }
  return extents;
}

/// Steps of both scenes by turns, with their hands; the median of the ratios of blocks.
double costRatio(const SceneDef& rigid, const SceneDef& soft, double& rigid_us, double& soft_us, bool& finite) {
  constexpr int kBlocks = 40, kBlock = 50;
  World worlds[] = {World(rigid.world), World(soft.world)};
  const SceneDef* const scenes[] = {&rigid, &soft};
  double total[2] = {0, 0};
  for (int block = 0; block < kBlocks; ++block) {
    for (int which = 0; which < 2; ++which) {
      const double before = cpuSeconds();
      for (int i = 0; i < kBlock; ++i) {
        followPaths(*scenes[which], worlds[which]);
        worlds[which].step();
      }
      total[which] += cpuSeconds() - before;
    }
  }
  rigid_us = 1e6 * total[0] / (kBlocks * kBlock), soft_us = 1e6 * total[1] / (kBlocks * kBlock);
  finite = worlds[0].report().finite;
  return total[0] / total[1];
}

}  // namespace

/// The stacks of chosen.sink_share_max (bench robots), said to be rigid. Those that the loader warns of (on an edge, or thin under a
/// heavy one) are counted apart, and so are their sinks.
void measureRigidSinks() {
  std::mt19937 random(1);
  double worst = 0, worst_warned = 0;
  int warned = 0, settled = 0, unconverged = 0, stuck = 0, launched = 0;
  // Stuck: more than a hundred steps did not converge. Launched: faster at the end than after a fall of 1.3 m.
  for (int i = 0; i < kStacks; ++i) {
    SceneOptions options;
    options.add_pointer = false;
    options.text = randomStack(random, kSaysRigid);
    const SceneDef scene = loadScene("stack", options);
    const bool told = std::any_of(scene.warnings.begin(), scene.warnings.end(),
                                  [](const std::string& line) { return line.find("of the least extent") != std::string::npos; });
    World world(scene.world);
    int failed = 0;
    for (int s = 0; s < 4000; ++s) {
      world.step();
      failed += (world.report().flags & kNotConverged) != 0;
    }
    unconverged += failed, stuck += failed > 100;
    double way = 0, turn = 0;
    for (int l = 0; l < world.linkCount(); ++l) {
      way = std::max(way, world.linkTwist(l).linear.norm()), turn = std::max(turn, world.linkTwist(l).angular.norm());
    }
    const bool rests = world.report().finite && way < 1e-6 && turn < 1e-5;
    warned += told, settled += rests, launched += !(way < 5);
    if (failed > 0 || !rests) {
      std::printf("peers stack %d of %d bodies: %d steps did not converge; at the end %.2g m/s, %.2g rad/s\n", i, world.linkCount() - 1,
                  failed, way, turn);
    }
    if (!rests) continue;
    const std::vector<double> extent = extentsOf(scene.world);
    double deepest = 0;
    for (int c = 0; c < world.contactCount(); ++c) {
      const ContactReport& contact = world.contact(c);
      deepest = std::max(deepest, contact.depth / std::min(extent[contact.link_a], extent[contact.link_b]));
    }
    double& most = told ? worst_warned : worst;
    most = std::max(most, deepest);
    if (!told && deepest > 1e-6) std::printf("peers stack %d: %.3g of the least extent deep, without a warning\n", i, deepest);
  }
  figure("stiff_rigid.stacks", kStacks, "1");
  figure("stiff_rigid.settled", settled, "1");
  figure("stiff_rigid.warned", warned, "1");
  figure("stiff_rigid.sink_share_max", worst, "1");
  figure("stiff_rigid.sink_share_warned_max", worst_warned, "1");
  figure("stiff_rigid.unconverged_steps", unconverged, "1");
  figure("stiff_rigid.stacks_not_converging", stuck, "1");
  figure("stiff_rigid.launched", launched, "1");
}

/// 2 s of each, all surfaces but what a hand touches.
void measureRigidTimes() {
  SceneOptions options;
  options.rigid = true;
  const std::string folder = HAPTIC_SOURCE_DIR "/urdf/scenes";
  const auto rigid = scenes::shippedScenes(folder, options), soft = scenes::shippedScenes(folder);
  double sum = 0, worst = 0;
  int count = 0, stopped = 0;
  for (const scenes::ShippedScene& each : rigid) {
    const auto same = std::find_if(soft.begin(), soft.end(), [&](const auto& other) { return other.name == each.name; });
    if (same == soft.end()) continue;
    double rigid_us = 0, soft_us = 0;
    bool finite = true;
    const double ratio = costRatio(each.def, same->def, rigid_us, soft_us, finite);
    std::printf("peers rigid %-24s %9.2f us a step, as published %9.2f us, ratio %.2f%s\n", each.name.c_str(), rigid_us, soft_us, ratio,
                finite ? "" : ", stopped");
    sum += std::log(ratio), worst = std::max(worst, ratio), stopped += !finite, ++count;
  }
  figure("stiff_rigid.scenes", count, "1");
  figure("stiff_rigid.stopped", stopped, "1");
  figure("stiff_rigid.step_over_soft", std::exp(sum / count), "1");
  figure("stiff_rigid.step_over_soft_max", worst, "1");
}

}  // namespace haptic::bench
