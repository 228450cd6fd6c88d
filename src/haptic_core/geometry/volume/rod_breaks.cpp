#include "haptic_core/geometry/volume/rod_breaks.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

/// Relative distance from both outlines within which a root counts: rounding of double roots, √ε, and more.
constexpr double kOnOutline = 1e-6;
/// Steps of Newton's method that are longer, in shares of the heights, do not polish a root.
constexpr double kPolish = 1e-4;
/// Pieces shorter than this share of the whole are joined with the next.
constexpr double kShortest = 1e-13;
/// Of lengths along an axis: rounding by which a point beyond an end may seem not to be. At the joint of side and round end itself the
/// joint has a break of its own.
constexpr double kJoint = 1e-13;
/// Steps of Newton's method, and brackets, no longer than this are the last.
constexpr double kLast = 4 * std::numeric_limits<double>::epsilon();
/// A polynomial that comes this near to 0 where it turns, relative to its coefficients, may have a double
/// root.
constexpr double kNearZero = 1e-13;

/// c0 + c1 t + c2 t².
struct Quadratic {
  double c0, c1, c2;
  double at(double t) const { return c0 + t * (c1 + t * c2); }
  double slope(double t) const { return c1 + 2 * t * c2; }
  double root(double t) const { return std::sqrt(std::max(0.0, at(t))); }  ///< a half width
};

/// Roots in (0, 1), in order, with those that a polynomial nearly has.
struct Roots {
  double at[5];
  int count = 0;
  void add(double t) {
    if (t > 0 && t < 1 && count < 5) at[count++] = t;
  }
};

Roots rootsOf(const Quadratic& f) {
  Roots out;
  const double scale = std::abs(f.c0) + std::abs(f.c1) + std::abs(f.c2), b = -0.5 * f.c1;
  double square = b * b - f.c0 * f.c2;
  if (square < 0 && square > -kNearZero * scale * scale) square = 0;
  if (!(square >= 0)) return out;
  const double q = b + std::copysign(std::sqrt(square), b);
  const double s = f.c2 != 0 ? q / f.c2 : -1, t = q != 0 ? f.c0 / q : 0;
  out.add(std::min(s, t));
  if (s != t) out.add(std::max(s, t));
  return out;
}

/// Between where its derivative vanishes, by Newton's method in a bracket.
Roots rootsOf(const double* c, int degree) {
  if (degree == 2) return rootsOf(Quadratic{c[0], c[1], c[2]});
  double slope[4], scale = 0;
  for (int i = 0; i <= degree; ++i) scale += std::abs(c[i]);
  for (int i = 1; i <= degree; ++i) slope[i - 1] = i * c[i];
  const Roots turns = rootsOf(slope, degree - 1);
  const auto value = [&](double t, double& rate) {
    double v = c[degree];
    rate = 0;
    for (int i = degree - 1; i >= 0; --i) rate = rate * t + v, v = v * t + c[i];
    return v;
  };
  Roots out;
  double from = 0, rate, f_from = c[0];
  for (int i = 0; i <= turns.count; ++i) {
    const double to = i < turns.count ? turns.at[i] : 1, f_to = value(to, rate);
    if ((f_from < 0) != (f_to < 0)) {
      double low = from, high = to, t = 0.5 * (low + high);
      for (int pass = 0; pass < 60 && high - low > kLast; ++pass) {
        const double v = value(t, rate), step = v / rate;
        ((v < 0) == (f_from < 0) ? low : high) = t;
        const double next = t - step;
        const bool inside = next > low && next < high;
        t = inside ? next : 0.5 * (low + high);
        if (inside && std::abs(step) < kLast) break;
      }
      out.add(t);
    } else if (i < turns.count && std::abs(f_to) < kNearZero * scale) {
      out.add(to);
    }
    from = to, f_from = f_to;
  }
  return out;
}

/// Newton's method on m + p √a = q √b.
double polished(double t, const Quadratic& a, const Quadratic& b, double m, double p, double q) {
  for (int pass = 0; pass < 4; ++pass) {
    const double h = a.root(t), g = b.root(t);
    if (!(h > 0) || !(g > 0)) return t;
    const double step = (m + p * h - q * g) / (0.5 * (p * a.slope(t) / h - q * b.slope(t) / g));
    if (!(std::abs(step) < kPolish)) return t;
    t -= step;
    if (std::abs(step) < 0.5 * kLast * t) break;
  }
  return t;
}

class BreakFinder {
 public:
  BreakFinder(const RodPair& pair, RodBreaks& out) : pair_(pair), out_(out), end_(pair.width) {
    other_[0] = pair.centre;
    other_[1] = -turned(1, pair.centre);
  }

