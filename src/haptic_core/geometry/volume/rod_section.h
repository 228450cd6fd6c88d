/// The section of two rods' intersection by a plane along their axes: its outline.
///
/// The outline is made of pieces of lines and arcs. A line lies inside a section over one interval, whose ends
/// are crossings with the section's sides and flat ends or, beyond the ends of its axis, with the circles about
/// these. An arc is cut by all circles and lines that cross it; the middle of a piece tells whether it lies
/// inside. Outlines that coincide count as A's.
///
/// Between two breaks (rod_breaks.h) all heights have the same outline, by name of its pieces and of what ends
/// them: it is found once, and section_moments.h takes its moments at many heights.
/// Cost: two rectangles 600 instructions, with arcs in reach 1000 to 2000.
#pragma once
#include "haptic_core/geometry/volume/rod_pair.h"

namespace haptic {

/// An outline's pieces by name. Line 0 and 1 of a rod are its sides at -, + half width, 2 and 3 its flat or round ends at -, + half length.
struct RodOutline {
  static constexpr int kMost = 24;  ///< pieces: two convex curves of four pieces each cross at a few points
  /// Where a piece ends.
  struct End {
    signed char other;  ///< the other rod's line that crosses it there; -1: it meets the next line of its own rod
    signed char way;    ///< -1, 1: which of two crossings with a circle, or which end of its own
  };
  /// A part of a rod's line.
  struct Piece {
    signed char rod, line;  ///< the rod, 0 or 1, and its line
    End from, to;           ///< along the rod's x or y; of a round end counterclockwise
  };

  Piece piece[kMost];  ///< of A's outline, then of B's
  int count = 0;       ///< of `piece`
};

/// The intersection of the two rods' sections in one plane, in E's x and y.
class RodSection {
 public:
  /// Pieces of outline: two lines and two ends a rod, an end in up to `kMostCuts + 1`.
  static constexpr int kMostPoints = 64;
  /// Two rectangles have up to 16; with round ends more in poses that few contacts have.
  static constexpr int kUsualPoints = 20;
  /// B's section is so much wider, relatively, where round ends take part: where outlines coincide, A's is inside.
  static double widening(const RodPair& pair);

  /// Keeps the pairs' reference.
  explicit RodSection(const RodPair& pair) : pair_(pair) {}

  /// (in realtime) False: the sections have nothing in common.
  bool find(const RodHeight& x) noexcept;

  const RodOutline& outline() const { return outline_; }  ///< of the intersection
  /// Ends and middles of the pieces, from E's origin [m].
  const Vector2* points() const { return points_; }
  int pointCount() const { return count_; }  ///< of `points`

 private:
  static constexpr int kMostCuts = 20;
  /// A side or a flat end: how much of it lies inside, along it.
  struct Line {
    double from, to;
    RodOutline::End start, end;

    void startAt(double at, const RodOutline::End& what) {
      if (at > from) from = at, start = what;
    }
    void endAt(double at, const RodOutline::End& what) {
      if (at < to) to = at, end = what;
    }
  };
  /// A point of an end's half circle: its direction from the circle's centre in the rod's frame, and its
  /// place in order.
  struct Cut {
    double key;
    Vector2 direction;
    RodOutline::End end;
  };
  struct HalfCircle {
    bool in_reach;
    int count;
    Cut cut[kMostCuts];
  };
  struct Crossing {
    double on_a, on_b;
  };  ///< places along the two lines

  bool isLine(int rod, int line) const { return pair_.isLine(rod, line); }
  void crossLines() noexcept;
  void clipLines(int rod) noexcept;
  void clipByRound(int rod, int line, bool from_above) noexcept;
  void crossCircles() noexcept;
  void addCut(int rod, int end, const Vector2& direction, const RodOutline::End& by) noexcept;
  bool holds(int rod, const Vector2& p, double room) const noexcept;
  void addLine(int rod, int line) noexcept;
  void addArcs(int rod, int end) noexcept;
  Crossing crossing(int rod, int line, int yours) const {
    return rod == 0 ? cross_[line][yours] : Crossing{cross_[yours][line].on_b, cross_[yours][line].on_a};
  }
  void addPiece(int rod, int line, const RodOutline::End& from, const RodOutline::End& to) noexcept {
    if (outline_.count < RodOutline::kMost)
      outline_.piece[outline_.count++] = {static_cast<signed char>(rod), static_cast<signed char>(line), from, to};
  }
  void addPoint(const Vector2& p) noexcept {
    if (count_ < kMostPoints) points_[count_++] = p;
  }
  static double sign(int i) { return RodPair::sign(i); }
  Vector2 turned(int to, const Vector2& v) const { return pair_.turned(to, v); }

  const RodPair& pair_;
  double width_[2];       ///< half widths [m]
  Vector2 other_[2];      ///< of the other rod's centre in a rod's frame [m]
  Line line_[2][4];       ///< of those that are lines
  Crossing cross_[4][4];  ///< of A's lines with B's, as if without end
  HalfCircle circle_[2][2];
  RodOutline outline_;
  Vector2 points_[kMostPoints];
  int count_ = 0;
};

}  // namespace haptic
