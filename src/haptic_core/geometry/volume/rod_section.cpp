#include "haptic_core/geometry/volume/rod_section.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/geometry/volume/arc_integrals.h"

namespace haptic {
namespace {

/// B's section is this much wider where round ends take part: where outlines coincide, A's is inside.
constexpr double kWider = 4 * std::numeric_limits<double>::epsilon();
/// Crossings that lie so little beyond the end of a line or arc, relatively, may be on it.
constexpr double kLoose = 1e-9;
/// How far outside the end of a half circle may lie that begins a piece inside, in half widths: a crossing
/// there may have been missed.
constexpr double kOpenEnd = 1e-6;

/// Moments of a line of length l from `middle` along the unit vector t.
PlaneSums lineSums(double l, const Vector2& middle, const Vector2& t) {
  const double x = middle.x(), y = middle.y(), l2 = l * l / 12;
  return {{l, l * x, l * y, l * (x * x + l2 * t.x() * t.x()), l * (x * y + l2 * t.x() * t.y()),
           l * (y * y + l2 * t.y() * t.y())}};
}

/// Cones from the origin over a piece of outline whose moments, weighed with the tangent's distance from it,
/// are these.
void addCones(const PlaneSums& piece, double height, PlaneSums& area) {
  constexpr double kShare[6] = {1.0 / 2, 1.0 / 3, 1.0 / 3, 1.0 / 4, 1.0 / 4, 1.0 / 4};
  for (int i = 0; i < 6; ++i) area.v[i] += kShare[i] * height * piece.v[i];
}

/// From axes x along e, y across, to those in which e is given.
PlaneSums rotated(const PlaneSums& m, const Vector2& e) {
  const double c = e.x(), s = e.y(), cc = c * c, ss = s * s, cs = c * s;
  return {{m.v[0], c * m.v[1] - s * m.v[2], s * m.v[1] + c * m.v[2],
           cc * m.v[3] - 2 * cs * m.v[4] + ss * m.v[5], cs * (m.v[3] - m.v[5]) + (cc - ss) * m.v[4],
           ss * m.v[3] + 2 * cs * m.v[4] + cc * m.v[5]}};
}

}  // namespace

bool RodSection::find(const RodHeight& x) noexcept {
  area_ = surface_[0] = surface_[1] = surface_[2] = {};
  count_ = 0;
  const bool rounded = pair_.round[0] || pair_.round[1];
  for (int rod = 0; rod < 2; ++rod) {
    const double square = pair_.square(rod, x);
    if (!(square > 0)) return false;
    width_[rod] = std::sqrt(square);
  }
  if (rounded) width_[1] *= 1 + kWider;
  other_[0] = pair_.centre;
  other_[1] = turned(1, -pair_.centre);
  for (int rod = 0; rod < 2; ++rod) {
    line_[rod][0] = line_[rod][1] = {-pair_.half[rod], pair_.half[rod]};
    line_[rod][2] = line_[rod][3] = {-width_[rod], width_[rod]};
    if (!pair_.round[rod]) continue;
    const int you = 1 - rod;
    const double reach = pair_.half[you] + (pair_.round[you] ? width_[you] : 0);
    for (int end = 0; end < 2; ++end) {
      HalfCircle& circle = circle_[rod][end];
      const Vector2 centre = turned(you, Vector2(sign(end) * pair_.half[rod], 0) - other_[rod]);
      circle.in_reach =
          std::abs(centre.y()) < width_[0] + width_[1] && std::abs(centre.x()) < reach + width_[rod];
      circle.count = 0;
    }
  }
  crossLines();
  clipLines(0), clipLines(1);
  if (pair_.round[0] && pair_.round[1]) crossCircles();
  for (int rod = 0; rod < 2; ++rod) {
    for (int i = 0; i < 4; ++i) {
      if (isLine(rod, i)) {
        addLine(rod, i);
      } else if (circle_[rod][i - 2].in_reach) {
        addArcs(rod, i - 2);
      }
    }
  }
  return count_ > 0;
}

/// Side i of A at y = ±h: B's coordinates along it are u = (x − c_x) cos + (y − c_y) sin, v = (y − c_y) cos −
/// (x − c_x) sin.
void RodSection::crossLines() noexcept {
  const double c = pair_.cosine, s = pair_.sine, cx = pair_.centre.x(), cy = pair_.centre.y();
  for (int i = 0; i < 2; ++i) {
    const double y = sign(i) * width_[0] - cy, x = sign(i) * pair_.half[0] - cx;
    for (int j = 0; j < 2; ++j) {
      const double v = sign(j) * width_[1], u = sign(j) * pair_.half[1];
      const double dx = (y * c - v) * pair_.inverse_sine, ex = (u - y * s) * pair_.inverse_cosine;
      const double dy = (v + x * s) * pair_.inverse_cosine, ey = (u - x * c) * pair_.inverse_sine;
      cross_[i][j] = {cx + dx, dx * c + y * s};
      cross_[i][2 + j] = {cx + ex, y * c - ex * s};
      cross_[2 + i][j] = {cy + dy, x * c + dy * s};
      cross_[2 + i][2 + j] = {cy + ey, ey * c - x * s};
    }
  }
}

/// What of a rod's lines lies in the other's section.
void RodSection::clipLines(int rod) noexcept {
  const int you = 1 - rod;
  const double your_half = pair_.half[you], your_width = width_[you];
  for (int i = 0; i < 4; ++i) {
    if (!isLine(rod, i)) continue;
    Line& line = line_[rod][i];
    const auto crossing = [&](int j) {
      return rod == 0 ? cross_[i][j] : Crossing{cross_[j][i].on_b, cross_[j][i].on_a};
    };
    // Along +x and +y of a rod's frame: at which of the other's lines it enters and leaves. Only A's sides
    // run against v and only B's ends against x.
    const bool from_above = rod == 0 && i < 2, against = rod == 1 && i >= 2;
    const Crossing in = crossing(from_above), out = crossing(!from_above);
    if (!pair_.round[you]) {
      line.from = std::max({line.from, in.on_a, crossing(2 + against).on_a});
      line.to = std::min({line.to, out.on_a, crossing(3 - against).on_a});
      continue;
    }
    double enter = in.on_a, leave = out.on_a;
    const double limit = (i < 2 ? pair_.half[rod] : width_[rod]) * (1 + kLoose);
    for (int end = 0; end < 2; ++end) {
      const bool enters = sign(end) * in.on_b > your_half, leaves = sign(end) * out.on_b > your_half;
      HalfCircle& circle = circle_[you][end];
      if (!circle.in_reach && !enters && !leaves) continue;
      const Vector2 c = other_[rod] + turned(rod, Vector2(sign(end) * your_half, 0));
      const double middle = i < 2 ? c.x() : c.y();
      const double off = (i < 2 ? c.y() : c.x()) - sign(i) * (i < 2 ? width_[rod] : pair_.half[rod]);
      const double square = (your_width - off) * (your_width + off);
      if (!(square > 0)) {
        if (enters) enter = INFINITY;
        if (leaves) leave = -INFINITY;
        continue;
      }
      const double root = std::sqrt(square);
      if (enters) enter = middle - root;
      if (leaves) leave = middle + root;
      if (!circle.in_reach) continue;
      for (const double way : {-root, root}) {
        if (std::abs(middle + way) > limit) continue;
        addCut(you, end, turned(you, i < 2 ? Vector2(way, -off) : Vector2(-off, way)) / your_width);
      }
    }
    line.from = std::max(line.from, enter);
    line.to = std::min(line.to, leave);
  }
}

void RodSection::crossCircles() noexcept {
  const double difference = (width_[0] - width_[1]) * (width_[0] + width_[1]);
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      if (!circle_[0][i].in_reach || !circle_[1][j].in_reach) continue;
      const Vector2 between =
          other_[0] + turned(0, Vector2(sign(j) * pair_.half[1], 0)) - Vector2(sign(i) * pair_.half[0], 0);
      const double D = between.norm();
      if (!(D > 0)) continue;
      const double along = 0.5 * (difference / D + D), square = (width_[0] - along) * (width_[0] + along);
      if (!(square > 0)) continue;
      const Vector2 e = between / D, t(-e.y(), e.x());
      for (const double way : {-std::sqrt(square), std::sqrt(square)}) {
        const Vector2 p = along * e + way * t;
        addCut(0, i, p / width_[0]);
        addCut(1, j, turned(1, p - between) / width_[1]);
      }
    }
  }
}

