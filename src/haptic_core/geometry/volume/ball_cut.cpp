#include "haptic_core/geometry/volume/ball_cut.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/volume/circular_segment.h"
#include "haptic_core/geometry/volume/contact_moments.h"

namespace haptic {
namespace {

CutFace planeOf(const Vector3& normal, double height, double radius) {
  CutFace face;
  face.normal = normal;
  face.height = height;
  face.radius = std::sqrt((radius - height) * (radius + height));
  const Matrix3 axes = patchAxes(normal);
  face.x = axes.col(0);
  face.y = axes.col(1);
  return face;
}

/// An edge p → q against a sphere about the origin: what lies inside, as shares of its length. False: nothing
/// does.
bool innerOfSphere(const Vector3& p, const Vector3& q, bool p_in, bool q_in, double radius, double& enter,
               double& leave) {
  enter = 0;
  leave = 1;
  if (p_in && q_in) return true;
  const Vector3 d = q - p;
  const double length2 = d.squaredNorm(), towards = -p.dot(d);
  if (!p_in && !q_in) {
    if (towards <= 0 || towards >= length2) return false;
    if ((p.squaredNorm() - radius * radius) * length2 > towards * towards) return false;
  }
  const double nearest = towards / length2, distance = (p + nearest * d).norm();
  const double half = std::sqrt(std::max(0.0, (radius - distance) * (radius + distance) / length2));
  if (!p_in) enter = std::min(1.0, nearest - half);
  if (!q_in) leave = std::max(0.0, nearest + half);
  // Of an end that lies on the sphere within rounding, the root may lie beyond it by as much.
  enter = std::max(0.0, enter);
  leave = std::min(1.0, leave);
  return p_in || q_in || half > 0;
}

/// A face's plane across the sphere; its points in the face's axes, about the circle's centre.
struct SphereSection {
  using Point = Vector2;

  const CutFace& face;
  double radius, side = 1;
  Vector3 middle = face.height * face.normal;

  Point at(const Vector3& x) const { return {face.x.dot(x - middle), face.y.dot(x - middle)}; }
  bool holds(const Vector3& x) const { return x.squaredNorm() <= radius * radius; }
  bool inner(const Vector3& a, const Vector3& b, bool a_in, bool b_in, double& enter, double& leave) const {
    return innerOfSphere(a, b, a_in, b_in, radius, enter, leave);
  }
  const Vector2& flat(const Point& p) const { return p; }
  double turn(const Vector3& p, const Vector3& q) const { return face.normal.dot((q - p).cross(middle - p)); }
  double length2(const Vector3& p, const Vector3& q) const { return (q - p).squaredNorm(); }
};

/// Whether all corners of a face lie beyond the plane that faces c through a point of the sphere, towards the
/// first: most faces of a finely cut shape do.
template <class Solid>
bool liesBeyond(const Solid& shape, int f, const Vector3& c, double radius) {
  const Vector3 first = shape.corner(f, 0) - c;
  const double square = first.squaredNorm(), least = radius * radius * square;
  if (square * square < least) return false;
  for (int i = 1; i < shape.cornerCount(f); ++i) {
    const double along = first.dot(shape.corner(f, i) - c);
    if (along <= 0 || along * along < least) return false;
  }
  return true;
}

/// Nearer to a touch, as a share of the radius, rounding decides what meets, and neighbouring faces must decide alike.
constexpr double kClear = 1e-6;

/// Whether all of the disc in which a plane cuts the ball lies clearly beyond another plane: its face does not reach the ball.
bool isCutOff(const Vector3& normal, double height, const Vector3& other, double other_height, double radius) {
  const double cosine = normal.dot(other), disc2 = (radius - height) * (radius + height);
  const double lowest = height * cosine - std::sqrt(disc2 * std::max(0.0, (1 - cosine) * (1 + cosine)));
  return lowest > other_height + kClear * radius;
}

/// ∫ 1, r, r rᵀ over a plane region about its first point.
struct RegionSums {
  double area = 0;
  Vector2 first = Vector2::Zero();
  Matrix2 second = Matrix2::Zero();

  void addTriangle(const Vector2& p, const Vector2& q) {
    const double a = 0.5 * crossInPlane(p, q);
    const Vector2 s = p + q;
    area += a;
    first += a / 3 * s;
    second += a / 12 * (s * s.transpose() + p * p.transpose() + q * q.transpose());
  }

