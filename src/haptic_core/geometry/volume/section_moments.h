/// Moments of what planes along the axes of two rods have in common with both, of four planes at once.
///
/// The planes share an outline (rod_section.h). Each piece of it ends at crossings of two lines, of a line and
/// a circle, or of two circles: the same expressions for both rods, so that the outline closes however nearly
/// lines coincide. Where a crossing vanishes within a height's rounding it is where the two come nearest.
///
/// Moments are sums of closed forms over the pieces, about a point near the intersection: of the area cones
/// over the pieces, of A's surface ∫ n (1, x, y, x², xy, y²) ds. Cost, for four planes with AVX: 100 instructions a line, 260 to
/// 340 an arc.
#pragma once
#include "haptic_core/geometry/volume/arc_integrals.h"
#include "haptic_core/geometry/volume/rod_section.h"

namespace haptic {

/// ∫ 1, x, y, x², xy, y² in four planes.
struct PlaneSums {
  Lanes v[6];  ///< in this order

  /// To begin a sum.
  void clear() {
    for (Lanes& x : v) x = lanes(0);
  }
  /// Adds those of another piece, weighed.
  void add(const Lanes& weight, const PlaneSums& other) {
    for (int i = 0; i < 6; ++i) v[i] += weight * other.v[i];
  }
};

/// Moments of an area are these shares of its outline's, weighed with the tangent's distance from the origin: it is made of cones.
inline constexpr double kConeShare[6] = {1.0 / 2, 1.0 / 3, 1.0 / 3, 1.0 / 4, 1.0 / 4, 1.0 / 4};

/// Heights of four planes, as `RodHeight` has one.
struct RodHeights {
  Lanes over, under;  ///< [m]
};

/// Of the two rods' sections in four planes, in E's x and y.
class SectionMoments {
 public:
  /// Moments are about `origin` [m]. Keeps the pairs' reference.
  SectionMoments(const RodPair& pair, const Vector2& origin) : pair_(pair), origin_(origin), widening_(RodSection::widening(pair)) {
    for (int rod = 0; rod < 2; ++rod) {
      for (int end = 0; end < 2; ++end) {
        end_[rod][end] = pair.endSeenFrom(rod, end);
        const Vector2 own(RodPair::sign(end) * pair.half[rod], 0);
        centre_[rod][end] = (rod == 0 ? own : end_[0][end]) - origin;
      }
    }
  }

  /// (in realtime) Of planes that have this outline.
  void find(const RodOutline& pieces, const RodHeights& x) noexcept {
    for (PlaneSums* s : {&outline, &along_x, &along_y, &curved}) s->clear();
    for (int rod = 0; rod < 2; ++rod) {
      const Lanes square = (x.under + lanes(pair_.above[rod])) * (x.over + lanes(pair_.below[rod]));
      width[rod] = squareRoot(maximum(square, lanes(0)));
    }
    width[1] = width[1] * lanes(widening_);
    for (int i = 0; i < pieces.count; ++i) {
      const RodOutline::Piece& piece = pieces.piece[i];
      pair_.isLine(piece.rod, piece.line) ? addLine(piece) : addArc(piece);
    }
  }

  PlaneSums outline;           ///< of the intersection's outline, weighed with the distance of its tangent from the origin
  PlaneSums along_x, along_y;  ///< of A's outline, weighed with its normal in the plane
  PlaneSums curved;            ///< of the part of A's outline that is round: sides and a capsule's ends
  Lanes width[2];              ///< half widths of both sections [m]

 private:
  struct Point {
    Lanes x, y;
  };

  static Lanes sign(int i) { return lanes(RodPair::sign(i)); }
  Point turned(int to, const Point& v) const {
    const Lanes c = lanes(pair_.cosine), s = lanes(to == 1 ? -pair_.sine : pair_.sine);
    return {c * v.x - s * v.y, s * v.x + c * v.y};
  }
  /// A point of a rod's frame, from the origin of moments.
  Point placed(int rod, const Point& p) const {
    if (rod == 0) return {p.x - lanes(origin_.x()), p.y - lanes(origin_.y())};
    const Point q = turned(0, p);
    return {lanes(pair_.centre.x() - origin_.x()) + q.x, lanes(pair_.centre.y() - origin_.y()) + q.y};
  }
  /// Distance of a line from the middle of its rod.
  Lanes offset(int rod, int line) const { return sign(line) * (line < 2 ? width[rod] : lanes(pair_.half[rod])); }