/// `direction`: in the rod's frame, nearly unit.
void RodSection::addCut(int rod, int end, const Vector2& direction) noexcept {
  HalfCircle& circle = circle_[rod][end];
  const Vector2 d = sign(end) * direction;
  if (d.x() < -kLoose || circle.count == kMostCuts) return;
  const double out = std::max(0.0, d.x());
  circle.cut[circle.count++] = {d.y() / (std::abs(d.y()) + out), Vector2(out, d.y())};
}

/// Whether p, in the rod's frame, lies in its section or within `room` of it.
bool RodSection::holds(int rod, const Vector2& p, double room) const noexcept {
  const double beyond = std::abs(p.x()) - pair_.half[rod], h = width_[rod] + room;
  if (beyond <= (pair_.round[rod] ? 0 : room)) return std::abs(p.y()) <= h;
  return pair_.round[rod] && beyond * beyond + p.y() * p.y() <= h * h;
}

void RodSection::addLine(int rod, int i) noexcept {
  const Line& line = line_[rod][i];
  const double l = line.to - line.from;
  if (!(l > 0)) return;
  const double middle = 0.5 * (line.from + line.to), towards = sign(i);
  Vector2 p = i < 2 ? Vector2(middle, towards * width_[rod]) : Vector2(towards * pair_.half[rod], middle);
  Vector2 t = i < 2 ? Vector2(1, 0) : Vector2(0, 1), n = towards * Vector2(t.y(), t.x());
  if (rod == 1) p = pair_.centre + turned(0, p), t = turned(0, t), n = turned(0, n);
  addPoint(p - 0.5 * l * t), addPoint(p + 0.5 * l * t);
  p -= origin_;
  const PlaneSums sums = lineSums(l, p, t);
  addCones(sums, n.dot(p), area_);
  if (rod == 1) return;
  surface_[i < 2].add(towards, sums);
  if (i < 2) surface_[2].add(1, sums);
}

