/// The parts of a convex polyhedron's faces in a ball.
///
/// The boundary of V = ball ∩ polyhedron is the part of the faces in the ball, and the part of the sphere in the
/// polyhedron. On a face that is a polygon cut by a circle: edges of the polygon and arcs of the circle. Everything here is
/// relative to the ball's centre, in the polyhedron's axes.
#pragma once
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/volume/cut_solid.h"
#include "haptic_core/geometry/volume/loaded_vector.h"
#include "haptic_core/geometry/volume/round_loop.h"

namespace haptic {

/// ∫ 1, y and y yᵀ dA over a part of a plane, y from a point o.
struct PlaneMoments {
  double area = 0;                     ///< [m²]
  Vector3 first = Vector3::Zero();     ///< [m³]
  Matrix3 second = Matrix3::Zero();    ///< [m⁴]

  /// The same from a point that lies `by` before o.
  PlaneMoments shifted(const Vector3& by) const {
    const Matrix3 mixed = by * first.transpose();
    return {area, first + area * by, second + mixed + mixed.transpose() + area * by * by.transpose()};
  }
};

/// A piece of the boundary of such a part, in the face's axes about the circle's centre, counter-clockwise seen from outside.
using CutCurve = RoundCurve<Vector2>;

/// The part of a face that lies in the ball.
struct CutFace {
  int index = -1;                      ///< of the polyhedron
  Vector3 normal;                      ///< outward
  double height = 0;                   ///< of its plane over the centre along `normal` [m]
  double radius = 0;                   ///< of the circle in its plane [m]
  Vector3 x, y;                        ///< axes in the plane; x, y, normal are right-handed
  int first = 0, count = 0;            ///< its curves
  bool whole = false;                  ///< all of the circle, one arc
  /// From the ball's centre, of the point r in the plane [m].
  Vector3 at(const Vector2& r) const { return height * normal + r.x() * x + r.y() * y; }
};

/// Sized at load, for one contact at a time.
class BallCut {
 public:
  void reserve(int faces, int half_edges);  ///< set-up: room for a polyhedron of so many faces and half edges
  /// There is room for it.
  bool fits(const ConvexPolyhedron& shape) const {
    return faces_.capacity() >= shape.faceCount() && curves_.capacity() >= 2 * 2 * shape.edgeCount() + shape.faceCount();
  }
  void clear() noexcept { faces_.clear(), curves_.clear(); }  ///< (in realtime) nothing is cut

  /// (in realtime) Cuts all faces with a sphere of `radius` [m] about `c`. The ball lies beyond a plane, and so outside: its face;
  /// else -1. A corner or edge that lies on the sphere within rounding counts as in or as out, in both faces alike.
  int cut(const ConvexPolyhedron& shape, const Vector3& c, double radius) noexcept;
  /// The same of what planes have left of a solid.
  int cut(const CutSolid& solid, const Vector3& c, double radius) noexcept;
  /// (in realtime) The half of a ball about the origin on the side of k, which is unit, cut by a plane at `height`: the rest of
  /// its flat side, whose index is -1, and the part of the plane in it. False: the half ball lies beyond the plane.
  bool cutHalf(const Vector3& k, const Vector3& normal, double height, int index, double radius) noexcept;
  /// (in realtime) Adds the circle of two spheres, or of one and a plane: a face that holds all of it.
  void addCircle(const Vector3& normal, double height, double radius) noexcept;

  const LoadedVector<CutFace>& faces() const { return faces_; }  ///< those with a part in the ball
  const LoadedVector<CutCurve>& curves() const { return curves_; }  ///< of all faces; each face has a range
  double radius() const { return radius_; }                         ///< of the last `cut` [m]

  /// (in realtime) Of a face's part, about the point o. Closed forms; a sliver keeps its digits.
  PlaneMoments moments(const CutFace& face, const Vector3& o) const noexcept;
  /// (in realtime) Extent of V along `up`: to the sphere's pole, or where that is cut off to the faces' outlines [m].
  double extent(const Vector3& up) const noexcept;
  /// (in realtime) Common area of a convex polygon in the face's plane and the ball about `c` [m²]. `outline`:
  /// in the polyhedron's frame, counter-clockwise. Uses room behind the curves.
  template <class Outline>
  double areaWithin(const CutFace& face, const Outline& outline, const Vector3& c) noexcept;

 private:
  template <class Solid>
  int cutFaces(const Solid& solid, const Vector3& c, double radius) noexcept;
  template <class Corner, class Key>
  void cutLoop(int count, Corner corner, Key key, CutFace& face) noexcept;
  void closeArcs(const CutFace& face, bool holds_centre) noexcept;
  void addSegment(const CutFace& face, double low, double half_chord) noexcept;

  double radius_ = 0;
  LoadedVector<CutFace> faces_;
  LoadedVector<CutCurve> curves_;
};

}  // namespace haptic
