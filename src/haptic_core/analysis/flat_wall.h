/// A convex shape, one of its sides down, pressed into a flat wall that is larger than it.
#pragma once
#include <memory>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic {

constexpr int kHalvings = 50;  ///< of an interval: to rounding

/// Presses one shape into its wall. At set-up: allocates.
class FlatWall {
 public:
  /// `outward`: of the side that goes ahead, in the shape's frame. `shape` is the caller's, and outlives this.
  FlatWall(const ConvexShape& shape, const Vector3& outward);

  double volume(double depth);                   ///< V [m³] at a depth [m]
  /// K [N/m] = k A0 where a foundation of `k` [N/m³] carries `force` [N]; a shape sinks to its middle at most.
  double stiffness(double k, double force);
  /// Force [N] at which a link that a hand holds stays behind it (world/held_proxy.h), where the hand bears `bound` [N/m].
  double carried(double k, double bound);

 private:
  ContactVolume contactAt(double depth);

  const ConvexShape& shape_;
  const ConvexPolyhedron wall_;
  ContactWorkspace workspace_;
  Pose X_WS_;                          ///< the shape about the wall's middle, its side down
  double lowest_ = 0, middle_ = 0;     ///< [m]
};

}  // namespace haptic
