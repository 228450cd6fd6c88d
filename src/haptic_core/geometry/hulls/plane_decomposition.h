/// A concave mesh as convex pieces, by cutting it with planes.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/shapes/mass_properties.h"

namespace haptic {

/// How near the pieces have to come, and how many there may be.
struct DecompositionSettings {
  double tolerance = 1e-3;  ///< a piece whose hull is nowhere farther from the mesh is not cut again [m]
  int max_pieces = 32;      ///< cutting ends here, the worst piece having been cut first
  /// Triangles that may be hulled in all; cutting ends there. A count and no time: the same mesh gives the same pieces everywhere.
  double most_work = kMostWork;
  std::function<void(int pieces, double distance)> progress;  ///< called after each cut; empty: no reports

  static constexpr double kMostWork = 1e7;  ///< about ten seconds of one core
};

/// How near the pieces of a decomposition came to their mesh.
struct DecompositionReport {
  double distance = 0;  ///< largest distance of a piece's hull from the mesh [m]; above the tolerance when
                        ///< max_pieces or most_work ended the cutting
  bool unfinished = false;  ///< most_work ended it
};

/// Cuts the part whose hull is farthest from the surface by the plane that leaves the least volume in the
/// hulls of both sides, until all are within the tolerance; then joins neighbours whose common hull adds
/// nothing. A side is the hull of the surface on it and of the cut, so every point of the solid lies in a
/// piece. The mesh may be open; the result then stands for the hull of its triangles. Deterministic. Planes are compared on
/// kCompared triangles of the part, evenly chosen; cost: about 24 hulls of those and two of the part per cut. Throws
/// SetupError when not even the first hull exists.
///
/// Two libraries were measured first (Debian's bullet-extras 3.24) on a hollow bracket of 33 cm³: HACD
/// clusters the surface, and up to 12 of 73 clusters were flat sheets without volume, with nothing behind
/// them; ConvexDecomposition gave back the whole hull, 96 cm³.
std::vector<std::shared_ptr<const ConvexPolyhedron>> cutIntoConvexPieces(
    const TriangleMesh& mesh, const DecompositionSettings& settings, const std::string& name,
    DecompositionReport& report);

}  // namespace haptic
