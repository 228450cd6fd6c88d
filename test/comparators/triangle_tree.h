/// A mesh as haptic renderers search it: a tree of boxes over triangles, and the first touch of a ball that
/// moves along a line.
#pragma once
#include <vector>

#include "haptic_core/base/spatial.h"
#include "haptic_core/geometry/shapes/mass_properties.h"

namespace haptic::bench {

/// A ball of radius r whose centre moves touches a triangle where the centre meets the obstacle of Ruspini,
/// Kolarov and Khatib (The haptic display of complex graphical environments, 1997): the triangle's plane
/// moved by r, a cylinder of radius r about each edge, a sphere about each corner. With r = 0 that is the
/// facet of Zilles and Salisbury (1995). Triangles have one side: they stop what comes from outside.
class TriangleTree {
 public:
  /// Where a way ends.
  struct Touch {
    double share = 1;                  ///< of the way, in [0, 1] [1]
    Vector3 normal = Vector3::Zero();  ///< unit, from the surface to the centre, in the mesh's frame
  };

  explicit TriangleTree(const TriangleMesh& mesh);  ///< closed or open; triangles of no area are left out

  /// The first touch of a ball of `radius` [m] whose centre goes from `from` to `to` [m], in the mesh's
  /// frame. False: none. Only what it approaches counts; where it is nearer than its radius already, it
  /// touches at once. Cost: O(log n) boxes where the way is short.
  bool firstTouch(const Vector3& from, const Vector3& to, double radius, Touch& touch) const noexcept;

  /// The point of the mesh nearest to `p`, by trying all triangles [m]: an oracle, O(n).
  Vector3 nearestPoint(const Vector3& p) const noexcept;

  int triangleCount() const { return static_cast<int>(triangles_.size()); }  ///< that have an area

 private:
  struct Triangle {
    Vector3 corner[3], normal;
  };
  struct Node {
    Vector3 lower, upper;  ///< of all triangles below [m]
    int left = -1, right = -1, triangle = -1;
  };
  int build(int first, int count);

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
  int root_ = -1;
};

}  // namespace haptic::bench