void RodSection::addArcs(int rod, int end) noexcept {
  HalfCircle& circle = circle_[rod][end];
  Cut* const cut = circle.cut;
  std::sort(cut, cut + circle.count, [](const Cut& a, const Cut& b) { return a.key < b.key; });
  Vector2 from(0, -1);
  for (int i = 0; i <= circle.count; ++i) {
    const Vector2 to = i < circle.count ? cut[i].direction : Vector2(0, 1), before = from;
    from = to;
    const Vector2 chord = to - before, sum = before + to;
    const double sine2 = 0.25 * chord.squaredNorm(), cosine2 = 0.25 * sum.squaredNorm();
    if (!(sine2 > 0)) continue;
    const double sine = std::sqrt(sine2), cosine = std::sqrt(cosine2);
    const Vector2 middle = sign(end) * (cosine > sine ? Vector2(0.5 / cosine * sum)
                                                      : Vector2(0.5 / sine * Vector2(chord.y(), -chord.x())));
    const Vector2 centre(sign(end) * pair_.half[rod], 0), p = centre + width_[rod] * middle;
    const auto inside = [&](const Vector2& q, double room) {
      return holds(1 - rod, turned(1 - rod, q - other_[rod]), room);
    };
    if (!inside(p, 0)) continue;
    // Where outlines only just touch no crossing may be found, and the middle alone be inside.
    const double scale = sign(end) * width_[rod], room = kOpenEnd * width_[rod];
    if (i == 0 && !inside(centre + scale * before, room)) continue;
    if (i == circle.count && !inside(centre + scale * to, room)) continue;
    addArc(rod, end, middle, sine, cosine);
    for (const Vector2& q : {p, Vector2(centre + scale * before), Vector2(centre + scale * to)}) {
      addPoint(rod == 0 ? q : Vector2(pair_.centre + turned(0, q)));
    }
  }
}

/// The arc of half angle φ about `middle`, the direction from the end's centre in the rod's frame. With e
/// that direction, t across, p the arc's middle and u = 1 − cos θ, v = sin θ: x = p − h u e + h v t, n = (1 −
/// u) e + v t; what is odd in v vanishes.
void RodSection::addArc(int rod, int end, const Vector2& middle, double sine, double cosine) noexcept {
  const double h = width_[rod];
  Vector2 e = middle, c(sign(end) * pair_.half[rod], 0);
  if (rod == 1) e = turned(0, e), c = pair_.centre + turned(0, c);
  c -= origin_;
  const ArcIntegrals arc(sine, cosine);
  const double c_e = c.dot(e), t = e.x() * c.y() - e.y() * c.x(), p = c_e + h;
  const double k0 = h * arc.k0, k1 = h * arc.k1, k2 = h * arc.k2, k3 = h * arc.k3, vv = 2 * k1 - k2,
               uvv = 2 * k2 - k3;
  // ∫ (1, x, y, xx, xy, yy) times 1, u and v, along e and t.
  const double one_x = p * k0 - h * k1, u_x = p * k1 - h * k2;
  const PlaneSums one{
      {k0, one_x, t * k0, p * p * k0 - 2 * h * p * k1 + h * h * k2, t * one_x, t * t * k0 + h * h * vv}};
  const PlaneSums u{
      {k1, u_x, t * k1, p * p * k1 - 2 * h * p * k2 + h * h * k3, t * u_x, t * t * k1 + h * h * uvv}};
  const PlaneSums v{{0, 0, h * vv, 0, h * (p * vv - h * uvv), 2 * t * h * vv}};
  PlaneSums cones;
  for (int i = 0; i < 6; ++i) cones.v[i] = p * one.v[i] - c_e * u.v[i] + t * v.v[i];
  addCones(rotated(cones, e), 1, area_);
  if (rod == 1) return;
  PlaneSums along = one;
  along.add(-1, u);
  const PlaneSums n_e = rotated(along, e), n_t = rotated(v, e);
  surface_[0].add(e.x(), n_e), surface_[0].add(-e.y(), n_t);
  surface_[1].add(e.y(), n_e), surface_[1].add(e.x(), n_t);
  surface_[2].add(1, rotated(one, e));
}

}  // namespace haptic
