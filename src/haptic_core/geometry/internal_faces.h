/// Where the convex pieces of one body touch one another: faces that are no surface of the body.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "haptic_core/geometry/convex_polyhedron.h"

namespace haptic {

/// A convex piece of a body, in the body's frame.
struct PlacedPiece {
  const ConvexPolyhedron* shape;
  Pose X_BS;
};

struct InternalFaces {
  /// For each piece the bits of the faces on which another piece lies (see HiddenFaces); empty: none.
  std::vector<std::vector<std::uint64_t>> hidden;
  std::vector<std::pair<int, int>> neighbours;  ///< pieces that share area, first < second, ascending
};

/// Faces of different pieces that lie against one another, within kJoint of the pieces' size, on more than
/// kShared of the smaller face's area. Cost O(face pairs whose pieces touch); at load.
InternalFaces internalFaces(const std::vector<PlacedPiece>& pieces);

/// Gap or overlap that still counts as lying against, relative to the larger piece; and the tilt [rad].
constexpr double kJoint = 1e-6;
constexpr double kShared = 1e-6;

}  // namespace haptic
