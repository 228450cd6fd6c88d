/// What of one body can take part in a contact: its points, edges and faces near the other body.
#pragma once
#include <cstdint>

#include "haptic_core/geometry/convex_polyhedron.h"
#include "haptic_core/base/lanes.h"
#include "haptic_core/geometry/loaded_vector.h"

namespace haptic {

/// Planes four at a time; a group is filled up with planes that have everything inside.
struct PlaneGroup {
  Lanes nx, ny, nz, offset;

  /// Heights of the point (x, y, z) above the planes.
  Lanes above(const Lanes& x, const Lanes& y, const Lanes& z) const {
    return nx * x + ny * y + nz * z - offset;
  }
};

/// An edge between points and planes of one side.
struct SideEdge {
  int from, to;     ///< points
  int left, right;  ///< planes; as in ConvexPolyhedron::Edge
};

/// Candidates of one body, numbered from 0, all in A's frame. Of point p's `words` codes, bit g is set when it lies
/// outside plane g of the other side. A plane's number is 4 × its group + its lane.
struct ContactSide {
  struct Stamped {
    std::uint32_t epoch = 0;
    int local = 0;
    bool beyond = false;  ///< in the cap
  };

  LoadedVector<Vector3> points;
  LoadedVector<std::uint64_t> codes;  ///< `words` per point
  int words = 1;
  LoadedVector<SideEdge> edges;
  LoadedVector<PlaneGroup> planes;
  LoadedVector<int> faces;                  ///< the body's face, by plane
  LoadedVector<int> point_in_v, face_in_v;  ///< number in V, or -1

  LoadedVector<int> cap;                           ///< vertices of the body beyond the threshold
  LoadedVector<Stamped> vertex_stamp, face_stamp;
  std::uint32_t epoch = 0;

  void reserve(int vertices, int face_count);
};

}  // namespace haptic
