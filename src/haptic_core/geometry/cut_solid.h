/// A convex solid that planes have cut: faces with their loops of corners.
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/geometry/loaded_vector.h"

namespace haptic {

enum class Owner : unsigned char { kA, kB };

/// A face of V: part of one face of A or of B.
struct ContactFace {
  Vector3 normal;  ///< outward unit normal, in A's frame
  double offset;   ///< normal·x = offset on the face [m]
  int index;       ///< face of A or B that it is part of
  Owner owner;
};

struct CutSolid {
  struct Face {
    ContactFace face;
    int first, count;  ///< its corners in `loop`, counter-clockwise seen from outside
  };
  LoadedVector<Vector3> points;
  LoadedVector<Face> faces;
  LoadedVector<int> loop;

  int faceCount() const { return faces.size(); }
  int cornerCount(int f) const { return faces[f].count; }
  int key(int f, int i) const { return loop[faces[f].first + (i < faces[f].count ? i : 0)]; }
  const Vector3& corner(int f, int i) const { return points[key(f, i)]; }
  const ContactFace& plane(int f) const { return faces[f].face; }
  int planeIndex(int f) const { return faces[f].face.index; }
};

}  // namespace haptic
