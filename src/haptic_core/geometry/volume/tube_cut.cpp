#include "haptic_core/geometry/volume/tube_cut.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/volume/gauss_legendre.h"
#include "haptic_core/geometry/volume/tube_side_sums.h"

namespace haptic {
namespace {

/// p → q against a circle about the origin: what lies inside, as shares of its length. False: nothing does.
bool innerOfCircle(const Vector2& p, const Vector2& q, bool p_in, bool q_in, double radius, double& enter, double& leave) {
  enter = 0;
  leave = 1;
  if (p_in && q_in) return true;
  const Vector2 d = q - p;
  const double length2 = d.squaredNorm(), towards = -p.dot(d), apart = crossInPlane(p, d);
  if (!p_in && !q_in) {
    if (towards <= 0 || towards >= length2 || apart * apart >= radius * radius * length2) return false;
  }
  const double nearest = towards / length2, distance = std::abs(apart) / std::sqrt(length2);
  const double half = std::sqrt(std::max(0.0, (radius - distance) * (radius + distance) / length2));
  if (!p_in) enter = std::clamp(nearest - half, 0.0, 1.0);
  if (!q_in) leave = std::clamp(nearest + half, 0.0, 1.0);
  return p_in || q_in || enter < leave;
}

/// A face, seen along the tube's axis from above, or from below where it looks down.
struct TubeSection {
  using Point = Vector3;

  double radius, side;

