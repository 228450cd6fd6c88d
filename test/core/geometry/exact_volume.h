/// Volumes of A ∩ B beyond double precision: cutting polygon soups in __float128 (113 bits) and long double.
#pragma once
#include <algorithm>
#include <array>
#include <vector>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic::oracle {

/// Cuts the tetrahedra of neither body: keeps, for each face of A and of B, the polygon that lies in the
/// other body, and sums pyramids from one point. No adjacency, no shared vertices: an algorithm apart from
/// those under test. Faces are taken as given by three of their vertices, in T throughout. A face of A on a
/// face of B counts once: A's is kept where the two look the same way, none where they look at each other.
///
/// Which planes can matter to a face is filtered in double (as CGAL's filtered predicates do): a face farther
/// outside a plane than kDoubt is gone, one farther inside is untouched, and only what lies between is cut in
/// T. The result is that of cutting every face by every plane.
template <class T>
class PolygonVolume {
 public:
  using Point = std::array<T, 3>;
  struct Plane {
    Point normal;  ///< not unit
    T offset;
  };

  struct Result {
    T volume = 0;
    Point area_vector_A{};  ///< of A's part of the surface
  };

  static T volume(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_WA, const Pose& X_WB) {
    return evaluate(A, B, X_WA, X_WB).volume;
  }

  static Result evaluate(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_WA,
                         const Pose& X_WB) {
    Result result;
    const Body a(A, X_WA), b(B, X_WB);
    Point o{};
    bool have_origin = false;
    T sum = 0;
    for (int side = 0; side < 2; ++side) {
      const Body &own = side ? b : a, &other = side ? a : b;
      for (std::size_t f = 0; f < own.planes.size(); ++f) {
        std::vector<int> doubtful;
        if (!planesThatMatter(own.corners[f], other, doubtful)) continue;
        std::vector<Point> polygon = own.loops[f];
        bool dropped = false;
        for (int g : doubtful) {
          const Plane& plane = other.planes[g];
          if (!coplanar(plane, polygon)) {
            clip(polygon, plane);
            continue;
          }
          // In one plane: kept once, for A, when both look the same way.
          dropped = dropped || side == 1 || dot(plane.normal, own.planes[f].normal) < 0;
        }
        if (dropped || polygon.size() < 3) continue;
        if (!have_origin) {
          o = polygon[0];
          have_origin = true;
        }
        for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
          const Point area = cross(minus(polygon[i], polygon[0]), minus(polygon[i + 1], polygon[0]));
          sum += dot(minus(polygon[0], o), area);
          for (int k = 0; k < 3 && side == 0; ++k) result.area_vector_A[k] += area[k] / 2;
        }
      }
    }
    result.volume = sum / 6;
    return result;
  }

 private:
  struct Body {
    Body(const ConvexPolyhedron& body, const Pose& X) {
      std::vector<Point> points;
      for (const Vector3& v : body.vertices()) {
        Point p;
        for (int i = 0; i < 3; ++i)
          p[i] = T(X.p[i]) + T(X.R(i, 0)) * T(v[0]) + T(X.R(i, 1)) * T(v[1]) + T(X.R(i, 2)) * T(v[2]);
        points.push_back(p);
      }
      for (const auto& face : body.faces()) {
        std::vector<Point> loop;
        for (int h = face.first; h < face.first + face.count; ++h) loop.push_back(points[body.loopVertex(h)]);
        // A loop that is planar only in double precision is two planes here.
        if (loop.size() == 3 || coplanar(planeOf(loop[0], loop[1], loop[2]), loop)) {
          add(loop);
        } else {
          for (std::size_t i = 1; i + 1 < loop.size(); ++i) add({loop[0], loop[i], loop[i + 1]});
        }
      }
    }
    void add(const std::vector<Point>& loop) {
      planes.push_back(planeOf(loop[0], loop[1], loop[2]));
      loops.push_back(loop);
      corners.emplace_back();
      for (const Point& p : loop) {
        corners.back().push_back(inDouble(p));
        size = std::max(size, corners.back().back().norm());
      }
      normals.push_back(inDouble(planes.back().normal).normalized());
      offsets.push_back(normals.back().dot(corners.back()[0]));
    }
    std::vector<Plane> planes;
    std::vector<std::vector<Point>> loops;
    // The same in double, unit normals, for the filter.
    std::vector<std::vector<Vector3>> corners;
    std::vector<Vector3> normals;
    std::vector<double> offsets;
    double size = 0;  ///< farthest corner from the origin
  };

  /// Heights below this share of the coordinates are left to T. Roundings in double reach 1e-15 of them for
  /// plump faces; a normal of a sliver of aspect 1e4 loses four more digits.
  static constexpr double kDoubt = 1e-8;

  /// False when some plane of `other` has the whole face outside; else lists those that may cut it.
  static bool planesThatMatter(const std::vector<Vector3>& face, const Body& other,
                               std::vector<int>& doubtful) {
    double size = other.size;
    for (const Vector3& p : face) size = std::max(size, p.norm());
    const double doubt = kDoubt * size;
    for (std::size_t g = 0; g < other.planes.size(); ++g) {
      double low = INFINITY, high = -INFINITY;
      for (const Vector3& p : face) {
        const double h = other.normals[g].dot(p) - other.offsets[g];
        low = std::min(low, h);
        high = std::max(high, h);
      }
      if (low > doubt) return false;
      if (high > -doubt) doubtful.push_back(static_cast<int>(g));
    }
    return true;
  }
  static Vector3 inDouble(const Point& p) {
    return Vector3(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
  }

  static Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
  static T dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  static Point cross(const Point& a, const Point& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
  static Plane planeOf(const Point& a, const Point& b, const Point& c) {
    const Point n = cross(minus(b, a), minus(c, a));
    return {n, dot(n, a)};
  }
  static T size(const Point& p) {
    T sum = 0;
    for (const T& x : p) sum += x < 0 ? -x : x;
    return sum;
  }
  static T rounding() {
    T e = 1;
    while (T(1) + e / 2 != T(1)) e /= 2;
    return e;
  }
  /// All of the polygon in the plane, up to a thousand roundings of T.
  static bool coplanar(const Plane& plane, const std::vector<Point>& polygon) {
    static const T tolerance = 1000 * rounding();
    for (const Point& p : polygon) {
      const T h = dot(plane.normal, p) - plane.offset;
      if ((h < 0 ? -h : h) > tolerance * size(plane.normal) * size(p)) return false;
    }
    return !polygon.empty();
  }
  static void clip(std::vector<Point>& polygon, const Plane& plane) {
    std::vector<Point> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Point &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
      const T hp = dot(plane.normal, p) - plane.offset, hq = dot(plane.normal, q) - plane.offset;
      if (hp <= 0) kept.push_back(p);
      if ((hp < 0 && hq > 0) || (hp > 0 && hq < 0)) {
        const T t = hp / (hp - hq);
        kept.push_back({p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]), p[2] + t * (q[2] - p[2])});
      }
    }
    polygon.swap(kept);
  }
};

}  // namespace haptic::oracle
