#include "haptic_core/stepping/stage_reference.h"

#include <algorithm>

#include "haptic_core/dynamics/joint_space_inertia.h"
#include "haptic_core/world/applied_wrench.h"
#include "haptic_core/world/counted_work.h"

namespace haptic::stepping {
namespace {

/// Places the trees that moved at the end of the stage.
void placeAtEnd(const Model& model, double g, ImplicitStage& stage) noexcept {
  for (int n = 0; n < stage.island.tree_count; ++n) {
    const int t = stage.island.trees[n];
    if (!stage.reference.moved[t]) continue;
    const ModelTree& tree = model.trees[t];
    double* q = stage.places.q.data() + tree.q;
    std::copy_n(stage.base.q.begin() + tree.q, tree.model->nq(), q);
    integratePositions(*tree.model, q, stage.v.data() + tree.v, g);
    placeInStage(model, t, stage.v, stage.places);
  }
}

/// v less the last reference's, or v, into `difference`: whether a pair may get too deep on that way. Then the last reference is noted.
bool mayGetDeep(const Model& model, const State& state, double g, ImplicitStage& stage) noexcept {
  const Island& island = stage.island;
  const std::vector<double>& v_reference = stage.problem.reference();
  const bool first = stage.reference.first;
  eachVelocity(model, island, [&](int i) { stage.difference[i] = first ? stage.v[i] : stage.v[i] - v_reference[i]; });
  if (!stage.limit.mayBePassed(island, state, stage.difference.data(), g)) return false;
  StagePlaces& places = stage.places;
  for (int n = 0; n < island.tree_count; ++n) {
    const int t = island.trees[n];
    const ModelTree& tree = model.trees[t];
    if (first) {
      std::copy_n(stage.base.q.begin() + tree.q, tree.model->nq(), places.q.begin() + tree.q);
      placeInStage(model, t, stage.v, places);
    }
    stage.limit.note(places.X_WS.data(), tree.shape, tree.shape_end);
  }
  return true;
}

/// Freezes inertia and residual of a tree at v.
void freezeTree(const Model& model, int t, double g, ImplicitStage& stage) noexcept {
  const ModelTree& tree = model.trees[t];
  const int nv = tree.model->nv();
  std::vector<double>&v_dot = stage.difference, &residual = stage.residual;
  for (int i = tree.v; i < tree.v + nv; ++i) v_dot[i] = (stage.v[i] - stage.base.v[i]) / g;
  inverseDynamics(*tree.model, model.settings.gravity, v_dot.data() + tree.v, stage.places.link.data() + tree.link,
                  residual.data() + tree.v);
  for (int i = tree.v; i < tree.v + nv; ++i) residual[i] *= g;
  stage.problem.freezeTree(t, stage.v.data(), residual.data());
  stage.reference.tree_energy[t] = energyOf(model, t, stage.places);
}

}  // namespace

void placeHeld(const Model& model, const State& state, double left, HeldLinks& held, StagePlaces& places) noexcept {
  held.left = left;
  for (int link = 0; link < static_cast<int>(held.by.size()); ++link) {
    const int lead = held.by[link];
    if (lead < 0) continue;
    const int t = model.links[link].articulation;
    const ModelTree& tree = model.trees[t];
    const double *end = state.q.data() + tree.q, back = left / held.step;
    const Quaternion q_end(end[3], end[4], end[5], end[6]);
    const Quaternion q = rotationFromVector(-back * held.way[lead].angular) * q_end;
    const Vector3 p_LC = tree.model->link(0).p_LO;
    // To the last bit the end's where nothing is left: an island before may have been solved in parts, and must not be felt by this one.
    const Vector3 p = Vector3(end[0], end[1], end[2]) + ((q * p_LC - q_end * p_LC) - back * held.way[lead].linear);
    const double pose[7] = {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()};
    std::copy_n(pose, 7, places.q.begin() + tree.q);
    placeInStage(model, t, state.v, places);
  }
}

void evaluate(const Model& model, State& state, double g, bool may_limit, ImplicitStage& stage) noexcept {
  const Island& island = stage.island;
  std::vector<char>& moved = stage.reference.moved;
  StagePlaces& places = stage.places;
  stage.evaluations += island.pair_count > 0 ? 1 : 0;
  const bool looks = may_limit && mayGetDeep(model, state, g, stage);
  placeAtEnd(model, g, stage);
  const double share = looks ? stage.limit.share(island, state, places.X_WS.data(), stage.difference.data(), g, stage.reference.first) : 1;
  if (share < 1) {
    stage.result.limited = true;
    eachVelocity(model, island, [&](int i) { stage.v[i] -= (1 - share) * stage.difference[i]; });
    for (int n = 0; n < island.tree_count; ++n) moved[island.trees[n]] = 1;
    placeAtEnd(model, g, stage);
  }
  stage.reference.first = false;
  if (!stage.problem.forces.empty()) freezeForces(model, moved, g, stage.held.left, places.link.data(), stage.problem, stage.forces);
  for (int n = 0; n < island.tree_count; ++n) {
    if (moved[island.trees[n]]) addWrenches(model, state, island.trees[n], places.link.data());
  }
  for (int n = 0; n < island.tree_count; ++n) {
    if (moved[island.trees[n]]) freezeTree(model, island.trees[n], g, stage);
  }
  stage.units += units::kLink * stage.links + stage.contacts.evaluate(moved, stage.pass.tolerance, stage.pass.changed);
}

void forgetContacts(double g, ImplicitStage& stage) noexcept {
  stage.contacts.clear(stage.base.memory.data(), stage.base.yielding.data(), g, stage.base.run, stage.base.since);
  stage.pass.changed = 0;
}

void measureSinceReference(const Model& model, ImplicitStage& stage) noexcept {
  const std::vector<double>& v_reference = stage.problem.reference();
  eachVelocity(model, stage.island, [&](int i) { stage.since_reference[i] = stage.v[i] - v_reference[i]; });
}

void carryToEnd(const Model& model, double g, ImplicitStage& stage) noexcept {
  measureSinceReference(model, stage);
  const double* u = stage.since_reference.data();
  stage.contacts.finish(u, stage.held);
  carryForces(stage.problem, stage.held, stage.places.link.data(), g, u, stage.forces);
}

double energyOf(const Model& model, int t, const StagePlaces& places) noexcept {
  const ModelTree& tree = model.trees[t];
  const LinkWork* link = places.link.data() + tree.link;
  return kineticEnergy(*tree.model, link) + potentialEnergy(*tree.model, link, model.settings.gravity);
}

}  // namespace haptic::stepping
