#include "haptic_core/stepping/stage_passes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/stepping/stage_energy.h"
#include "haptic_core/stepping/rest.h"

namespace haptic::stepping {
namespace {

/// Changes that shrink no more, but are this small already, are rounding in a stiff contact.
constexpr double kStagnation = 1e-9;
/// Newton steps of a pass at most. Passes contract by 5–20 each, so that more passes beat longer passes; but a deep corner or edge, whose
/// force falls with the square of its depth, opens by a half in each Newton step.
constexpr int kStepsOfPass = 8;
/// Without contacts a pass costs little, and there is nothing that ends it but rounding: share of the
/// tolerance then.
constexpr double kContactFree = 1e-8;
constexpr int kContactFreePasses = 3,
              kAlonePasses = 7;  ///< alone: not even a pair is near, no geometry is asked
/// Weight of what gravity adds to speeds in a step, beside the change of the step: what lies has no change,
/// and must come to rest all the same. With 1, a dropped cube still moves by 1e-7 m after a second.
constexpr double kFree = 1e-2;
/// Way, as a share of the smallest body's size, that the error of a step may amount to.
constexpr double kOfSize = 1e-4;

/// Largest speed by which v differs from `since`; the difference is left in `difference`.
double changeSince(const Model& model, const std::vector<double>& since, ImplicitStage& stage) noexcept {
  eachVelocity(model, stage.island, [&](int i) { stage.difference[i] = stage.v[i] - since[i]; });
  return stage.speed(stage.difference);
}

/// Largest distance of a moving body's parts from W's origin [m].
double farthest(const Model& model, const ImplicitStage& stage) noexcept {
  double largest = 0;
  for (int n = 0; n < stage.island.tree_count; ++n) {
    const int link = model.trees[stage.island.trees[n]].link;
    largest = std::max(largest, stage.places.link[link].p_WO.norm() + model.links[link].size);
  }
  return largest;
}

/// Size of the island's smallest body [m].
double smallestSize(const Model& model, const Island& island) noexcept {
  double smallest = std::numeric_limits<double>::infinity();
  for (int n = 0; n < island.tree_count; ++n) smallest = std::min(smallest, model.links[model.trees[island.trees[n]].link].size);
  return smallest;
}

/// Keeps v where no reference had less energy so far.
void noteCalm(const Model& model, double g, ImplicitStage& stage) noexcept {
  const double now = energyAtReference(stage) - supplyAtReference(stage, g);
  if (!(now <= stage.pass.calm_energy)) return;
  stage.pass.calm_energy = now;
  eachVelocity(model, stage.island, [&](int i) { stage.pass.calm[i] = stage.v[i]; });
}

/// True if another evaluation would agree with the last prediction: the pass ended at its solution, all patches stay valid, and no
/// gap closes. Bodies on joints turn more than that: they are always looked at again.
bool holds(const ImplicitStage& stage, const PassEnd& end) noexcept {
  const StageTolerance& tolerance = stage.pass.tolerance;
  if (stage.jointed || stage.contacts.all().empty()) return false;
  if (stage.forces.any && bends(stage.problem, stage.forces)) return false;
  if (end.remainder > kStays * tolerance.speed) return false;
  if (end.energy_remainder > kStays * tolerance.energy) return false;
  return stage.contacts.hold(tolerance, stage.since_reference.data());
}

}  // namespace

void startStage(const Model& model, const State& state, double g, double left, ImplicitStage& stage) noexcept {
  if (left != stage.held.left) placeHeld(model, state, left, stage.held, stage.places);
  if (stage.has_joints) stage.joints.startStage(state, stage.base.q.data(), g, stage.v.data());
  forgetContacts(g, stage);
  stage.reference.first = true;
  stage.result.limited = false;
  for (int n = 0; n < stage.island.tree_count; ++n) stage.reference.moved[stage.island.trees[n]] = 1;
  stage.pass.calm_energy = std::numeric_limits<double>::infinity();
}

bool iterate(const Model& model, State& state, double g, int most_passes, ImplicitStage& stage) noexcept {
  const WorldSettings& settings = model.settings;
  const Island& island = stage.island;
  FrozenProblem& problem = stage.problem;
  StageTolerance& tolerance = stage.pass.tolerance;
  const double of_gravity = kFree * g * settings.gravity.norm(), smallest = smallestSize(model, island);
  double last = 0;
  bool converged = false;
  tolerance = {settings.tolerance * kFree * g * settings.gravity.norm(), 0};
  if (stage.contacts.all().empty())
    most_passes = std::max(most_passes, island.pair_count == 0 || stage.forces.any ? kAlonePasses : kContactFreePasses);
  for (int pass = 0; pass < most_passes && !converged; ++pass) {
    if (pass >= kFewestPasses && stage.isSpent()) break;
    if (pass > 0) evaluate(model, state, g, true, stage);
    noteCalm(model, g, stage);
    std::vector<double>& before = stage.since_reference;  // until the pass has been solved
    eachVelocity(model, island, [&](int i) { before[i] = stage.v[i]; });
    const double fine = finest(model, stage, g);
    const int steps = stage.isSpent() ? 1 : kStepsOfPass;
    const PassEnd end =
        problem.solve(g, steps, fine, kStays * tolerance.speed, stage.reference.moved, stage.places.q.data(), stage.v.data());
    stage.iterations += end.iterations;
    stage.factorisations += end.factorisations;
    stage.units += end.units;
    if (!end.solved) break;
    const double changed = changeSince(model, before, stage);
    if (!std::isfinite(changed)) break;
    // A body of a micrometre falls through itself in a time that is nothing to one of a metre.
    const double least = std::min(of_gravity, kOfSize * smallest / g);
    const double share = settings.tolerance * (stage.contacts.all().empty() ? kContactFree : 1.0);
    const double of_step = changeSince(model, stage.base.v, stage);
    measureSinceReference(model, stage);
    tolerance.speed = std::max(fine, std::min(share * (least + of_step), kOfSize * smallest / g));
    const double rate = pass > 0 ? changed / last : 1;
    stage.result.error = std::max(end.remainder, rate < 0.5 ? changed * rate / (1 - rate) : changed);
    stage.result.wrench_error = end.imbalance * std::min(1.0, rate);
    // Where stiffness is high a small error of v is a large one of the energy. Twice the possible gain of the pass
    // at its reference, -R·p, is known exactly; the end of the pass is no reference yet.
    const double of_speeds = problem.massNorm2(stage.difference.data());
    tolerance.energy = settings.tolerance * (of_speeds + stage.mass * least * least);
    const bool harmless = end.decrement <= tolerance.energy;
    converged = changed <= fine || holds(stage, end) || (stage.result.error <= tolerance.speed && harmless) ||
                (rate >= 0.5 && changed <= kStagnation * stage.speed(stage.v));
    last = stage.pass.changed = changed;
    for (int n = 0; n < island.tree_count; ++n) {
      const int t = island.trees[n];
      stage.reference.moved[t] =
          end.remainder > tolerance.speed || problem.speedOf(t, stage.since_reference.data()) > std::max(fine, kStays * tolerance.speed);
    }
  }
  carryToEnd(model, g, stage);
  return converged;
}

double finest(const Model& model, const ImplicitStage& stage, double g) noexcept {
  return roundingSpeed(stage.speed(stage.v) + model.settings.gravity.norm() * g, farthest(model, stage), g);
}

}  // namespace haptic::stepping
