/// Mass, centre of mass and inertia of a solid bounded by triangles, convex or not.
#pragma once
#include <array>
#include <vector>

#include "haptic_core/base/spatial.h"

namespace haptic {

/// A closed or open surface of triangles, counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Vector3> vertices;              ///< [m]
  std::vector<std::array<int, 3>> triangles;  ///< indices into `vertices`
};

/// Mass, centre of mass and inertia of a solid.
struct MassProperties {
  double volume = 0;                ///< [m³]; negative when the faces point inwards
  double mass = 0;                  ///< density · volume [kg]
  Vector3 com = Vector3::Zero();    ///< centre of mass in the shape's frame [m]
  Matrix3 I_com = Matrix3::Zero();  ///< inertia about `com`, the shape's axes [kg·m²]
};

/// Of a solid of uniform `density` [kg/m³] bounded by `mesh`. The mesh must be closed; a hole makes the
/// result meaningless (`firstOpenEdge` finds one). Sums over the tetrahedra from one vertex to each triangle,
/// exact for any closed surface; cost O(triangles).
MassProperties massProperties(const TriangleMesh& mesh, double density);

/// A directed edge (from, to) that has no partner in the opposite direction, or {-1, -1} for a closed mesh.
std::array<int, 2> firstOpenEdge(const TriangleMesh& mesh);

}  // namespace haptic
