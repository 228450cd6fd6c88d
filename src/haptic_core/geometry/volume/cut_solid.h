/// A convex solid that planes have cut: faces with their loops of corners.
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/geometry/volume/loaded_vector.h"

namespace haptic {

/// Whose surface a face of V is a part of.
enum class Owner : unsigned char { kA, kB };

/// A face of V: part of one face of A or of B.
struct ContactFace {
  Vector3 normal;  ///< outward unit normal, in A's frame
  double offset;   ///< normal·x = offset on the face [m]
  int index;       ///< face of A or B that it is part of
  Owner owner;     ///< the body of `index`
};

/// A convex polyhedron as faces in their planes.
struct CutSolid {
  /// One of them.
  struct Face {
    ContactFace face;  ///< its plane, and whose it is
    int first, count;  ///< its corners in `loop`, counter-clockwise seen from outside
  };
  LoadedVector<Vector3> points;  ///< corners [m]
  LoadedVector<Face> faces;      ///< in no order
  LoadedVector<int> loop;        ///< corners of all faces, by index into `points`

  int faceCount() const { return faces.size(); }  ///< number of faces
  int cornerCount(int f) const { return faces[f].count; }  ///< of face f
  /// Index of face f's corner i; that after the last is the first.
  int key(int f, int i) const { return loop[faces[f].first + (i < faces[f].count ? i : 0)]; }
  /// Face f's corner i [m].
  const Vector3& corner(int f, int i) const { return points[key(f, i)]; }
  const ContactFace& plane(int f) const { return faces[f].face; }  ///< of face f
  int planeIndex(int f) const { return faces[f].face.index; }  ///< face of A or B that face f is part of
};

}  // namespace haptic
