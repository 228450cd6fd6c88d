#include "haptic_core/world/initial_overlap.h"

#include <algorithm>
#include <string>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/half_space.h"

namespace haptic {
namespace {

/// Static bodies may be sunk into one another by this share of the thinner one's width [1]: floors are often modelled so.
constexpr double kStaticOverlap = 0.1;

/// Throws where shapes a < b, which never move, lie deep in one another.
void refuseOverlap(const Model& model, int a, int b, Work& work) {
  const ModelShape &A = model.shapes[a], &B = model.shapes[b];
  if (model.treeOf(a) == model.treeOf(b) || !A.shape->bounded() || !B.shape->bounded()) return;
  ContactVolume volume;
  PairCache cache;
  contactVolume(*A.shape, *B.shape, relativePose(work.placement.X_WS[a], work.placement.X_WS[b]), cache,
                work.contacts.workspace, volume);
  const double allowed = kStaticOverlap * std::min(A.width, B.width);
  if (volume.status != ContactVolume::Status::kOverlap || volume.depth <= allowed) return;
  throw SetupError(model.links[A.link].name,
                   "and " + model.links[B.link].name + " are fixed and overlap by " + std::to_string(1e3 * volume.depth) +
                       " mm: nothing could push them apart",
                   "move one of them, or make them one body");
}

}  // namespace

void refuseStaticOverlaps(const Model& model, Work& work) {
  std::vector<int> near;
  for (const int a : model.fixed_shapes) {
    near.clear();
    model.fixed_boxes.eachOverlap(work.placement.box[a], [&](int fixed) {
      if (model.fixed_shapes[fixed] > a) near.push_back(model.fixed_shapes[fixed]);
    });
    std::sort(near.begin(), near.end());
    for (const int b : near) refuseOverlap(model, a, b, work);
  }
}

void findBuried(const Model& model, int tree, State& state, Work& work) {
  if (model.possible_pairs == 0) return;
  StepReport ignored;
  placeShapes(model, 0, work.visits.shapes, state, work.hands, work.placement);
  findPairs(model, work.visits, work.placement, state, work.search, ignored);
  for (const int i : state.pairs.awake()) {
    ActivePair& pair = state.pairs[i];
    const int a = pair.shapeA(), b = pair.shapeB();
    if (tree >= 0 && model.treeOf(a) != tree && model.treeOf(b) != tree) continue;
    ContactVolume volume;
    PairCache cache;
    contactVolume(*model.shapes[a].shape, *model.shapes[b].shape,
                  relativePose(work.placement.X_WS[a], work.placement.X_WS[b]), cache, work.contacts.workspace, volume);
    pair.buried = volume.status == ContactVolume::Status::kOverlap && volume.depth > model.buriedDepth(a, b, volume.A0);
  }
}

}  // namespace haptic