  const Point& at(const Vector3& x) const { return x; }
  bool holds(const Vector3& x) const { return x.head<2>().squaredNorm() <= radius * radius; }
  bool inner(const Vector3& a, const Vector3& b, bool a_in, bool b_in, double& enter, double& leave) const {
    return innerOfCircle(a.head<2>(), b.head<2>(), a_in, b_in, radius, enter, leave);
  }
  Vector2 flat(const Point& p) const { return p.head<2>(); }
  double turn(const Vector3& p, const Vector3& q) const { return side * crossInPlane(p.head<2>(), q.head<2>()); }
  double length2(const Vector3& p, const Vector3& q) const { return (q - p).head<2>().squaredNorm(); }
};

/// A point of an arc, with what moves with its share t of the turn.
struct ArcPoint {
  double half_sine, half_cosine;  ///< of half the angle from its start
  double cosine, sine;            ///< of the angle from the apex
  double rise, rate;              ///< as `arcRise` gives them
  double t, weight;
};

/// Visits points of the arc, by so many as leave 1e-16 of trigonometric polynomials of degree 5; two of them share a sine and cosine.
template <class Visit>
void eachPoint(const TubeArc& arc, Visit&& visit) {
  const double half = 0.5 * arc.sweep;
  const elementary::SineCosine start = elementary::sinCos(arc.from), middle = elementary::sinCos(0.5 * half);
  const double sine = start.sine, cosine = start.cosine;
  const double whole = elementary::sin(arc.from + half) * elementary::sin(half);
  const auto at = [&](double t, double s, double c, double weight) {
    const double s2 = 2 * s * c, c2 = 1 - 2 * s * s;
    ArcPoint point{s, c, cosine * c2 - sine * s2, sine * c2 + cosine * s2, t, 1, t, weight};
    if (whole != 0) {
      point.rise = (sine * c + cosine * s) * s / whole;
      point.rate = half * point.sine / whole;
    }
    visit(point);
  };
  const auto by = [&](const auto& rule) {
    for (const GaussPoint& g : rule) {
      const auto [s, c] = elementary::sinCos(0.5 * half * g.at);
      at(0.5 - 0.5 * g.at, middle.sine * c - middle.cosine * s, middle.cosine * c + middle.sine * s, 0.5 * g.weight);
      at(0.5 + 0.5 * g.at, middle.sine * c + middle.cosine * s, middle.cosine * c - middle.sine * s, 0.5 * g.weight);
    }
  };
  const double sweep = std::abs(arc.sweep);  // half a turn at most
  sweep < kShortArc ? by(kGauss8) : sweep < kMiddlingArc ? by(kGauss12) : by(kGauss16);
}

double wrapped(double angle) {
  return std::remainder(angle, kTurn);
}

}  // namespace

double arcRise(double from, double sweep, double t, double& rate) noexcept {
  // cos φ₀ - cos φ = 2 sin((φ + φ₀)/2) sin((φ - φ₀)/2).
  const double half = 0.5 * sweep, whole = elementary::sin(from + half) * elementary::sin(half);
  if (whole == 0) {
    rate = 1;
    return t;
  }
  rate = half * elementary::sin(from + 2 * t * half) / whole;
  return elementary::sin(from + t * half) * elementary::sin(t * half) / whole;
}

void TubeCut::reserve(int faces, int half_edges) {
  faces_.reserve(faces + 1);
  curves_.reserve(2 * half_edges + faces + 64);  // a cover's outline behind them
}

template <class Corner, class Key>
void TubeCut::cutLoop(int count, Corner corner, Key key, TubeFace& face) noexcept {
  face.first = curves_.size();
  const TubeSection section{radius_, face.normal.z() < 0 ? -1.0 : 1.0};
  RoundLoop loop(section, curves_);
  const bool crossed = loop.cut(count, corner, key);
  face.count = curves_.size() - face.first;
  double twice;
  if (crossed) {
    if (hasDoubtfulArc(curves_, face.first, face.count)) closeArcs(face, loop.surroundsCentre(count, corner, twice));
    return;
  }
  // The ellipse lies within the face when that goes around it: a sliver does not.
  face.whole = face.normal.z() != 0 && loop.surroundsCentre(count, corner, twice) && twice > M_PI * radius_ * radius_;
  if (!face.whole) return;
  TubeCurve ellipse;
  ellipse.arc = true;
  ellipse.from = face.apex;
  ellipse.sweep = section.side * kTurn;
  const auto [sine, cosine] = elementary::sinCos(face.apex);
  ellipse.p.head<2>() = radius_ * Vector2(cosine, sine);
  ellipse.p.z() = (face.offset - radius_ * face.normal.head<2>().norm()) / face.normal.z();
  ellipse.q = ellipse.p;
  curves_.push_back(ellipse);
  face.count = 1;
}

/// Seen along z from the axis the boundary turns once about it, or not at all: see BallCut::closeArcs. Where the solid is too
/// short for all of the ellipse, no arc goes around.
void TubeCut::closeArcs(const TubeFace& face, bool holds_centre) noexcept {
  const double side = face.normal.z() < 0 ? -1 : 1;
  const bool too_short =
      2 * radius_ * face.normal.head<2>().norm() > (1 + kArcDoubt) * std::abs(face.normal.z()) * (high_ - low_);
  double total = 0;
  bool voted = false, left = true;
  for (int i = face.first; i < face.first + face.count; ++i) {
    TubeCurve& curve = curves_[i];
    if (!curve.arc) {
      const Vector2 p = curve.p.head<2>(), q = curve.q.head<2>();
      const double angle = elementary::atan2(side * crossInPlane(p, q), p.dot(q));
      total += angle;
      if ((q - p).squaredNorm() < kSpeck * kSpeck * radius_ * radius_) continue;
      voted = true;
      left = left && angle >= 0;  // as in BallCut::closeArcs
      continue;
    }
    if (too_short && std::abs(curve.sweep) > kTurn - kArcDoubt) curve.sweep -= side * kTurn;
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
    face.apex = elementary::atan2(plane.normal.y(), plane.normal.x());
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
  const double area = part.count > 0 ? areaOf(part) : 0;
  curves_.resize(part.first);
  return area;
}

/// Height at which an ellipse turns back, at `half_turns` π from its apex: by the plane, from either end.
double TubeCut::turningHeight(const TubeFace& face, const TubeCurve& curve, double alpha, int half_turns) const noexcept {
  const auto fall = [&](double angle) {  // of the cosine
    const auto [sine, cosine] = elementary::sinCos(0.5 * angle);
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

/// Of the ellipse of a face that holds all of it.
double TubeCut::wholeArea(const TubeFace& face) const noexcept { return M_PI * radius_ * radius_ / std::abs(face.normal.z()); }

/// Visits the points r of an arc, from g, with the areas of the triangles that they sweep from there.
template <class Visit>
void TubeCut::eachTriangle(const TubeFace& face, const TubeCurve& curve, const elementary::SineCosine& apex, const Vector3& g,
                           Visit&& visit) const noexcept {
  eachPart(face, curve, [&](const TubeArc& arc) {
    eachPoint(arc, [&](const ArcPoint& at) {
      const double x = radius_ * (at.cosine * apex.cosine - at.sine * apex.sine);
      const double y = radius_ * (at.sine * apex.cosine + at.cosine * apex.sine);
      const Vector3 r = Vector3(x, y, arc.z0 + at.rise * (arc.z1 - arc.z0)) - g,
                    step(-y * arc.sweep, x * arc.sweep, at.rate * (arc.z1 - arc.z0));
      visit(r, 0.5 * at.weight * face.normal.dot(r.cross(step)));
    });
  });
}

double TubeCut::areaOf(const TubeFace& face) const noexcept {
  if (face.whole) return wholeArea(face);
  const Vector3 g = curves_[face.first].p;
  const elementary::SineCosine apex = elementary::sinCos(face.apex);
  double area = 0;
  for (int i = face.first; i < face.first + face.count; ++i) {
    const TubeCurve& curve = curves_[i];
    if (!curve.arc) {
      area += 0.5 * face.normal.dot((curve.p - g).cross(curve.q - g));
    } else {
      eachTriangle(face, curve, apex, g, [&](const Vector3&, double triangle) { area += triangle; });
    }
  }
  return area;
}

PlaneMoments TubeCut::moments(const TubeFace& face, const Vector3& o) const noexcept {
  PlaneMoments out;
  Vector3 g = curves_[face.first].p;
  const elementary::SineCosine apex = elementary::sinCos(face.apex);
  if (face.whole) {
    g = Vector3(0, 0, face.offset / face.normal.z());
    const Vector3 x(radius_ * apex.cosine, radius_ * apex.sine, -radius_ * face.normal.head<2>().norm() / face.normal.z()),
        y(-radius_ * apex.sine, radius_ * apex.cosine, 0);
    out.area = wholeArea(face);
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
      eachTriangle(face, curve, apex, g, [&](const Vector3& r, double area) {
        out.area += area;
        out.first += 2.0 / 3 * area * r;
        out.second += 0.5 * area * r * r.transpose();
      });
    }
  }
  return out.shifted(g - o);
}

void TubeCut::addSide(const Vector3& o, SolidMoments& out) const noexcept {
  const double a = o.head<2>().norm(), zero = elementary::atan2(o.y(), o.x());
  SideSums sums(radius_, a);
  for (const TubeFace& face : faces_) {
    for (int i = face.first; i < face.first + face.count; ++i) {
      const TubeCurve& curve = curves_[i];
      if (!curve.arc) continue;
      // ψ at the ends in (-π, π] by the points themselves, so that the next face's arc agrees; whole turns apart.
      const double start = wrapped(curve.from - zero);
      const double end = wrapped((face.whole ? curve.from : elementary::atan2(curve.q.y(), curve.q.x())) - zero);
      sums.addTurns(std::round((start + curve.sweep - end) / kTurn), curve.q.z() - o.z());
      if (face.normal.head<2>().squaredNorm() == 0) continue;  // all at one height
      double along = start;
      eachPart(face, curve, [&](const TubeArc& arc) {
        const double rise = arc.z1 - arc.z0;
        if (rise != 0) {
          const elementary::SineCosine first = elementary::sinCos(0.5 * along);
          eachPoint(arc, [&](const ArcPoint& at) {
            const double half_sine = first.sine * at.half_cosine + first.cosine * at.half_sine,
                         half_cosine = first.cosine * at.half_cosine - first.sine * at.half_sine;
            const double psi = along + at.t * arc.sweep;
            sums.add(psi, half_sine, half_cosine, std::floor((psi + M_PI) / kTurn), arc.z0 + at.rise * rise - o.z(),
                     at.weight * at.rate * rise);
          });
        }
        along += arc.sweep;
      });
    }
  }
  const auto [sine, cosine] = elementary::sinCos(zero);
  sums.addTo(Vector3(cosine, sine, 0), Vector3(-sine, cosine, 0), out);
}

}  // namespace haptic
