/// What a plane along the axes of two rods has in common with both: the sections' intersection, bounded by
/// pieces of lines and arcs, and its moments.
///
/// Each crossing of two lines, of a line and a circle, or of two circles is computed once and ends a piece of
/// both outlines, so that the outline of the intersection closes however nearly they coincide. A line lies
/// inside a section over one interval, whose ends are crossings with the section's sides and flat ends or,
/// beyond the ends of its axis, with the circles about these. An arc is cut by all circles and lines that
/// cross it; the middle of a piece tells whether it lies inside. Outlines that coincide count as A's.
///
/// Moments are sums of closed forms over the pieces, about a point near the intersection: of the area cones
/// over the pieces, of A's surface ∫ n (1, x, y, x², xy, y²) ds. Cost: two rectangles 1000 instructions, with
/// arcs in reach 1500 to 3000.
#pragma once
#include "haptic_core/geometry/volume/rod_pair.h"

namespace haptic {

/// ∫ 1, x, y, x², xy, y².
struct PlaneSums {
  double v[6] = {0, 0, 0, 0, 0, 0};  ///< in this order
  /// Adds those of another piece, weighed.
  void add(double weight, const PlaneSums& other) {
    for (int i = 0; i < 6; ++i) v[i] += weight * other.v[i];
  }
};

/// The intersection of the two rods' sections in one plane, in E's x and y.
class RodSection {
 public:
  /// Pieces of outline: two lines and two ends a rod, an end in up to `kMostCuts + 1`.
  static constexpr int kMostPoints = 64;
  /// Two rectangles have up to 16; with round ends more in poses that few contacts have.
  static constexpr int kUsualPoints = 20;

  /// Moments are about `origin` [m]. Keeps the pairs' reference.
  RodSection(const RodPair& pair, const Vector2& origin) : pair_(pair), origin_(origin) {}

  /// (in realtime) False: the sections have nothing in common.
  bool find(const RodHeight& x) noexcept;

  const PlaneSums& area() const { return area_; }  ///< of the intersection
  /// Of A's outline, weighed with its normal in the plane.
  const PlaneSums& alongX() const { return surface_[0]; }
  const PlaneSums& alongY() const { return surface_[1]; }  ///< see above
  /// Of the part of A's outline that is round: sides and a capsule's ends.
  const PlaneSums& curved() const { return surface_[2]; }
  double halfWidth() const { return width_[0]; }  ///< of A's section [m]
  /// Ends and middles of the pieces, from E's origin [m].
  const Vector2* points() const { return points_; }
  int pointCount() const { return count_; }  ///< of `points`

 private:
  static constexpr int kMostCuts = 20;
  /// A side or a flat end: how much of it lies inside, along it.
  struct Line {
    double from, to;
  };
  /// A point of an end's half circle: its direction from the circle's centre in the rod's frame, and its
  /// place in order.
  struct Cut {
    double key;
    Vector2 direction;
  };
  struct HalfCircle {
    bool in_reach;
    int count;
    Cut cut[kMostCuts];
  };
  struct Crossing {
    double on_a, on_b;
  };  ///< places along the two lines

  bool isLine(int rod, int line) const { return line < 2 || !pair_.round[rod]; }
  void crossLines() noexcept;
  void clipLines(int rod) noexcept;
  void crossCircles() noexcept;
  void addCut(int rod, int end, const Vector2& direction) noexcept;
  bool holds(int rod, const Vector2& p, double room) const noexcept;
  void addLine(int rod, int line) noexcept;
  void addArcs(int rod, int end) noexcept;
  void addArc(int rod, int end, const Vector2& middle, double sine, double cosine) noexcept;
  void addPoint(const Vector2& p) noexcept {
    if (count_ < kMostPoints) points_[count_++] = p;
  }
  static double sign(int i) { return RodPair::sign(i); }
  Vector2 turned(int to, const Vector2& v) const { return pair_.turned(to, v); }

  const RodPair& pair_;
  const Vector2 origin_;
  double width_[2];       ///< half widths [m]
  Vector2 other_[2];      ///< of the other rod's centre in a rod's frame [m]
  Line line_[2][4];       ///< sides at −, + half width, then flat ends at −, + half length
  Crossing cross_[4][4];  ///< of A's lines with B's, as if without end
  HalfCircle circle_[2][2];
  PlaneSums area_, surface_[3];
  Vector2 points_[kMostPoints];
  int count_ = 0;
};

}  // namespace haptic
