/// An immutable convex polyhedron with the adjacency that contact detection walks on.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "haptic_core/geometry/shapes/convex_shape.h"

namespace haptic {

/// A convex polyhedron with the adjacency that contact detection walks on.
/// Vertices, planar faces with ordered loops, half edges and vertex neighbours. Everything is made once, at
/// set-up; all queries are const, without heap and safe from any number of threads.
///
/// Half edge h runs from `loopVertex(h)` to the next vertex of its face's loop; loops are counter-clockwise
/// seen from outside and lie one after the other, so that face f owns the half edges first…first+count-1.
class ConvexPolyhedron : public ConvexShape {
 public:
  /// A planar face and its loop of half edges.
  struct Face {
    Vector3 normal;  ///< unit, outward
    double offset;   ///< n·x ≤ offset inside [m]
    int first;       ///< first half edge of the loop
    int count;       ///< edges of the loop, ≥ 3
  };
  /// An edge between two faces.
  struct Edge {
    int from, to;     ///< vertices
    int left, right;  ///< faces; `left` has the edge as from → to, `right` as to → from
  };
  /// From vertices and one loop of vertex indices per face. Throws SetupError, naming `name` and the face or
  /// vertex, unless the surface is closed, convex and planar within rounding (kFlatness of the size), outward
  /// and of positive volume, with ≥ 4 vertices and no NaN. Vertices that no face uses are refused.
  ConvexPolyhedron(std::vector<Vector3> vertices, const std::vector<std::vector<int>>& faces,
                   const std::string& name = "polyhedron");

  /// Convex hull of points (Qhull). Faces are merged only where coplanar within rounding. Where points stray from a plane
  /// by the steps of their own numbers (float32: 1e-7 of the largest), their facets can be narrower than kFlatness; the hull is then that
  /// of fewer points, from which the others stand out by such a step, or by the least power of 4 times it that will do, 0.1 % at most.
  /// Throws SetupError for NaN, fewer than 4 points or a flat set.
  static ConvexPolyhedron hull(const std::vector<Vector3>& points, const std::string& name = "hull");

  /// Largest distance of a loop's vertex from its face's plane, and of any vertex above a face, relative to
  /// the bounding radius: some tens of roundings. Larger and a face would cut away volume that belongs to the
  /// body.
  static constexpr double kFlatness = 1e-13;

  const std::vector<Vector3>& vertices() const { return vertices_; }  ///< in the shape's frame [m]
  const std::vector<Face>& faces() const { return faces_; }  ///< outward, loops counter-clockwise
  const std::vector<Edge>& edges() const { return edges_; }  ///< each once
  int vertexCount() const { return static_cast<int>(vertices_.size()); }  ///< ≥ 4
  int faceCount() const override { return static_cast<int>(faces_.size()); }  ///< ≥ 4
  int edgeCount() const override { return static_cast<int>(edges_.size()); }  ///< ≥ 6

  int loopVertex(int half_edge) const { return loop_[half_edge]; }  ///< where the half edge starts
  int twin(int half_edge) const { return twin_[half_edge]; }        ///< the same edge in the other face
  int faceOf(int half_edge) const { return half_edge_face_[half_edge]; }  ///< the face whose loop holds it
  /// Index in edges(); both half edges have the same.
  int edgeOf(int half_edge) const { return half_edge_edge_[half_edge]; }

  /// Corner i ≤ count of a face's loop, as a vertex and as a point, and the face's plane: as CutSolid has them.
  int key(int f, int i) const { return loop_[faces_[f].first + (i < faces_[f].count ? i : 0)]; }
  const Vector3& corner(int f, int i) const { return vertices_[key(f, i)]; }  ///< [m]
  int cornerCount(int f) const { return faces_[f].count; }                    ///< of face f
  const Face& plane(int f) const { return faces_[f]; }                        ///< of face f
  int planeIndex(int f) const { return f; }                                   ///< f itself

  /// Neighbours of vertex v: neighbours()[neighbourBegin(v) … neighbourBegin(v + 1) - 1]; the half edge that
  /// leads there is outgoing()[same index].
  int neighbourBegin(int v) const { return neighbour_begin_[v]; }
  /// Vertices, by the vertex that they are next to.
  const std::vector<int>& neighbours() const { return neighbours_; }
  const std::vector<int>& outgoing() const { return outgoing_; }  ///< half edges, parallel to neighbours()

  using ConvexShape::aabb;
  Box aabb(const Pose& X_WS) const override;                 ///< tight where the axes are parallel
  TriangleMesh triangles() const override;                   ///< loops cut into fans
  bool flat() const override { return true; }
  double surface() const override;
  double leastWidth() const override;
  std::vector<Vector3> sides() const override;
  std::vector<Vector3> corners() const override { return vertices_; }
  void eachNumber(NumberVisitor& visitor) const override;
  Vector3 core(const Vector3& direction) const override { return vertices_[support(direction)]; }

  /// True for the shapes of `makeBox`: centred on the origin, edges along the axes; half the size in
  /// halfSize().
  bool isBox() const { return is_box_; }
  const Vector3& halfSize() const { return aabb_.upper; }  ///< of a box, along x, y and z [m]

  /// (in realtime) The vertex farthest along `direction` (any length), climbing from vertex `hint`. Exact for
  /// any hint, up to ties; O(1) when the hint is near.
  int support(const Vector3& direction, int hint = 0) const noexcept;

 private:
  void checkInput(const std::vector<std::vector<int>>& faces) const;
  void setPlanes();
  void pairHalfEdges();
  void listNeighbours();
  void checkConvex() const;

  std::vector<Vector3> vertices_;
  std::vector<Face> faces_;
  std::vector<Edge> edges_;
  std::vector<int> loop_, twin_, half_edge_face_, half_edge_edge_;
  std::vector<int> neighbour_begin_, neighbours_, outgoing_;
  bool is_box_ = false;
};

inline const ConvexPolyhedron* ConvexShape::polyhedron() const {
  return kind_ == ShapeKind::kPolyhedron ? static_cast<const ConvexPolyhedron*>(this) : nullptr;
}

}  // namespace haptic
