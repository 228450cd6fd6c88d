/// The part of one body that can take part in a contact: its points, edges and faces near the other body.
#pragma once
#include <cstdint>

#include "haptic_core/base/lanes.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/volume/loaded_vector.h"

namespace haptic {

/// Planes four at a time; a group is filled up with planes that have everything inside.
struct PlaneGroup {
  Lanes nx, ny, nz, offset;  ///< unit normals by coordinate [1], offsets along them [m]

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
  /// A vertex or face of the body that was met in this contact.
  struct Stamped {
    std::uint32_t epoch = 0;  ///< of the contact that met it
    int local = 0;            ///< its number among the candidates
    bool beyond = false;  ///< in the cap
  };

  LoadedVector<Vector3> points;       ///< in A's frame [m]
  LoadedVector<std::uint64_t> codes;  ///< `words` per point
  int words = 1;                      ///< one bit per plane of the other side
  LoadedVector<SideEdge> edges;       ///< that may reach into the other body
  LoadedVector<PlaneGroup> planes;    ///< outward
  LoadedVector<int> faces;                  ///< the body's face, by plane
  LoadedVector<int> point_in_v, face_in_v;  ///< number in V, or -1

  LoadedVector<int> cap;                           ///< vertices of the body beyond the threshold
  LoadedVector<Stamped> vertex_stamp, face_stamp;  ///< by vertex and by face of the body
  std::uint32_t epoch = 0;                         ///< of the present contact

  void reserve(int vertices, int face_count);  ///< set-up: room for a body of so many vertices and faces
};

}  // namespace haptic
