/// Where links, shapes and their boxes are: filled from the state, read by every stage after.
#pragma once
#include <vector>

#include "haptic_core/dynamics/kinematics.h"
#include "haptic_core/geometry/convex_polyhedron.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// Where links, shapes and boxes are at one instant.
struct Placement {
  std::vector<LinkWork> link;                 ///< by world link index; wrenches on links are gathered here
  std::vector<Pose> X_WS;                     ///< by shape
  std::vector<ConvexShape::Box> box;     ///< by shape, in W

  /// Set-up; `placeAll` fills it.
  explicit Placement(const Model& model)
      : link(model.links.size()), X_WS(model.shapes.size()), box(model.shapes.size()) {}
};

/// (in realtime) Kinematics of one tree, for the state's q and v; clears the wrenches on its links.
inline void placeTree(const ModelTree& tree, const State& state, Placement& placement) noexcept {
  forwardKinematics(*tree.model, state.q.data() + tree.q, state.v.data() + tree.v, placement.link.data() + tree.link);
}

/// (in realtime) Kinematics of the trees that can have moved.
void placeTrees(const Model& model, const State& state, Placement& placement) noexcept;

/// (in realtime) Pose and box of a shape from its link; the box is widened by `margin` [m] on all sides.
void placeShape(const Model& model, int shape, double margin, Placement& placement) noexcept;

/// Everything once, what never moves included: at load and after a restore.
void placeAll(const Model& model, const State& state, Placement& placement) noexcept;

}  // namespace haptic
