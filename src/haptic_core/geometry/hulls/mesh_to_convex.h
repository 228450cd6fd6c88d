/// A triangle mesh as convex pieces: one hull where the mesh is nearly convex.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/shapes/mass_properties.h"

namespace haptic {

/// How closely convex pieces have to follow their mesh.
struct ConvexSettings {
  double relative_tolerance =
      0.01;  ///< largest distance of mesh and hull, of the mesh's size (longest side of its box)
  double absolute_tolerance = 0.5e-3;  ///< the same [m]; the larger of both counts
  int max_pieces = 32;                 ///< of a decomposition
  bool decompose = true;               ///< split a mesh that is farther from its hull; false: refuse it
  std::function<void(int pieces, double distance)> progress;  ///< of a decomposition, after each cut; empty: no reports
  std::string name = "mesh";           ///< for messages: file or link
};

/// What came of turning a mesh into convex pieces.
struct ConvexReport {
  double hull_distance = 0;  ///< largest distance of the hull's surface from the mesh [m]
  double size = 0;           ///< longest side of the mesh's box [m]
  double mesh_volume = 0;    ///< of the mesh as given; NaN when it is not closed [m³]
  double pieces_volume = 0;  ///< sum over the pieces [m³]
  int pieces = 0;            ///< number of convex pieces
  bool unfinished = false;   ///< a bound on the work ended the cutting before the tolerance was met
  bool decomposed = false;   ///< false: one hull stands for the mesh
};

/// Convex pieces that stand for the mesh, one when it lies within the tolerance of its hull. Throws
/// SetupError for an empty or flat mesh, NaN, or a concave mesh that cannot be or shall not be decomposed.
std::vector<std::shared_ptr<const ConvexPolyhedron>> convexPieces(const TriangleMesh& mesh,
                                                                  const ConvexSettings& settings,
                                                                  ConvexReport& report);

}  // namespace haptic
