#include "haptic_core/stepping/implicit_stage.h"

#include <algorithm>

namespace haptic::stepping {

ImplicitStage::ImplicitStage(const Model& model)
    : forces(model), joints(model), problem(model), contacts(model, problem), limit(model, problem, contacts) {
  for (auto* positions : {&base.q, &places.q}) positions->resize(model.nq);
  for (auto* velocities : {&base.v, &v, &since_reference, &residual, &difference, &pass.calm}) velocities->resize(model.nv);
  base.memory.resize(model.pair_capacity);
  base.yielding.resize(model.pair_capacity);
  reference.tree_energy.resize(model.trees.size());
  reference.moved.resize(model.trees.size());
  held.by.resize(model.links.size());
  places.link.resize(model.links.size());
  places.X_WS.resize(model.shapes.size());
}

void beginStages(const Model& model, State& state, const std::vector<int>& trees, const HandWork& hands, Seams& seams, double h,
                 ImplicitStage& stage) noexcept {
  StagePlaces& places = stage.places;
  stage.contacts.begin(state, {places.link.data(), places.X_WS.data(), stage.held.by.data(), hands.bound.data(), hands.pressed.data()},
                       seams);
  stage.held.way = hands.moved.data();
  stage.held.step = h;
  stage.held.left = 0;
  std::copy(hands.held_by.begin(), hands.held_by.end(), stage.held.by.begin());
  for (std::size_t t = 0; !places.fixed_placed && t < model.trees.size(); ++t) placeInStage(model, static_cast<int>(t), state.v, places);
  places.fixed_placed = true;
  for (const int t : trees) {
    const ModelTree& tree = model.trees[static_cast<std::size_t>(t)];
    std::copy_n(state.q.begin() + tree.q, tree.model->nq(), places.q.begin() + tree.q);
    placeInStage(model, t, state.v, places);
  }
  std::fill(stage.reference.moved.begin(), stage.reference.moved.end(), 0);
  stage.evaluations = stage.iterations = stage.factorisations = 0;
  stage.result = StageResult{};
  stage.island = Island{};  // its arrays may have been filled anew
  stage.problem.forget();
}

void select(const Model& model, const Island& island, ImplicitStage& stage) noexcept {
  stage.island = island;
  stage.has_joints = stage.jointed = false;
  stage.mass = 0;
  stage.links = 0;
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model.trees[island.trees[n]];
    stage.has_joints |= tree.has_laws;
    stage.jointed |= !model.isFree(tree);
    stage.links += tree.model->linkCount();
    for (int l = 0; l < tree.model->linkCount(); ++l) stage.mass += model.links[tree.link + l].mass;
  }
  stage.problem.select(island, stage.places.link.data(), stage.has_joints ? &stage.joints : nullptr);
  selectForces(model, island, stage.held, stage.places.link.data(), stage.problem, stage.forces);
  stage.contacts.select(island);
}

void placeInStage(const Model& model, int t, const std::vector<double>& velocity, StagePlaces& places) noexcept {
  const ModelTree& tree = model.trees[t];
  forwardKinematics(*tree.model, places.q.data() + tree.q, velocity.data() + tree.v, places.link.data() + tree.link);
  for (int s = tree.shape; s < tree.shape_end; ++s) {
    places.X_WS[s] = places.link[model.shapes[s].link].X_WL * model.shapes[s].X_LS;
  }
}

}  // namespace haptic::stepping