  Lanes crossLines(int rod, int of_A, int of_B) const;
  /// Crossing of a rod's line and the circle about an end of the other: along the line and across it, from the circle's centre.
  Point crossCircle(int rod, int line, int end, int way) const {
    const Vector2& c = end_[rod][end];
    const Lanes off = lanes(line < 2 ? c.y() : c.x()) - offset(rod, line), r = width[1 - rod];
    return {lanes(way) * squareRoot(maximum((r - off) * (r + off), lanes(0))), -off};
  }
  Lanes endOfLine(const RodOutline::Piece& piece, const RodOutline::End& e) const {
    const int rod = piece.rod, line = piece.line, other = e.other;
    if (other < 0) return lanes(e.way) * (line < 2 ? lanes(pair_.half[rod]) : width[rod]);
    if (pair_.isLine(1 - rod, other)) return crossLines(rod, rod == 0 ? line : other, rod == 0 ? other : line);
    const Vector2& c = end_[rod][other - 2];
    return lanes(line < 2 ? c.x() : c.y()) + crossCircle(rod, line, other - 2, e.way).x;
  }
  Point crossCircles(int rod, int of_A, int of_B, int way) const;
  Point endOfArc(const RodOutline::Piece& piece, const RodOutline::End& e) const;
  void addLine(const RodOutline::Piece& piece);
  void addArc(const RodOutline::Piece& piece);

