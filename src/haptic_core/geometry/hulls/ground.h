/// Ground: a surface that is seen from above, and all that lies under it.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/shapes/mass_properties.h"

namespace haptic {

/// Heights over the corners of a grid, which is centred on the origin. Rows lie as on a page seen from above: the first one at +y.
struct HeightGrid {
  int rows = 0, columns = 0;    ///< corners along −y and along x, at least 2 each
  Vector2 size = Vector2::Zero();  ///< along x and y, from the first corner to the last [m]
  std::vector<double> heights;  ///< of corner (row, column) at row · columns + column [m]
};

/// Two triangles for each cell, cut from the corner at −x, −y to that at +x, +y. Throws SetupError, naming `name`: fewer than 2 × 2
/// heights, a size that is not > 0, a height that is not finite.
TriangleMesh surfaceOf(const HeightGrid& grid, const std::string& name);

/// What became of a surface.
struct GroundReport {
  int triangles = 0, pieces = 0;       ///< that look up; convex solids
  double lowest = 0, highest = 0;      ///< points of the surface, along z [m]
  double base = 0;                     ///< z of the solid's lower side [m]
};

/// The solid between a surface and the plane that lies `thickness` [m] under its lowest point, as convex pieces that share their
/// upright walls and overlap nowhere: the prism under a triangle, or under as many triangles of one plane as are convex together.
/// Exact: the pieces' upper sides are the triangles. A contact of the ground is the sum over its pieces; `internalFaces` finds their
/// walls, which press nothing. Upright triangles are dropped, for the walls above lower neighbours stand for them. Throws SetupError
/// that names `name` and the triangle: one looks down, two lie over one another, a corner is not finite, `thickness` is not > 0, no
/// triangle looks up, more than kMostPieces pieces. Cost O(n log n); 20 000 triangles take some tenths of a second.
std::vector<std::shared_ptr<const ConvexShape>> groundPieces(const TriangleMesh& surface, double thickness, const std::string& name,
                                                             GroundReport& report);

/// A world of more takes gigabytes and a minute to load.
constexpr int kMostPieces = 100000;

}  // namespace haptic
