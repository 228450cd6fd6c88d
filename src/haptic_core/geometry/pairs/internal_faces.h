/// Where the convex pieces of one body touch one another: parts of their faces that are no surface of the body.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/volume/contact_volume.h"

namespace haptic {

/// A convex piece of a body, in the body's frame. A round one has no faces.
struct PlacedPiece {
  const ConvexShape* shape;  ///< the caller's
  Pose X_BS;                 ///< where it lies in the body
};

/// Which faces the convex pieces of one body hide from the outside.
struct InternalFaces {
  std::vector<InnerFaces> inner;                ///< by piece: what its neighbours cover
  /// By piece and face: faces of neighbouring pieces that continue one another, without a bend, have one number; −1: no
  /// neighbour continues it. Empty: of no face. Other surfaces of a piece and of its neighbours have other numbers, from 0 on; one
  /// farther away may have the same.
  std::vector<std::vector<int>> surface;
  std::vector<std::pair<int, int>> neighbours;  ///< pieces that share area, first < second, ascending
};

/// Faces of different pieces that face one another, across a gap or a lap of at most kSeam of the thinner piece's width, on more than
/// kShared of the smaller face's area. Whether a contact takes them for one depends on its depth (InnerFaces::Cover). Cost O(n log n)
/// pieces, and all face pairs of those that touch; at load.
InternalFaces internalFaces(const std::vector<PlacedPiece>& pieces);

/// Gap or lap that counts as none, or as one plane, relative to the larger piece; and the tilt of one plane [rad].
constexpr double kJoint = 1e-6;
constexpr double kSeam = 0.01;    ///< widest gap or lap, over the width of the thinner piece; and the tilt of two walls [rad]
constexpr double kShared = 1e-6;  ///< share of the smaller face's area from which two faces count as touching

}  // namespace haptic
