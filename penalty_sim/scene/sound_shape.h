/// The nearest solid that stands for points without volume, or whose hull is refused.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic {

inline constexpr double kSlabThickness = 1e-3;  ///< of what is flat [m]: a hand feels it, an eye hardly sees it
inline constexpr double kSlabShare = 0.1;       ///< of its longest side at most, for what is smaller than 10 mm

/// Whether the points lie in one plane, to the steps of their own numbers (float32, 1e-7 of the largest, four of them). Cost: O(n).
bool isFlat(const std::vector<Vector3>& points);

/// A solid and its words, "a slab 1 mm thick".
struct SoundShape {
  std::shared_ptr<const ConvexPolyhedron> solid;  ///< never null
  std::string text;                               ///< for people
};

/// Of points in a plane the slab around them, kSlabThickness thick; of others their hull; where there is none the box around them, each
/// side at least as thick as the slab. `points` is not empty and finite. Throws SetupError for coordinates that overflow.
SoundShape soundShapeOf(const std::vector<Vector3>& points, const std::string& name);

}  // namespace haptic
