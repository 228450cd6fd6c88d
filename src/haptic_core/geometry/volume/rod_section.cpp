#include "haptic_core/geometry/volume/rod_section.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

using End = RodOutline::End;

constexpr double kWider = 4 * std::numeric_limits<double>::epsilon();
/// Crossings that lie so little beyond the end of a line or arc, relatively, may be on it.
constexpr double kLoose = 1e-9;
/// How far outside the end of a half circle may lie that begins a piece inside, in half widths: a crossing
/// there may have been missed.
constexpr double kOpenEnd = 1e-6;

}  // namespace

double RodSection::widening(const RodPair& pair) { return pair.round[0] || pair.round[1] ? 1 + kWider : 1; }

bool RodSection::find(const RodHeight& x) noexcept {
  count_ = outline_.count = 0;
  for (int rod = 0; rod < 2; ++rod) {
    const double square = pair_.square(rod, x);
    if (!(square > 0)) return false;
    width_[rod] = std::sqrt(square);
  }
  width_[1] *= widening(pair_);
  other_[0] = pair_.centre;
  other_[1] = turned(1, -pair_.centre);
  for (int rod = 0; rod < 2; ++rod) {
    const End low{-1, -1}, high{-1, 1};
    line_[rod][0] = line_[rod][1] = {-pair_.half[rod], pair_.half[rod], low, high};
    line_[rod][2] = line_[rod][3] = {-width_[rod], width_[rod], low, high};
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
      const double dx = (y * c - v) * pair_.inverse_sine;
      cross_[i][j] = {cx + dx, dx * c + y * s};
      if (!pair_.round[1]) {
        const double ex = (u - y * s) * pair_.inverse_cosine;
        cross_[i][2 + j] = {cx + ex, y * c - ex * s};
      }
      if (pair_.round[0]) continue;
      const double dy = (v + x * s) * pair_.inverse_cosine;
      cross_[2 + i][j] = {cy + dy, x * c + dy * s};
      if (pair_.round[1]) continue;
      const double ey = (u - x * c) * pair_.inverse_sine;
      cross_[2 + i][2 + j] = {cy + ey, ey * c - x * s};
    }
  }
}

/// Parts of a rod's lines in the other's section.
void RodSection::clipLines(int rod) noexcept {
  const int you = 1 - rod;
  for (int i = 0; i < 4; ++i) {
    if (!isLine(rod, i)) continue;
    // Along +x and +y of a rod's frame: at which of the other's lines it enters and leaves. Only A's sides
    // run against v and only B's ends against x.
    const bool from_above = rod == 0 && i < 2, against = rod == 1 && i >= 2;
    if (pair_.round[you]) {
      clipByRound(rod, i, from_above);
      continue;
    }
    Line& line = line_[rod][i];
    for (const int j : {static_cast<int>(from_above), 2 + against})
      line.startAt(crossing(rod, i, j).on_a, {static_cast<signed char>(j), 1});
    for (const int j : {static_cast<int>(!from_above), 3 - against}) line.endAt(crossing(rod, i, j).on_a, {static_cast<signed char>(j), 1});
  }
}

/// By sides and, where it crosses these beyond an end, by the circle about that.
void RodSection::clipByRound(int rod, int i, bool from_above) noexcept {
  const int you = 1 - rod;
  const double your_half = pair_.half[you], your_width = width_[you];
  Line& line = line_[rod][i];
  const Crossing in = crossing(rod, i, from_above), out = crossing(rod, i, !from_above);
  double enter = in.on_a, leave = out.on_a;
  End entry{static_cast<signed char>(from_above), 1}, exit{static_cast<signed char>(!from_above), 1};
  const double limit = (i < 2 ? pair_.half[rod] : width_[rod]) * (1 + kLoose);
  for (int end = 0; end < 2; ++end) {
    const bool enters = sign(end) * in.on_b > your_half, leaves = sign(end) * out.on_b > your_half;
    HalfCircle& circle = circle_[you][end];
    if (!circle.in_reach && !enters && !leaves) continue;
    const Vector2 c = pair_.endSeenFrom(rod, end);
    const double middle = i < 2 ? c.x() : c.y();
    const double off = (i < 2 ? c.y() : c.x()) - sign(i) * (i < 2 ? width_[rod] : pair_.half[rod]);
    const double square = (your_width - off) * (your_width + off);
    if (!(square > 0)) {
      if (enters) enter = INFINITY;
      if (leaves) leave = -INFINITY;
      continue;
    }
    const double root = std::sqrt(square);
    const End first{static_cast<signed char>(2 + end), -1}, second{static_cast<signed char>(2 + end), 1};
    if (enters) enter = middle - root, entry = first;
    if (leaves) leave = middle + root, exit = second;
    if (!circle.in_reach) continue;
    for (const double way : {-1.0, 1.0}) {
      const double along = way * root;
      if (std::abs(middle + along) > limit) continue;
      addCut(you, end, turned(you, i < 2 ? Vector2(along, -off) : Vector2(-off, along)) / your_width,
             {static_cast<signed char>(i), static_cast<signed char>(way)});
    }
  }
  line.startAt(enter, entry);
  line.endAt(leave, exit);
}