  void find() {
    out_.over[out_.count++] = 0;
    scale(0, pair_.width);
    const double distance = pair_.axisDistance();
    if (distance > 0) bound(distance);
    for (int rod = 0; rod < 2; ++rod) {
      for (int end = 0; end < 2; ++end) findOfEnd(rod, end);
    }
    std::sort(out_.over + 1, out_.over + out_.count);
    const double shortest = kShortest * span_;
    int kept = 1;
    for (int i = 1; i < out_.count; ++i) {
      if (out_.over[i] - out_.over[kept - 1] > shortest && end_ - out_.over[i] > shortest)
        out_.over[kept++] = out_.over[i];
    }
    out_.over[kept++] = end_;
    out_.count = kept;
  }

 private:
  /// Heights are from + t span.
  void scale(double from, double span) {
    from_ = from, span_ = span;
    const double under = pair_.width - from;
    for (int i = 0; i < 2; ++i) {
      const double top = under + pair_.above[i], bottom = from + pair_.below[i];
      width_[i] = {top * bottom, span * (top - bottom), -span * span};
    }
    out_.over[0] = from;
  }

  /// hA + hB ≥ D bounds all that follows.
  void bound(double D) {
    double low = 0, high = 1;
    const Roots roots = rootsOf(touching(0, D * D));
    for (int i = 0; i < roots.count; ++i) {
      const double t = polished(roots.at[i], width_[0], width_[1], D, -1, 1), a = width_[0].root(t),
                   b = width_[1].root(t);
      if (std::abs(a + b - D) > kOnOutline * D) continue;
      const double rate = width_[0].slope(t) * b + width_[1].slope(t) * a;
      (rate > 0 ? low : high) = rate > 0 ? std::max(low, t) : std::min(high, t);
    }
    if (!(low < high)) return;
    scale(low * span_, (high - low) * span_);
    // Else the end stays the highest plane exactly: half widths go like the root of the way to it.
    if (high < 1) end_ = from_ + span_;
  }

  /// Where |D ± h_rod| is the other's half width: (D² + h² − g²)² = 4 D² h², the difference of the squares
  /// linear.
  Quadratic touching(int rod, double D2) const {
    const Quadratic &h = width_[rod], &g = width_[1 - rod];
    const double k0 = h.c0 - g.c0 + D2, k1 = h.c1 - g.c1, four = 4 * D2;
    return {k0 * k0 - four * h.c0, 2 * k0 * k1 - four * h.c1, k1 * k1 - four * h.c2};
  }

  Vector2 turned(int to, const Vector2& v) const { return pair_.turned(to, v); }

  /// Whether p, in the rod's frame, lies in its section or hardly outside.
  bool holds(int rod, double t, const Vector2& p, double room) const {
    const double beyond = std::abs(p.x()) - pair_.half[rod], h = width_[rod].root(t) + room;
    return std::abs(p.y()) <= h &&
           (beyond <= room || (pair_.round[rod] && beyond * beyond + p.y() * p.y() <= h * h));
  }

  /// A break at t where p, in the frame of `you`, lies on both outlines.
  void add(int you, double t, const Vector2& p) {
    if (!(t > 0 && t < 1) || out_.count == RodBreaks::kMost) return;
    const double room = kOnOutline * (width_[0].root(t) + width_[1].root(t));
    if (holds(you, t, p, room) && holds(1 - you, t, turned(1 - you, p) + other_[1 - you], room))
      out_.over[out_.count++] = from_ + t * span_;
  }

  void findOfEnd(int rod, int end) {
    const int you = 1 - rod;
    // In the other's frame: the end's centre c; the rim's points are c ± h n.
    const Vector2 c = other_[you] + turned(you, Vector2(RodPair::sign(end) * pair_.half[rod], 0)),
                  n = turned(you, Vector2(0, 1));
    const double mine = pair_.radius[rod], yours = pair_.radius[you], more = pair_.round[rod] ? mine : 0;
    if (std::abs(c.y()) - std::abs(n.y()) * mine - more > yours) return;
    if (std::abs(c.x()) - std::abs(n.x()) * mine - more > pair_.half[you] + (pair_.round[you] ? yours : 0))
      return;
    crossSides(rod, c, n);
    if (pair_.round[rod]) touchSides(rod, c);
    for (int other = 0; other < 2; ++other) {
      if (pair_.round[you]) {
        crossCircle(rod, c, n, Vector2(RodPair::sign(other) * pair_.half[you], 0));
        if (pair_.round[rod] && rod == 0)
          touchCircle(rod, c, Vector2(RodPair::sign(other) * pair_.half[you], 0));
      } else {
        crossEnd(rod, c, n, RodPair::sign(other) * pair_.half[you]);
      }
    }
  }

