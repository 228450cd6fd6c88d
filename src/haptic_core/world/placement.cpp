#include "haptic_core/world/placement.h"

namespace haptic {

void placeTrees(const Model& model, const std::vector<int>& trees, const State& state, Placement& placement) noexcept {
  for (const int t : trees) placeTree(model.trees[t], state, placement);
}

void placeShape(const Model& model, int s, double margin, Placement& placement) noexcept {
  const ModelShape& shape = model.shapes[s];
  placement.X_WS[s] = placement.link[shape.link].X_WL * shape.X_LS;
  placement.box[s] = shape.shape->aabb(placement.X_WS[s]);
  placement.sphere[s] = {placement.X_WS[s] * shape.shape->centre(), shape.shape->boundingRadius() + margin};
  if (!(margin > 0)) return;
  placement.box[s].lower.array() -= margin;
  placement.box[s].upper.array() += margin;
}

void placeAll(const Model& model, const State& state, Placement& placement) noexcept {
  for (const ModelTree& tree : model.trees) placeTree(tree, state, placement);
  for (int s = 0; s < static_cast<int>(model.shapes.size()); ++s) placeShape(model, s, 0, placement);
}

}  // namespace haptic
