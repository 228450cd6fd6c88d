/// Part of a convex polygon in a round section: the rest of its edges, joined by arcs.
#pragma once
#include <cmath>
#include <utility>

#include "haptic_core/base/elementary.h"
#include "haptic_core/base/spatial.h"
#include "haptic_core/geometry/volume/circular_segment.h"

namespace haptic {

/// A piece of the boundary of a polygon in something round: the line from p to q, or the arc from the angle `from` over `sweep`.
template <class Point>
struct RoundCurve {
  bool arc = false;            ///< an arc; else a line
  double from = 0, sweep = 0;  ///< of an arc: first angle, and angle swept, of either sign [rad]
  Point p = Point::Zero(), q = Point::Zero();  ///< its ends [m]
};

/// Arcs shorter than this, or longer than 2π less this, may be the other of the two [rad]: rounding over the smallest circle.
inline constexpr double kArcDoubt = 1e-2;
/// Lines shorter than this share of the radius are rounding where corners coincide: they have no side.
inline constexpr double kSpeck = 1e-11;

/// a × b of two vectors in a plane.
inline double crossInPlane(const Vector2& a, const Vector2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Cuts one polygon. Its `Section` is the round outline and the way to keep the pieces:
///   Point, at(x)                           where a point of the polygon lies in the section
///   flat(point)                            seen along the axis, from the centre, in a plane
///   side                                   1, or -1: that view is from inside, and arcs turn clockwise
///   holds(x)                               x lies inside
///   inner(a, b, a_in, b_in, enter, leave)  part of the edge a → b inside, as shares of its length; false: none
///   turn(p, q), length2(p, q)              twice the area with the centre, seen from outside; squared length in the section
///   radius
template <class Section, class Curves>
class RoundLoop {
 public:
  /// Of one section; appends the curves that it finds to `curves`.
  RoundLoop(const Section& section, Curves& curves) : section_(section), curves_(curves) {}

  /// (in realtime) Adds the pieces in their order about the polygon. `key`: of a corner, the same in all polygons that share it.
  /// False: no edge comes inside.
  template <class Corner, class Key>
  bool cut(int count, Corner corner, Key key) noexcept {
    Vector3 q = corner(0);
    bool q_in = section_.holds(q), crossed = false;
    for (int i = 0; i < count; ++i) {
      const int next = i + 1 < count ? i + 1 : 0;
      const Vector3 p = q;
      const bool p_in = q_in;
      q = corner(next);
      q_in = section_.holds(q);
      // The ends in one order for both of an edge's faces, so that both see the same points.
      const bool turned = key(i) > key(next);
      const Vector3 &a = turned ? q : p, &b = turned ? p : q;
      double enter, leave;
      if (!section_.inner(a, b, turned ? q_in : p_in, turned ? p_in : q_in, enter, leave)) continue;
      Vector3 from = enter > 0 ? Vector3(a + enter * (b - a)) : a, to = leave < 1 ? Vector3(a + leave * (b - a)) : b;
      if (turned) std::swap(from, to);
      addEdge(section_.at(from), section_.at(to), p_in, q_in);
      crossed = true;
    }
    if (left_ && entered_) curves_.push_back(arc(exit_, first_entry_));
    return crossed;
  }

  /// (in realtime) Whether the polygon goes around the centre. Rounding makes specks of edges where corners coincide, which have
  /// no side. `twice`: its area, where it does.
  template <class Corner>
  bool surroundsCentre(int count, Corner corner, double& twice) const noexcept {
    const double speck = kSpeck * section_.radius;
    twice = 0;
    for (int i = 0; i < count; ++i) {
      const Vector3 p = corner(i), q = corner(i + 1 < count ? i + 1 : 0);
      const double turn = section_.turn(p, q);
      if (!(turn >= 0 || section_.length2(p, q) < speck * speck)) return false;
      twice += turn;
    }
    return twice > 0;
  }

 private:
  using Point = typename Section::Point;

  /// Counter-clockwise seen from outside.
  RoundCurve<Point> arc(const Point& p, const Point& q) const noexcept {
    const Vector2 from = section_.flat(p), to = section_.flat(q);
    double sweep = section_.side * elementary::atan2(crossInPlane(from, to), from.dot(to));
    if (sweep < 0) sweep += kTurn;
    return {true, elementary::atan2(from.y(), from.x()), section_.side * sweep, p, q};
  }

  void addEdge(const Point& from, const Point& to, bool p_in, bool q_in) noexcept {
    if (!p_in) {
      if (left_) {
        curves_.push_back(arc(exit_, from));
        left_ = false;
      } else if (!entered_) {
        first_entry_ = from;
      }
      entered_ = true;
    }
    curves_.push_back({false, 0, 0, from, to});
    if (!q_in) exit_ = to, left_ = true;
  }

  const Section& section_;
  Curves& curves_;
  bool entered_ = false, left_ = false;
  Point first_entry_ = Point::Zero(), exit_ = Point::Zero();
};

/// Whether rounding may have made an arc of about a whole turn of one of about none, or the other way round. (in realtime)
template <class Curves>
bool hasDoubtfulArc(const Curves& curves, int first, int count) noexcept {
  for (int i = first; i < first + count; ++i) {
    const double sweep = std::abs(curves[i].sweep);
    if (curves[i].arc && (sweep < kArcDoubt || sweep > 2 * M_PI - kArcDoubt)) return true;
  }
  return false;
}

}  // namespace haptic
