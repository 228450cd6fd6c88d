/// Where links, shapes and their boxes are: filled from the state, read by every stage after.
#pragma once
#include <vector>

#include "haptic_core/dynamics/kinematics.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// Where links, shapes and boxes are at one instant.
struct Placement {
  std::vector<LinkWork> link;                 ///< by world link index; wrenches on links are gathered here
  std::vector<Pose> X_WS;                     ///< by shape
  std::vector<ConvexShape::Box> box;     ///< by shape, in W
  /// A sphere about a shape, in W.
  struct Sphere {
    Vector3 centre = Vector3::Zero();  ///< [m]
    double radius = 0;                 ///< [m]
  };
  std::vector<Sphere> sphere;            ///< by shape; of a ball its surface

  /// Set-up; `placeAll` fills it.
  explicit Placement(const Model& model)
      : link(model.links.size()), X_WS(model.shapes.size()), box(model.shapes.size()), sphere(model.shapes.size()) {}
  /// The spheres about two shapes prove that they have no point in common.
  bool areApart(int shape_a, int shape_b) const noexcept {
    const Sphere &a = sphere[shape_a], &b = sphere[shape_b];
    const double reach = a.radius + b.radius;
    return (b.centre - a.centre).squaredNorm() > reach * reach;
  }
};

/// (in realtime) Kinematics of one tree, for the state's q and v; clears the wrenches on its links.
inline void placeTree(const ModelTree& tree, const State& state, Placement& placement) noexcept {
  forwardKinematics(*tree.model, state.q.data() + tree.q, state.v.data() + tree.v, placement.link.data() + tree.link);
}

/// (in realtime) Kinematics of these trees.
void placeTrees(const Model& model, const std::vector<int>& trees, const State& state, Placement& placement) noexcept;

/// (in realtime) Pose, box and sphere of a shape from its link; these are widened by `margin` [m] on all sides.
void placeShape(const Model& model, int shape, double margin, Placement& placement) noexcept;

/// Everything once, what never moves included: at load and after a restore.
void placeAll(const Model& model, const State& state, Placement& placement) noexcept;

}  // namespace haptic
