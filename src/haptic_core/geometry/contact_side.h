/// What of one body can take part in a contact: its points, edges and faces near the other body.
#pragma once
#include <cstdint>

#include "haptic_core/geometry/convex_polyhedron.h"
#include "haptic_core/geometry/lanes.h"
#include "haptic_core/geometry/loaded_vector.h"

namespace haptic {

/// Planes four at a time; the last group is filled up with planes that have everything inside.
struct PlaneGroup {
  Lanes nx, ny, nz, offset;
};

/// Candidates of one body, numbered from 0 in the order found, all in A's frame. `code(p)` has bit g set when
/// point p lies outside plane g of the other side.
struct ContactSide {
  struct Stamped {
    std::uint32_t epoch = 0;
    int local = 0;
    bool beyond = false;  ///< in the cap
  };

  LoadedVector<Vector3> points;
  LoadedVector<std::uint64_t> codes;  ///< `words` per point
  int words = 1;
  const ConvexPolyhedron::Edge* edges = nullptr;  ///< between local points and faces
  int edge_count = 0;
  LoadedVector<PlaneGroup> planes;
  LoadedVector<int> faces;                  ///< face of the body
  LoadedVector<int> point_in_v, face_in_v;  ///< number in V, or -1

  LoadedVector<ConvexPolyhedron::Edge> own_edges;  ///< storage behind `edges`
  LoadedVector<int> cap;                           ///< vertices of the body beyond the threshold
  LoadedVector<Stamped> vertex_stamp, face_stamp;
  std::uint32_t epoch = 0;

  const std::uint64_t* code(int point) const { return &codes[point * words]; }

  /// Height of point x above plane g: the very sum that its code was read from.
  double height(int g, const Vector3& x) const {
    const PlaneGroup& p = planes[g >> 2];
    const int i = g & 3;
    return p.nx[i] * x.x() + p.ny[i] * x.y() + p.nz[i] * x.z() - p.offset[i];
  }
  void reserve(int vertices, int face_count);
};

}  // namespace haptic
