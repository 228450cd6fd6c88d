#include "haptic_core/analysis/resting_depths.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace {

constexpr double kSlow = 20;        // [1] times the speed of rest: a body that rocks or rolls out so slowly presses as one at rest
constexpr double kFirstLook = 0.2;  // [s]: a body that starts at depth 0 is slow at first where it sinks by micrometres

double fastest(const World& world) {
  double speed = 0;
  for (const double v : world.state().v) speed = std::max(speed, std::abs(v));
  return speed;
}

double speedOf(const World& world, int link) {
  const Twist V = world.linkTwist(link);
  return std::max(V.linear.cwiseAbs().maxCoeff(), V.angular.cwiseAbs().maxCoeff());
}

/// The model's shapes are by link, and its links by tree: where the definition has each.
std::vector<int> definitionOrder(const WorldDef& def, const Model& model) {
  std::vector<std::vector<int>> of_link(model.links.size());
  for (std::size_t s = 0; s < model.shapes.size(); ++s) of_link[model.shapes[s].link].push_back(static_cast<int>(s));
  std::vector<int> index_of(model.shapes.size(), -1);
  int next = 0;
  for (int a = 0; a < static_cast<int>(def.articulations.size()); ++a) {
    for (int l = 0; l < static_cast<int>(def.articulations[a].links.size()); ++l) {
      for (const int shape : of_link[model.link(a, l)]) index_of[shape] = next++;
    }
  }
  return index_of;
}

RestingDepths settle(const WorldDef& def, int steps, double at_rest, SettleBudget* budget) {
  const int first_look = std::max(1, static_cast<int>(kFirstLook / def.settings.step));
  World world(def);
  RestingDepths out;
  for (int i = 0; i < steps && !out.settled && !(budget && budget->spent()); ++i) {
    world.step();
    if (budget) budget->left -= world.report().work;
    if (budget && budget->progress) budget->progress(budget->left);
    if (!world.report().finite) break;
    const bool looks = i >= first_look && i % std::max(1, first_look / 20) == 0;
    out.settled = looks && (world.report().flags & kNotConverged) == 0 && fastest(world) < at_rest;
  }
  const std::vector<int> index_of = definitionOrder(def, world.model());
  for (int i = 0; i < world.contactCount(); ++i) {
    const ContactReport& c = world.contact(i);
    if (std::max(speedOf(world, c.link_a), speedOf(world, c.link_b)) > kSlow * at_rest) continue;
    out.contacts.push_back({index_of[c.shape_a], index_of[c.shape_b], c.depth, c.normal_force});
  }
  return out;
}

}  // namespace

RestingDepths restingDepths(const WorldDef& def, int steps, double at_rest, SettleBudget* budget) {
  WorldDef quiet = def;
  quiet.settings.attempts = Attempts::kImplicitEuler;
  quiet.settings.comparator = nullptr;
  quiet.settings.step = kSettleStep;
  quiet.settings.energy_ledger = false;
  quiet.settings.history_steps = 0;
  return settle(quiet, steps, at_rest, budget);
}

RestingDepths restingDepthsAsRun(const WorldDef& def, double seconds, double at_rest, SettleBudget* budget) {
  WorldDef copy = def;
  copy.settings.history_steps = 0;
  return settle(copy, static_cast<int>(std::lround(seconds / def.settings.step)), at_rest, budget);
}

}  // namespace haptic
