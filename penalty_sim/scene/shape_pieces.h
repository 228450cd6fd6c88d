/// What one URDF collision becomes.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/geometry/shapes/convex_shape.h"
#include "haptic_core/geometry/shapes/mass_properties.h"

namespace haptic {

/// One URDF collision: its convex pieces, all in the collision's own frame.
struct ShapePieces {
  /// One or more, unless the collision is left out; shared with other collisions of the same mesh.
  std::vector<std::shared_ptr<const ConvexShape>> pieces;
  std::string text;  ///< "box 0.1 × 0.1 × 0.1 m", "mesh link0.stl: hull, 0.3 mm from the mesh, 124 vertices"
  double half_extent = 0;  ///< half of the shortest side of the box around all pieces [m]
  std::string fixed_only;  ///< why its link must be fixed to the world, "a half-space, which has no end"; empty: it may move
  std::string replaced;    ///< why, and by what, when it is not what the file has; empty: it is
  std::string to_mend;     ///< how far its surface is from the file's, where that is more than was asked, and what is odd in a mesh's file
  TriangleMesh picture;    ///< of ground, in the collision's frame, for links without <visual>; empty: none
};

/// Fills in half_extent from the pieces.
void measure(ShapePieces& shape);

}  // namespace haptic
