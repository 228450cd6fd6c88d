/// What others do for a ball against the same shape, for the benchmark of round things.
#pragma once
#include "haptic_core/geometry/shapes/convex_shape.h"

namespace haptic::bench {

/// ODE's geometries of two shapes, posed once. A half-space is A.
class OdePair {
 public:
  OdePair(const ConvexShape& A, const ConvexShape& B);
  ~OdePair();
  OdePair(const OdePair&) = delete;
  OdePair& operator=(const OdePair&) = delete;
  /// Contact points found; -1 when ODE is not installed.
  int points(const Pose& X_AB);

 private:
  struct Data;
  Data* data_;
};

}  // namespace haptic::bench