  /// (c_y ± n_y h)² = g².
  void crossSides(int rod, const Vector2& c, const Vector2& n) {
    const Quadratic &h = width_[rod], &g = width_[1 - rod];
    const double q2 = n.y() * n.y(), four = 4 * c.y() * c.y() * q2;
    const double p0 = q2 * h.c0 - g.c0 + c.y() * c.y(), p1 = q2 * h.c1 - g.c1, p2 = q2 * h.c2 - g.c2;
    const double f[5] = {p0 * p0 - four * h.c0, 2 * p0 * p1 - four * h.c1,
                         p1 * p1 + 2 * p0 * p2 - four * h.c2, 2 * p1 * p2, p2 * p2};
    const Roots roots = rootsOf(f, 4);
    for (int i = 0; i < roots.count; ++i) {
      for (const double way : {-1.0, 1.0}) addOnSide(rod, c, way * n, way * n.y(), roots.at[i]);
    }
  }

  /// Where a root of |c_y + way h| = g belongs to this sign, its point c + h direction.
  void addOnSide(int rod, const Vector2& c, const Vector2& direction, double way, double root) {
    const Quadratic &h = width_[rod], &g = width_[1 - rod];
    const double y = c.y() + way * h.root(root);
    if (std::abs(std::abs(y) - g.root(root)) > 10 * kOnOutline * (h.root(root) + g.root(root))) return;
    const double t = polished(root, h, g, c.y(), way, std::copysign(1, y));
    add(1 - rod, t, c + h.root(t) * direction);
  }

  /// A circle about c touches the other's sides.
  void touchSides(int rod, const Vector2& c) {
    const Roots roots = rootsOf(touching(rod, c.y() * c.y()));
    for (int i = 0; i < roots.count; ++i) {
      for (const double way : {-1.0, 1.0}) addOnSide(rod, c, Vector2(0, way), way, roots.at[i]);
    }
  }

  /// The rim's points cross the other's end plane, and a circle about c touches it.
  void crossEnd(int rod, const Vector2& c, const Vector2& n, double plane) {
    const Quadratic& h = width_[rod];
    const auto reach = [&](double way, const Vector2& direction) {  // at h = |way|
      const Roots roots = rootsOf(Quadratic{h.c0 - way * way, h.c1, h.c2});
      for (int i = 0; i < roots.count; ++i) add(1 - rod, roots.at[i], c + way * direction);
    };
    const double gap = plane - c.x();
    if (std::abs(gap) < std::abs(n.x()) * pair_.radius[rod]) reach(gap / n.x(), n);
    if (pair_.round[rod] && std::abs(gap) < pair_.radius[rod]) reach(gap, Vector2(1, 0));
  }

  /// The rim's points cross the circle about o: b² + 2 ± h (b·n) + h² − g² = 0, b = c − o.
  void crossCircle(int rod, const Vector2& c, const Vector2& n, const Vector2& o) {
    const Quadratic &h = width_[rod], &g = width_[1 - rod];
    const Vector2 b = c - o;
    const double dot = b.dot(n), four = 4 * dot * dot, l0 = h.c0 - g.c0 + b.squaredNorm(), l1 = h.c1 - g.c1;
    const Roots roots =
        rootsOf(Quadratic{l0 * l0 - four * h.c0, 2 * l0 * l1 - four * h.c1, l1 * l1 - four * h.c2});
    for (int i = 0; i < roots.count; ++i) {
      double t = roots.at[i];
      const double way = dot * (l0 + l1 * t) > 0 ? -1 : 1;
      for (int pass = 0; pass < 3; ++pass) {
        const double step =
            (l0 + l1 * t + 2 * way * dot * h.root(t)) / (l1 + way * dot * h.slope(t) / h.root(t));
        if (!(std::abs(step) < kPolish)) break;
        t -= step;
      }
      const Vector2 p = c + way * h.root(t) * n;
      const double half = pair_.half[1 - rod], beyond = std::copysign(1, o.x()) * p.x() - half;
      if (beyond > -kJoint * (half + std::abs(c.x()))) add(1 - rod, t, p);
    }
  }

  /// Circles about c and o touch, from outside or from within.
  void touchCircle(int rod, const Vector2& c, const Vector2& o) {
    const Quadratic &h = width_[rod], &g = width_[1 - rod];
    const double D = (c - o).norm();
    const Roots roots = rootsOf(touching(rod, D * D));
    for (int i = 0; i < roots.count; ++i) {
      const double a = h.root(roots.at[i]), b = g.root(roots.at[i]);
      const double inner = std::abs(D + a - b), outer = std::abs(D - a - b), around = std::abs(D - a + b);
      const double way = inner < outer && inner < around ? 1 : -1;
      const double t = polished(roots.at[i], h, g, D, way, std::copysign(1, D + way * a));
      add(1 - rod, t, D > 0 ? Vector2(c + way * h.root(t) / D * (c - o)) : c);
    }
  }

  const RodPair& pair_;
  RodBreaks& out_;
  Vector2 other_[2];  ///< the other rod's centre in a rod's frame
  double from_ = 0, span_ = 0;
  double end_;  ///< of V, over the lowest plane
  Quadratic width_[2];  ///< squared half widths at from + t span
};

}  // namespace

void RodBreaks::find(const RodPair& pair) noexcept {
  count = 0;
  BreakFinder(pair, *this).find();
}

}  // namespace haptic
