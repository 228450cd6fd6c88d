#include "haptic_core/geometry/tube_cut.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/gauss_legendre.h"
#include "haptic_core/geometry/tube_side_sums.h"

namespace haptic {
namespace {

/// As for a ball's arcs (ball_cut.cpp).
constexpr double kDoubt = 1e-2;
/// Lines shorter than this share of the radius are rounding where corners coincide: they have no side.
constexpr double kSpeck = 1e-11;
/// Longest arcs for one rule of 16 points and of 8 [rad]: trigonometric polynomials of degree 5 to 1e-16.
constexpr double kPart = 2.1, kShortPart = 0.5;
/// Arcs that 4 points are enough for: all along the tube [rad].
constexpr double kStraight = 0.01;
constexpr GaussPoint kGauss4[] = {{0.8611363115940526, 0.34785484513745385}, {0.33998104358485626, 0.6521451548625461}};

double cross(const Vector2& a, const Vector2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// p → q against a circle about the origin: what lies inside, as shares of its length. False: nothing does.
bool innerPart(const Vector2& p, const Vector2& q, bool p_in, bool q_in, double radius, double& enter, double& leave) {
  enter = 0;
  leave = 1;
  if (p_in && q_in) return true;
  const Vector2 d = q - p;
  const double length2 = d.squaredNorm(), towards = -p.dot(d), apart = cross(p, d);
  if (!p_in && !q_in) {
    if (towards <= 0 || towards >= length2 || apart * apart >= radius * radius * length2) return false;
  }
  const double nearest = towards / length2, distance = std::abs(apart) / std::sqrt(length2);
  const double half = std::sqrt(std::max(0.0, (radius - distance) * (radius + distance) / length2));
  if (!p_in) enter = std::clamp(nearest - half, 0.0, 1.0);
  if (!q_in) leave = std::clamp(nearest + half, 0.0, 1.0);
  return p_in || q_in || enter < leave;
}

/// A point of an arc, with what moves with its share t of the turn.
struct ArcPoint {
  double half_sine, half_cosine;  ///< of half the angle from its start
  double cosine, sine;            ///< of the angle from the apex
  double rise, rate;              ///< as `arcRise` gives them
  double t, weight;
};

/// Visits points of the arc; one sine and cosine each.
template <class Visit>
void eachPoint(const TubeArc& arc, Visit&& visit) {
  const double half = 0.5 * arc.sweep, sine = std::sin(arc.from), cosine = std::cos(arc.from);
  const double whole = std::sin(arc.from + half) * std::sin(half);
  const auto at = [&](double t, double weight) {
    const double s = std::sin(t * half), c = std::cos(t * half), s2 = 2 * s * c, c2 = 1 - 2 * s * s;
    ArcPoint point{s, c, cosine * c2 - sine * s2, sine * c2 + cosine * s2, t, 1, t, weight};
    if (whole != 0) {
      point.rise = (sine * c + cosine * s) * s / whole;
      point.rate = half * point.sine / whole;
    }
    visit(point);
  };
  if (std::abs(arc.sweep) < kStraight) return integrate(kGauss4, 0, 1, at);
  if (std::abs(arc.sweep) < kShortPart) return integrate(kGauss8, 0, 1, at);
  const int parts = static_cast<int>(std::abs(arc.sweep) / kPart) + 1;
  for (int i = 0; i < parts; ++i) {
    integrate(kGauss16, static_cast<double>(i) / parts, static_cast<double>(i + 1) / parts, at);
  }
}

double wrapped(double angle) {
  return std::remainder(angle, kTurn);
}

}  // namespace

double arcRise(double from, double sweep, double t, double& rate) noexcept {
  // cos φ₀ - cos φ = 2 sin((φ + φ₀)/2) sin((φ - φ₀)/2).
  const double half = 0.5 * sweep, whole = std::sin(from + half) * std::sin(half);
  if (whole == 0) {
    rate = 1;
    return t;
  }
  rate = half * std::sin(from + 2 * t * half) / whole;
  return std::sin(from + t * half) * std::sin(t * half) / whole;
}

void TubeCut::reserve(int faces, int half_edges) {
  faces_.reserve(faces + 1);
  curves_.reserve(2 * half_edges + faces + 64);  // a cover's outline behind them
}

template <class Corner, class Key>
void TubeCut::cutLoop(int count, Corner corner, Key key, TubeFace& face) noexcept {
  face.first = curves_.size();
  const double r2 = radius_ * radius_, side = face.normal.z() < 0 ? -1 : 1;
  bool crossed = false, entered = false, left = false;
  Vector3 first_entry = Vector3::Zero(), exit = Vector3::Zero();
  const auto arcTo = [&](const Vector3& to) {
    TubeCurve arc;
    arc.arc = true;
    arc.p = exit;
    arc.q = to;
    arc.from = std::atan2(exit.y(), exit.x());
    const Vector2 p = exit.head<2>(), q = to.head<2>();
    double sweep = side * std::atan2(cross(p, q), p.dot(q));
    if (sweep < 0) sweep += kTurn;
    arc.sweep = side * sweep;
    curves_.push_back(arc);
    left = false;
  };
  Vector3 q = corner(0);
  bool q_in = q.head<2>().squaredNorm() <= r2;
  for (int i = 0; i < count; ++i) {
    const int next = i + 1 < count ? i + 1 : 0;
    const Vector3 p = q;
    const bool p_in = q_in;
    q = corner(next);
    q_in = q.head<2>().squaredNorm() <= r2;
    // The ends in one order for both of an edge's faces, so that both see the same points.
    double enter, leave;
    const bool turned = key(i) > key(next);
    const Vector3 &a = turned ? q : p, &b = turned ? p : q;
    if (!innerPart(a.head<2>(), b.head<2>(), turned ? q_in : p_in, turned ? p_in : q_in, radius_, enter, leave)) continue;
    Vector3 from = enter > 0 ? Vector3(a + enter * (b - a)) : a, to = leave < 1 ? Vector3(a + leave * (b - a)) : b;
    if (turned) std::swap(from, to);
    crossed = true;
    if (!p_in) {
      if (left) {
        arcTo(from);
      } else if (!entered) {
        first_entry = from;
      }
      entered = true;
    }
    TubeCurve line;
    line.p = from;
    line.q = to;
    curves_.push_back(line);
    if (!q_in) {
      exit = to;
      left = true;
    }
  }
  if (left && entered) arcTo(first_entry);
  face.count = curves_.size() - face.first;
  // Whether the face goes around the axis; rounding makes specks of edges where corners coincide, which have no side.
  double twice = 0;
  const auto holdsCentre = [&] {
    bool holds = true;
    for (int i = 0; i < count && holds; ++i) {
      const Vector2 p = corner(i).template head<2>(), q = corner(i + 1 < count ? i + 1 : 0).template head<2>();
      const double turn = side * cross(p, q);
      holds = turn >= 0 || (q - p).squaredNorm() < kSpeck * kSpeck * r2;
      twice += turn;
    }
    return holds && twice > 0;
  };
  if (crossed) {
    if (doubtful(face)) closeArcs(face, holdsCentre());
    return;
  }
  // The ellipse lies within the face when that goes around it: a sliver does not.
  face.whole = face.normal.z() != 0 && holdsCentre() && twice > M_PI * r2;
  if (!face.whole) return;
  TubeCurve ellipse;
  ellipse.arc = true;
  ellipse.from = face.apex;
  ellipse.sweep = side * kTurn;
  ellipse.p.head<2>() = radius_ * Vector2(std::cos(face.apex), std::sin(face.apex));
  ellipse.p.z() = (face.offset - radius_ * face.normal.head<2>().norm()) / face.normal.z();
  ellipse.q = ellipse.p;
  curves_.push_back(ellipse);
  face.count = 1;
}

/// Whether rounding may have made an arc of about a whole turn of one of about none, or the other way round.
bool TubeCut::doubtful(const TubeFace& face) const noexcept {
  for (int i = face.first; i < face.first + face.count; ++i) {
    const double sweep = std::abs(curves_[i].sweep);
    if (curves_[i].arc && (sweep < kDoubt || sweep > kTurn - kDoubt)) return true;
  }
  return false;
}

/// Seen along z from the axis the boundary turns once about it, or not at all: see BallCut::closeArcs. Where the solid is too
/// short for all of the ellipse, no arc goes around.
void TubeCut::closeArcs(const TubeFace& face, bool holds_centre) noexcept {
  const double side = face.normal.z() < 0 ? -1 : 1;
  const bool too_short =
      2 * radius_ * face.normal.head<2>().norm() > (1 + kDoubt) * std::abs(face.normal.z()) * (high_ - low_);
  double total = 0;
  bool voted = false, left = true;
  for (int i = face.first; i < face.first + face.count; ++i) {
    TubeCurve& curve = curves_[i];
    if (!curve.arc) {
      const Vector2 p = curve.p.head<2>(), q = curve.q.head<2>();
      const double turn = side * cross(p, q);
      total += std::atan2(turn, p.dot(q));
      if ((q - p).squaredNorm() < kSpeck * kSpeck * radius_ * radius_) continue;
      voted = true;
      left = left && turn >= 0;
      continue;
    }
    if (too_short && std::abs(curve.sweep) > kTurn - kDoubt) curve.sweep -= side * kTurn;
    total += std::abs(curve.sweep);
  }
  if (too_short) return;
  // The lines' own sides agree with the angles that were summed, also where one runs through the axis.
  if (voted) holds_centre = left;
  for (int extra = static_cast<int>(std::round(total / kTurn)) - (holds_centre ? 1 : 0); extra != 0;) {
    TubeCurve* wrong = nullptr;
    for (int i = face.first; i < face.first + face.count; ++i) {
      TubeCurve& curve = curves_[i];
      if (!curve.arc) continue;
      const double more = std::abs(curve.sweep), most = wrong ? std::abs(wrong->sweep) : more;
      if (!wrong || (extra > 0 ? more > most : more < most)) wrong = &curve;
    }
    if (!wrong || (extra > 0) != (std::abs(wrong->sweep) > M_PI)) return;
    const int step = extra > 0 ? 1 : -1;
    wrong->sweep -= step * side * kTurn;
    extra -= step;
  }
}

bool TubeCut::cut(const CutSolid& solid, double radius) noexcept {
  clear();
  radius_ = radius;
  low_ = INFINITY, high_ = -INFINITY;
  for (const Vector3& x : solid.points) low_ = std::min(low_, x.z()), high_ = std::max(high_, x.z());
  for (int f = 0; f < solid.faceCount(); ++f) {
    const ContactFace& plane = solid.plane(f);
    TubeFace face;
    face.normal = plane.normal;
    face.offset = plane.offset;
    face.index = plane.index;
    face.apex = std::atan2(plane.normal.y(), plane.normal.x());
    cutLoop(
        solid.cornerCount(f), [&](int i) -> const Vector3& { return solid.corner(f, i); }, [&](int i) { return solid.key(f, i); },
        face);
    if (face.count > 0) faces_.push_back(face);
  }
  return !faces_.empty();
}

double TubeCut::areaWithin(const TubeFace& face, const LoadedVector<Vector3>& outline) noexcept {
  TubeFace part = face;
  cutLoop(outline.size(), [&](int i) -> const Vector3& { return outline[i]; }, [](int i) { return i; }, part);
  const double area = part.count > 0 ? moments(part, curves_[part.first].p).area : 0;
  curves_.resize(part.first);
  return area;
}

/// Height at which an ellipse turns back, at `half_turns` π from its apex: by the plane, from either end.
double TubeCut::turningHeight(const TubeFace& face, const TubeCurve& curve, double alpha, int half_turns) const noexcept {
  const auto fall = [&](double angle) {  // of the cosine
    const double half = 0.5 * angle, sine = std::sin(half), cosine = std::cos(half);
    return half_turns % 2 == 0 ? -2 * sine * sine : 2 * cosine * cosine;
  };
  const double middle = 0.5 * (curve.p.z() + curve.q.z());
  if (face.normal.z() == 0) return middle;
  const double reach = radius_ * face.normal.head<2>().norm() / face.normal.z();
  return std::clamp(middle + 0.5 * reach * (fall(alpha) + fall(alpha + curve.sweep)), low_, high_);
}

Vector3 TubeCut::inside() const noexcept {
  Vector3 sum = Vector3::Zero();
  int count = 0;
  for (const TubeFace& face : faces_) {
    if (face.whole) {
      sum.z() += face.offset / face.normal.z();
      ++count;
      continue;
    }
    for (int i = face.first; i < face.first + face.count; ++i, ++count) sum += curves_[i].p;
  }
  return sum / count;
}

PlaneMoments TubeCut::moments(const TubeFace& face, const Vector3& o) const noexcept {
  PlaneMoments out;
  Vector3 g = curves_[face.first].p;
  const double cosine = std::cos(face.apex), sine = std::sin(face.apex);
  if (face.whole) {
    g = Vector3(0, 0, face.offset / face.normal.z());
    const Vector3 x(radius_ * cosine, radius_ * sine, -radius_ * face.normal.head<2>().norm() / face.normal.z()),
        y(-radius_ * sine, radius_ * cosine, 0);
    out.area = M_PI * radius_ * radius_ / std::abs(face.normal.z());
    out.second = 0.25 * out.area * (x * x.transpose() + y * y.transpose());
  } else {
    for (int i = face.first; i < face.first + face.count; ++i) {
      const TubeCurve& curve = curves_[i];
      if (!curve.arc) {
        const Vector3 p = curve.p - g, q = curve.q - g, s = p + q;
        const double area = 0.5 * face.normal.dot(p.cross(q));
        out.area += area;
        out.first += area / 3 * s;
        out.second += area / 12 * (s * s.transpose() + p * p.transpose() + q * q.transpose());
        continue;
      }
      eachPart(face, curve, [&](const TubeArc& arc) {
        eachPoint(arc, [&](const ArcPoint& at) {
          const double x = radius_ * (at.cosine * cosine - at.sine * sine), y = radius_ * (at.sine * cosine + at.cosine * sine);
          const Vector3 r = Vector3(x, y, arc.z0 + at.rise * (arc.z1 - arc.z0)) - g,
                        step(-y * arc.sweep, x * arc.sweep, at.rate * (arc.z1 - arc.z0));
          const double area = 0.5 * at.weight * face.normal.dot(r.cross(step));
          out.area += area;
          out.first += 2.0 / 3 * area * r;
          out.second += 0.5 * area * r * r.transpose();
        });
      });
    }
  }
  return out.shifted(g - o);
}

void TubeCut::addSide(const Vector3& o, SolidMoments& out) const noexcept {
  const double a = o.head<2>().norm(), zero = std::atan2(o.y(), o.x());
  SideSums sums(radius_, a);
  for (const TubeFace& face : faces_) {
    for (int i = face.first; i < face.first + face.count; ++i) {
      const TubeCurve& curve = curves_[i];
      if (!curve.arc) continue;
      // ψ at the ends in (-π, π] by the points themselves, so that the next face's arc agrees; whole turns apart.
      const double start = wrapped(curve.from - zero);
      const double end = wrapped((face.whole ? curve.from : std::atan2(curve.q.y(), curve.q.x())) - zero);
      sums.addTurns(std::round((start + curve.sweep - end) / kTurn), curve.q.z() - o.z());
      if (face.normal.head<2>().squaredNorm() == 0) continue;  // all at one height
      double along = start;
      eachPart(face, curve, [&](const TubeArc& arc) {
        const double rise = arc.z1 - arc.z0;
        if (rise != 0) {
          const double sine = std::sin(0.5 * along), cosine = std::cos(0.5 * along);
          eachPoint(arc, [&](const ArcPoint& at) {
            const double half_sine = sine * at.half_cosine + cosine * at.half_sine,
                         half_cosine = cosine * at.half_cosine - sine * at.half_sine;
            const double psi = along + at.t * arc.sweep;
            sums.add(psi, half_sine, half_cosine, std::floor((psi + M_PI) / kTurn), arc.z0 + at.rise * rise - o.z(),
                     at.weight * at.rate * rise);
          });
        }
        along += arc.sweep;
      });
    }
  }
  const double cosine = std::cos(zero), sine = std::sin(zero);
  sums.addTo(Vector3(cosine, sine, 0), Vector3(-sine, cosine, 0), out);
}

}  // namespace haptic