  /// Between an arc and its chord. `apex`: the arc's middle, `out` the unit vector to it from the circle's
  /// centre.
  void addSegment(const Vector2& apex, const Vector2& out, double radius, double half_sweep) {
    const double sine = elementary::sin(0.5 * half_sweep), s = 2 * sine * sine;
    const SegmentIntegrals j(s, half_sweep);
    const double scale = s * std::sqrt(s), r2 = radius * radius;
    const double m0 = 2 * r2 * scale * j.j0, m1 = 2 * r2 * radius * scale * j.j1,
                 m2 = 2 * r2 * r2 * scale * j.j2;
    const double across = 2.0 / 3 * r2 * r2 * scale * (2 * j.j1 - j.j2);
    const Vector2 along(-out.y(), out.x());
    area += m0;
    first += m0 * apex - m1 * out;
    second += m0 * apex * apex.transpose() - m1 * (apex * out.transpose() + out * apex.transpose()) +
              m2 * out * out.transpose() + across * along * along.transpose();
  }
};

/// Largest slope · r along a curve; `radius` of the arc.
double reachOf(const CutCurve& curve, const Vector2& slope, double radius) {
  const double ends = std::max(slope.dot(curve.p), slope.dot(curve.q));
  if (!curve.arc) return ends;
  double turn = elementary::atan2(slope.y(), slope.x()) - curve.from;
  turn -= kTurn * std::floor(turn / kTurn);
  return turn <= curve.sweep ? radius * slope.norm() : ends;
}

}  // namespace

void BallCut::reserve(int faces, int half_edges) {
  faces_.reserve(faces + 1);
  // An arc behind each edge; a cover's outline, which has few corners, and a circle behind them.
  curves_.reserve(2 * half_edges + faces + 64);
}

template <class Corner, class Key>
void BallCut::cutLoop(int count, Corner corner, Key key, CutFace& face) noexcept {
  face.first = curves_.size();
  const SphereSection section{face, radius_};
  RoundLoop loop(section, curves_);
  const bool crossed = loop.cut(count, corner, key);
  face.count = curves_.size() - face.first;
  double twice;
  if (crossed) {
    if (hasDoubtfulArc(curves_, face.first, face.count)) closeArcs(face, loop.surroundsCentre(count, corner, twice));
    return;
  }
  // The circle lies within the face when that goes around it: a sliver does not.
  face.whole = loop.surroundsCentre(count, corner, twice) && twice > M_PI * face.radius * face.radius;
  if (!face.whole) return;
  curves_.push_back({true, 0, kTurn, Vector2(face.radius, 0), Vector2(face.radius, 0)});
  face.count = 1;
}

/// Seen from the circle's centre the boundary turns once about it, or not at all. An arc of about no length,
/// which rounding has made one of about 2π, or the other way round, is found by that.
void BallCut::closeArcs(const CutFace& face, bool holds_centre) noexcept {
  CutCurve *longest = nullptr, *shortest = nullptr;
  double total = 0;
  bool voted = false, left = true;
  for (int i = face.first; i < face.first + face.count; ++i) {
    CutCurve& curve = curves_[i];
    if (!curve.arc) {
      const double angle = elementary::atan2(crossInPlane(curve.p, curve.q), curve.p.dot(curve.q));
      total += angle;
      if ((curve.q - curve.p).squaredNorm() < kSpeck * kSpeck * radius_ * radius_) continue;
      voted = true;
      left = left && angle >= 0;  // a cross product of -0 is half a turn to the right
      continue;
    }
    total += curve.sweep;
    if (!longest || curve.sweep > longest->sweep) longest = &curve;
    if (!shortest || curve.sweep < shortest->sweep) shortest = &curve;
  }
  // The lines' own sides agree with the angles that were summed, also where one runs through the centre.
  if (voted) holds_centre = left;
  const double extra = std::round((total - (holds_centre ? kTurn : 0)) / kTurn);
  if (extra > 0) longest->sweep -= kTurn;
  if (extra < 0) shortest->sweep += kTurn;
}

template <class Solid>
int BallCut::cutFaces(const Solid& shape, const Vector3& c, double radius) noexcept {
  clear();
  radius_ = radius;
  const auto heightOf = [&](int f) { return shape.plane(f).offset - shape.plane(f).normal.dot(c); };
  int deepest = 0;
  double least = INFINITY;
  for (int f = 0; f < shape.faceCount(); ++f) {
    const double height = heightOf(f);
    if (height <= -radius) return f;
    if (height < least) least = height, deepest = f;
  }
  for (int f = 0; f < shape.faceCount(); ++f) {
    const auto& plane = shape.plane(f);
    const double height = heightOf(f);
    if (height >= radius) continue;
    if (f != deepest && isCutOff(plane.normal, height, shape.plane(deepest).normal, least, radius)) continue;
    if (liesBeyond(shape, f, c, radius)) continue;
    CutFace face = planeOf(plane.normal, height, radius);
    face.index = shape.planeIndex(f);
    cutLoop(
        shape.cornerCount(f), [&](int i) -> Vector3 { return shape.corner(f, i) - c; },
        [&](int i) { return shape.key(f, i); }, face);
    if (face.count > 0) faces_.push_back(face);
  }
  return -1;
}

int BallCut::cut(const ConvexPolyhedron& shape, const Vector3& c, double radius) noexcept {
  return cutFaces(shape, c, radius);
}

int BallCut::cut(const CutSolid& solid, const Vector3& c, double radius) noexcept {
  return cutFaces(solid, c, radius);
}

void BallCut::addCircle(const Vector3& normal, double height, double radius) noexcept {
  radius_ = radius;
  CutFace face = planeOf(normal, height, radius);
  face.first = curves_.size();
  face.count = 1;
  face.whole = true;
  curves_.push_back({true, 0, kTurn, Vector2(face.radius, 0), Vector2(face.radius, 0)});
  faces_.push_back(face);
}

/// Part of a face's disc beyond the chord at `low` along the face's x.
void BallCut::addSegment(const CutFace& face, double low, double half_chord) noexcept {
  const Vector2 p(low, -half_chord), q(low, half_chord);
  const double half = elementary::atan2(half_chord, low);
  faces_.push_back(face);
  CutFace& added = faces_[faces_.size() - 1];
  added.first = curves_.size();
  added.count = 2;
  curves_.push_back({true, -half, 2 * half, p, q});
  curves_.push_back({false, 0, 0, q, p});
}

bool BallCut::cutHalf(const Vector3& k, const Vector3& normal, double height, int index, double radius) noexcept {
  clear();
  radius_ = radius;
  const double c = normal.dot(k), s = (normal - c * k).norm(), beyond = radius * s - height, below = radius * s + height;
  // The half ball's point farthest below the plane is the pole, or one of its rim.
  if (height <= -radius || (c > 0 && below <= 0)) return false;
  if (beyond <= 0 || below <= 0) {
    if (below > 0) addCircle(-k, 0, radius);  // all of the flat side
    if (height < radius && (below <= 0 || c > 0)) {
      addCircle(normal, height, radius);
      faces_[faces_.size() - 1].index = index;
    }
    return true;
  }
  // The planes meet in a chord; each face is a disc's segment that looks out across it.
  const double half_chord = std::sqrt(beyond * below) / s;
  const Vector3 side = normal.cross(k) / s, rise = side.cross(normal), fall = side.cross(k);
  const double disc = std::sqrt((radius - height) * (radius + height));
  addSegment({index, normal, height, disc, rise, normal.cross(rise)}, -height * c / s, half_chord);
  addSegment({-1, -k, 0, radius, fall, fall.cross(k)}, -height / s, half_chord);
  return true;
}

double BallCut::extent(const Vector3& up) const noexcept {
  double sum = 0;
  for (const Vector3& way : {up, Vector3(-up)}) {
    const Vector3 pole = radius_ * way;
    double reach = -radius_;
    bool pole_inside = true;
    for (const CutFace& face : faces_) {
      pole_inside &= face.normal.dot(pole) <= face.height;
      const Vector2 slope(face.x.dot(way), face.y.dot(way));
      const double middle = face.height * face.normal.dot(way);
      for (int i = face.first; i < face.first + face.count; ++i) {
        reach = std::max(reach, middle + reachOf(curves_[i], slope, face.radius));
      }
    }
    sum += pole_inside ? radius_ : std::min(radius_, reach);
  }
  return sum;
}

template <class Outline>
double BallCut::areaWithin(const CutFace& face, const Outline& outline, const Vector3& c) noexcept {
  CutFace part = face;
  cutLoop(
      static_cast<int>(outline.size()), [&](int i) -> Vector3 { return outline[i] - c; },
      [](int i) { return i; }, part);
  const double area = moments(part, part.at(Vector2::Zero())).area;
  curves_.resize(part.first);
  return area;
}

template double BallCut::areaWithin(const CutFace&, const std::vector<Vector3>&, const Vector3&) noexcept;
template double BallCut::areaWithin(const CutFace&, const LoadedVector<Vector3>&, const Vector3&) noexcept;

PlaneMoments BallCut::moments(const CutFace& face, const Vector3& o) const noexcept {
  RegionSums sums;
  Vector2 origin = Vector2::Zero();
  const double r2 = face.radius * face.radius;
  if (face.whole) {
    sums.area = M_PI * r2;
    sums.second = 0.25 * r2 * sums.area * Matrix2::Identity();
  } else if (face.count > 0) {
    origin = curves_[face.first].p;
    for (int i = face.first; i < face.first + face.count; ++i) {
      const CutCurve& curve = curves_[i];
      sums.addTriangle(curve.p - origin, curve.q - origin);
      if (!curve.arc || !(curve.sweep > 0)) continue;
      const double middle = curve.from + 0.5 * curve.sweep;
      const auto [sine, cosine] = elementary::sinCos(middle);
      const Vector2 out(cosine, sine);
      sums.addSegment(face.radius * out - origin, out, face.radius, 0.5 * curve.sweep);
    }
  }
  const Vector3 to = face.at(origin) - o, first = sums.first.x() * face.x + sums.first.y() * face.y;
  PlaneMoments out;
  out.area = sums.area;
  out.first = sums.area * to + first;
  const Matrix3 mixed = to * first.transpose();
  out.second = sums.area * to * to.transpose() + mixed + mixed.transpose() +
               sums.second(0, 0) * face.x * face.x.transpose() +
               sums.second(1, 1) * face.y * face.y.transpose() +
               sums.second(0, 1) * (face.x * face.y.transpose() + face.y * face.x.transpose());
  return out;
}

}  // namespace haptic