void RodSection::crossCircles() noexcept {
  const double difference = (width_[0] - width_[1]) * (width_[0] + width_[1]);
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      if (!circle_[0][i].in_reach || !circle_[1][j].in_reach) continue;
      const Vector2 between = pair_.betweenEnds(i, j);
      const double D = between.norm();
      if (!(D > 0)) continue;
      const double along = 0.5 * (difference / D + D), square = (width_[0] - along) * (width_[0] + along);
      if (!(square > 0)) continue;
      const Vector2 e = between / D, t(-e.y(), e.x());
      const double root = std::sqrt(square);
      for (const double way : {-1.0, 1.0}) {
        const Vector2 p = along * e + way * root * t;
        const Vector2 on_A = p / width_[0], on_B = turned(1, p - between) / width_[1];
        // Of both circles the half beyond the rod's end is outline.
        if (sign(i) * on_A.x() < -kLoose || sign(j) * on_B.x() < -kLoose) continue;
        const signed char which = static_cast<signed char>(way);
        addCut(0, i, on_A, {static_cast<signed char>(2 + j), which});
        addCut(1, j, on_B, {static_cast<signed char>(2 + i), which});
      }
    }
  }
}

/// `direction`: in the rod's frame, nearly unit.
void RodSection::addCut(int rod, int end, const Vector2& direction, const End& by) noexcept {
  HalfCircle& circle = circle_[rod][end];
  const Vector2 d = sign(end) * direction;
  if (d.x() < -kLoose || circle.count == kMostCuts) return;
  const double out = std::max(0.0, d.x());
  // Seen along the end's outward direction y rises the other way round at the lower end.
  circle.cut[circle.count++] = {d.y() / (std::abs(d.y()) + out), Vector2(out, d.y()), by};
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
  Vector2 t = i < 2 ? Vector2(1, 0) : Vector2(0, 1);
  if (rod == 1) p = pair_.centre + turned(0, p), t = turned(0, t);
  addPoint(p - 0.5 * l * t), addPoint(p + 0.5 * l * t);
  addPiece(rod, i, line.start, line.end);
}

/// Cuts at which the arc stays inside are none of the outline's.
void RodSection::addArcs(int rod, int end) noexcept {
  HalfCircle& circle = circle_[rod][end];
  Cut* const cut = circle.cut;
  std::sort(cut, cut + circle.count, [](const Cut& a, const Cut& b) { return a.key < b.key; });
  const Vector2 centre(sign(end) * pair_.half[rod], 0);
  const double scale = sign(end) * width_[rod], room = kOpenEnd * width_[rod];
  const auto inside = [&](const Vector2& q, double room) { return holds(1 - rod, turned(1 - rod, q - other_[rod]), room); };
  const auto addPlace = [&](const Vector2& direction) {
    const Vector2 q = centre + scale * direction;
    addPoint(rod == 0 ? q : Vector2(pair_.centre + turned(0, q)));
  };
  Cut from{-1, Vector2(0, -1), {-1, -1}}, entry = from;
  const Cut last{1, Vector2(0, 1), {-1, 1}};
  bool within = false;
  for (int i = 0; i <= circle.count; ++i) {
    const Cut to = i < circle.count ? cut[i] : last;
    const Vector2 chord = to.direction - from.direction, sum = from.direction + to.direction;
    const double sine2 = 0.25 * chord.squaredNorm(), cosine2 = 0.25 * sum.squaredNorm();
    if (sine2 > 0) {
      const Vector2 middle = cosine2 > sine2 ? Vector2(0.5 / std::sqrt(cosine2) * sum)
                                             : Vector2(0.5 / std::sqrt(sine2) * Vector2(chord.y(), -chord.x()));
      // Where outlines only just touch no crossing may be found, and the middle alone be inside.
      const bool now = inside(centre + scale * middle, 0) && (i > 0 || inside(centre + scale * from.direction, room)) &&
                       (i < circle.count || inside(centre + scale * to.direction, room));
      if (now) {
        if (!within) addPlace(from.direction);
        addPlace(middle), addPlace(to.direction);
      }
      if (now && !within) entry = from;
      if (!now && within) addPiece(rod, 2 + end, entry.end, from.end);
      within = now;
    }
    from = to;
  }
  if (within) addPiece(rod, 2 + end, entry.end, last.end);
}

}  // namespace haptic