  const RodPair& pair_;
  const Vector2 origin_;
  const double widening_;
  Vector2 end_[2][2];     ///< middles of the other rod's ends, in a rod's frame
  Vector2 centre_[2][2];  ///< of a rod's ends, from the origin of moments
};

/// Along the rod's line, from its frame's origin. Side i of A at y = ±h: B's coordinates along it are u = (x − c_x) cos + (y − c_y) sin,
/// v = (y − c_y) cos − (x − c_x) sin.
inline Lanes SectionMoments::crossLines(int rod, int i, int j) const {
  const Lanes c = lanes(pair_.cosine), s = lanes(pair_.sine), theirs = offset(1, j);
  const Lanes inverse = lanes((i < 2) == (j < 2) ? pair_.inverse_sine : pair_.inverse_cosine);
  if (i < 2) {
    const Lanes y = offset(0, i) - lanes(pair_.centre.y());
    const Lanes dx = (j < 2 ? y * c - theirs : theirs - y * s) * inverse;
    return rod == 0 ? lanes(pair_.centre.x()) + dx : j < 2 ? dx * c + y * s : y * c - dx * s;
  }
  const Lanes x = offset(0, i) - lanes(pair_.centre.x());
  const Lanes dy = (j < 2 ? theirs + x * s : theirs - x * c) * inverse;
  return rod == 0 ? lanes(pair_.centre.y()) + dy : j < 2 ? x * c + dy * s : dy * c - x * s;
}

/// In E, from the centre of the rod's circle.
inline SectionMoments::Point SectionMoments::crossCircles(int rod, int of_A, int of_B, int way) const {
  const Vector2 between = centre_[1][of_B] - centre_[0][of_A];
  const double D = between.norm(), inverse = D > 0 ? 1 / D : 0;
  const Lanes ex = lanes(between.x() * inverse), ey = lanes(between.y() * inverse);
  const Lanes difference = (width[0] - width[1]) * (width[0] + width[1]);
  const Lanes along = lanes(0.5) * (difference * lanes(inverse) + lanes(D));
  const Lanes root = lanes(way) * squareRoot(maximum((width[0] - along) * (width[0] + along), lanes(0)));
  const Lanes from = rod == 0 ? along : along - lanes(D);
  return {from * ex - root * ey, from * ey + root * ex};
}

/// In E, from the circle's centre.
inline SectionMoments::Point SectionMoments::endOfArc(const RodOutline::Piece& piece, const RodOutline::End& e) const {
  const int rod = piece.rod, end = piece.line - 2, other = e.other;
  if (e.other < 0) {
    const Lanes y = lanes(RodPair::sign(end) * e.way) * width[rod];
    return rod == 0 ? Point{lanes(0), y} : Point{lanes(-pair_.sine) * y, lanes(pair_.cosine) * y};
  }
  if (!pair_.isLine(1 - rod, other)) return crossCircles(rod, rod == 0 ? end : other - 2, rod == 0 ? other - 2 : end, e.way);
  const Point q = crossCircle(1 - rod, other, end, e.way), p = other < 2 ? q : Point{q.y, q.x};
  return rod == 0 ? turned(0, p) : p;
}

inline void SectionMoments::addLine(const RodOutline::Piece& piece) {
  const int rod = piece.rod, line = piece.line;
  const Lanes from = endOfLine(piece, piece.from), to = endOfLine(piece, piece.to), at = offset(rod, line);
  const Lanes l = to - from, middle = lanes(0.5) * (from + to);
  const Point p = placed(rod, line < 2 ? Point{middle, at} : Point{at, middle});
  const Vector2 along = line < 2 ? Vector2(1, 0) : Vector2(0, 1), t = rod == 0 ? along : pair_.turned(0, along);
  const Vector2 n = RodPair::sign(line) * (line < 2 ? Vector2(-t.y(), t.x()) : Vector2(t.y(), -t.x()));
  const Lanes l2 = l * l * lanes(1.0 / 12), lx = l * p.x, ly = l * p.y, l3 = l * l2;
  const PlaneSums sums{{l, lx, ly, lx * p.x + l3 * lanes(t.x() * t.x()), lx * p.y + l3 * lanes(t.x() * t.y()),
                        ly * p.y + l3 * lanes(t.y() * t.y())}};
  const Lanes height = lanes(n.x()) * p.x + lanes(n.y()) * p.y;
  outline.add(height, sums);
  if (rod == 1) return;
  (line < 2 ? along_y : along_x).add(sign(line), sums);
  if (line < 2) curved.add(lanes(1), sums);
}

/// The arc of half angle φ about e, the direction of its middle. With t across, p the middle of the arc from the origin of moments and
/// u = 1 − cos θ, v = sin θ: x = p − h u e + h v t, n = (1 − u) e + v t; terms odd in v vanish.
inline void SectionMoments::addArc(const RodOutline::Piece& piece) {
  const int rod = piece.rod;
  const Lanes h = width[rod];
  const Point from = endOfArc(piece, piece.from), to = endOfArc(piece, piece.to);
  const Point chord{to.x - from.x, to.y - from.y}, sum{to.x + from.x, to.y + from.y};
  const Lanes chord2 = chord.x * chord.x + chord.y * chord.y, sine = squareRoot(chord2), cosine = squareRoot(sum.x * sum.x + sum.y * sum.y);
  const auto narrow = cosine > sine;
  const Lanes scale = lanes(1) / select(narrow, cosine, sine);
  const Point e{scale * select(narrow, sum.x, chord.y), scale * select(narrow, sum.y, -chord.x)};
  const Vector2& centre = centre_[rod][piece.line - 2];
  const Point c{lanes(centre.x()), lanes(centre.y())}, p{c.x + h * e.x, c.y + h * e.y};
  const ArcIntegrals k(sine, chord2, cosine, h);
  const Lanes vv = k.k1 + k.k1 - k.k2, uvv = k.k2 + k.k2 - k.k3;
  // Products along e and across, t = (−e_y, e_x): xx, xy, yy.
  const Lanes exx = e.x * e.x, exy = e.x * e.y, eyy = e.y * e.y, across = exx - eyy, exy2 = exy + exy;
  const Lanes pxx = p.x * e.x, pyy = p.y * e.y, pxy = p.x * e.y, pyx = p.y * e.x;
  const Lanes pp[3] = {p.x * p.x, p.x * p.y, p.y * p.y}, pe[3] = {pxx + pxx, pxy + pyx, pyy + pyy};
  const Lanes hk1 = h * k.k1, hk2 = h * k.k2, hvv = h * vv, h2 = h * h, hhvv = h2 * vv, hhuvv = h2 * uvv;
  // k eeᵀ + vv ttᵀ = vv + (k − vv) eeᵀ.
  const Lanes along = h2 * k.k2 - hhvv, along_u = h2 * k.k3 - hhuvv;
  // ∫ (1, x, y, xx, xy, yy) times 1, u and v; that of v alone is 0.
  const Lanes one[6] = {k.k0, p.x * k.k0 - hk1 * e.x, p.y * k.k0 - hk1 * e.y, k.k0 * pp[0] - hk1 * pe[0] + (along * exx + hhvv),
                        k.k0 * pp[1] - hk1 * pe[1] + along * exy, k.k0 * pp[2] - hk1 * pe[2] + (along * eyy + hhvv)};
  const Lanes u[6] = {k.k1, p.x * k.k1 - hk2 * e.x, p.y * k.k1 - hk2 * e.y, k.k1 * pp[0] - hk2 * pe[0] + (along_u * exx + hhuvv),
                      k.k1 * pp[1] - hk2 * pe[1] + along_u * exy, k.k1 * pp[2] - hk2 * pe[2] + (along_u * eyy + hhuvv)};
  const Lanes v[6] = {lanes(0), -hvv * e.y, hvv * e.x, hhuvv * exy2 - hvv * (pxy + pxy), hvv * (pxx - pyy) - hhuvv * across,
                      hvv * (pyx + pyx) - hhuvv * exy2};
  const Lanes c_e = c.x * e.x + c.y * e.y, c_t = c.y * e.x - c.x * e.y, top = c_e + h;
  outline.v[0] += top * one[0] - c_e * u[0];
  for (int i = 1; i < 6; ++i) outline.v[i] += top * one[i] - c_e * u[i] + c_t * v[i];
  if (rod == 1) return;
  along_x.v[0] += e.x * (one[0] - u[0]);
  along_y.v[0] += e.y * (one[0] - u[0]);
  curved.v[0] += one[0];
  for (int i = 1; i < 6; ++i) {
    const Lanes n_e = one[i] - u[i];
    along_x.v[i] += e.x * n_e - e.y * v[i];
    along_y.v[i] += e.y * n_e + e.x * v[i];
    curved.v[i] += one[i];
  }
}

}  // namespace haptic
