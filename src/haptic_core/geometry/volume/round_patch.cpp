#include "haptic_core/geometry/volume/round_patch.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/rod_section.h"

namespace haptic {
namespace {

/// Faces flatter than this against n have no share of the patch worth integrating.
constexpr double kEdgeOn = 1e-9;
/// The patch stands for V while the samples find at least this share of it, and at most its inverse. Else V
/// folds over (a ball more than half inside, a plate through a ball), and an ellipse of V's moments stands
/// in.
constexpr double kFound = 0.5;
/// Faces that take less than this share off ∫ d² are integrated by 4 points on each line and ray, not 8: as of walls of ground that leans.
/// Of such a share that leaves 1e-3 at most: ∫ d² is 1e-6 off over edges, as round_patch.h states.
constexpr double kSmallShare = 1e-2;
/// Heights in which two rods' sections give points of the outline, in a piece that is not too short for more than its ends. Sections at
/// the ends lie within by kInset: whether rods that only touch there have one would be rounding.
constexpr int kSections = 6;
constexpr double kInset = 1e-3;       ///< before heights are spread to the ends; of the piece 3e-6
constexpr double kShortPiece = 1e-3;  ///< share of all heights at which the rods meet
/// Lines that make up the outline of two rods' patch.
constexpr int kDirections = 32;
/// An outline is no more than this beyond the hull of points on it, a twelfth of a turn apart: 1/cos 15°.
constexpr double kBeyondHull = 1.036;

/// The outline becomes an ellipse with second moments C about its middle, for a unit of its area, which is returned.
double setEllipse(RoundVolume& v, const Vector2& middle, const Matrix2& C) {
  const double mean = 0.5 * (C(0, 0) + C(1, 1)), half = 0.5 * (C(0, 0) - C(1, 1)), root = elementary::hypot(half, C(0, 1));
  const double angle = root > 0 ? 0.5 * elementary::atan2(C(0, 1), half) : 0;
  const double a = 2 * std::sqrt(std::max(0.0, mean + root)), b = 2 * std::sqrt(std::max(0.0, mean - root));
  const auto [sine, cosine] = elementary::sinCos(angle);
  const Vector2 along(cosine, sine), across(-along.y(), along.x());
  v.curves.clear();
  v.shares.clear();
  // In halves, which are integrated in halves again: at any end of an axis, and either way about, the same samples.
  for (const double from : {0.0, M_PI}) v.curves.push_back({true, from, M_PI, middle, a * along, v.sign * b * across, Vector2::Zero()});
  v.shares.push_back({0, 2, middle, -1});
  return M_PI * a * b;
}

/// A point inside curves that bound a convex area: a mean over them by length. Rounding makes edges without length at corners of a
/// polyhedron, and they must not count.
Vector2 insideOf(const RoundVolume::Curve* curves, int count) {
  Vector2 sum = Vector2::Zero(), rate;
  double all = 0;
  for (int i = 0; i < count; ++i) {
    const Vector2 ends = curves[i].at(0, rate) + curves[i].at(1, rate), middle = curves[i].at(0.5, rate);
    const double length = rate.norm();
    sum += length / 6 * (ends + 4 * middle);
    all += length;
  }
  return all > 0 ? Vector2(sum / all) : sum;
}

double heightOf(const RoundVolume::FacePart& part) { return part.offset; }
double heightOf(const CutFace& face) { return face.height; }

}  // namespace

void RoundVolume::reserve(int faces, int half_edges) {
  cut.reserve(faces, half_edges);
  parts.reserve(3 * (faces + 1));  // a capsule's three pieces
  rims.reserve(2 * (half_edges + faces) + 64);
  near.reserve(faces + 1);
  tube.reserve(faces, half_edges);
  curves.reserve(2 * (half_edges + faces) + 64);
  shares.reserve(3 * (faces + 2));
  planes.reserve(3 * (faces + 2));
}

void RoundVolume::reserveRods() {
  constexpr int kMostSections = 12 * (kSections + 1);  // no pair was seen to have as many long pieces
  outline.reserve(kMostSections * RodSection::kUsualPoints);
  hull.reserve(outline.capacity() + 1);
  curves.reserve(kDirections);
  parts.reserve(3);
  shares.reserve(1);
}

RoundPatch::RoundPatch(RoundVolume& v, const ContactVolume& contact) noexcept : v_(v), contact_(contact) {
  const Pose X_PQ = contact.X_AC().inverse() * v.X_AQ;
  ball_ = sphereAt(X_PQ.p, v.radius);
  v.curves.clear();
  v.shares.clear();
  v.planes.clear();
  if (v.rod) {
    rod_ = {v.rod, X_PQ.p, X_PQ.R.col(2)};
    if (v.second.rod) {
      const RodPair& pair = v.second.pair;
      rod_.axis = X_PQ.R.col(0);
      second_ = {v.second.rod, X_PQ * Vector3(pair.centre.x(), pair.centre.y(), pair.distance),
                 pair.cosine * X_PQ.R.col(0) + pair.sine * X_PQ.R.col(1)};
      if (!v.second.outlined) findOutline(X_PQ);
      addOutline();
      return;
    }
    if (v.other_radius > 0) {
      // A ball on a rod: nearly an ellipse.
      other_ = sphereAt(X_PQ * v.other_Q, v.other_radius);
      const Vector2 middle = contact.A0 > 0 ? Vector2(contact.A1 / contact.A0) : Vector2(Vector2::Zero());
      setEllipse(v, middle, contact.A0 > 0 ? Matrix2(contact.A2 / contact.A0 - middle * middle.transpose()) : Matrix2(Matrix2::Zero()));
      return;
    }
    addShares(v.parts, intoP(X_PQ), true);
    return;
  }
  if (v.other_radius > 0) other_ = sphereAt(X_PQ * v.other_Q, v.other_radius);
  if (v.oval)
    addOval(X_PQ);
  else
    addShares(v.cut.faces(), intoP(X_PQ), !(v.other_radius > 0));
}

void RoundPatch::addOval(const Pose& X_PQ) noexcept {
  const Vector3 shrink = v_.stretch.cwiseInverse();
  const Matrix3 R_yP = shrink.asDiagonal() * X_PQ.R.transpose();
  const double size = R_yP.col(2).norm();
  const Vector3 way = R_yP.col(2) / size;
  oval_.slope = -(R_yP.leftCols<2>().transpose() * way) / size;
  oval_.across = R_yP.leftCols<2>() - way * (way.transpose() * R_yP.leftCols<2>());
  oval_.middle = X_PQ.p.head<2>();
  oval_.radius = v_.radius;
  oval_.thin = 1 / size;
  oval_.lowest = X_PQ.p.z() - v_.radius / size;
  oval_.highest = X_PQ.p.z() + v_.radius / size;
  addShares(v_.cut.faces(), {X_PQ.R * v_.stretch.asDiagonal(), X_PQ.p, X_PQ.R * shrink.asDiagonal()}, true);
}

bool RoundPatch::OvalInP::within(const Vector2& r, double& low, double& high) const noexcept {
  const double r2 = (across * (r - middle)).squaredNorm(), left = radius * radius - r2;
  if (left <= 0) return false;
  const double rise = thin * r2 / (radius + std::sqrt(left)), shift = slope.dot(r - middle);
  low = lowest + shift + rise;
  high = highest + shift - rise;
  return true;
}

/// The hull of points of two rods' sections.
void RoundPatch::findOutline(const Pose& X_PQ) noexcept {
  const RodPair& pair = v_.second.pair;
  const RodBreaks& breaks = v_.second.breaks;
  LoadedVector<Vector2>&points = v_.outline, &hull = v_.hull;
  points.clear();
  RodSection section(pair);
  const auto addSection = [&](double over) {
    const RodHeight x = pair.heightAt(over);
    if (!section.find(x)) return;
    for (int i = 0; i < section.pointCount(); ++i) {
      const Vector2& p = section.points()[i];
      points.push_back((X_PQ * Vector3(p.x(), p.y(), pair.z(x))).head<2>());
    }
  };
  bool meet[RodBreaks::kMost + 1];
  double range = 0;
  for (int i = 0; i + 1 < breaks.count; ++i) {
    meet[i] = section.find(pair.heightAt(0.5 * (breaks.over[i] + breaks.over[i + 1])));
    if (meet[i]) range += breaks.over[i + 1] - breaks.over[i];
  }
  for (int i = 0; i + 1 < breaks.count; ++i) {
    const double from = breaks.over[i], length = breaks.over[i + 1] - from;
    const int parts = length > kShortPiece * range ? kSections : 1;
    for (int k = 0; k <= parts && meet[i]; ++k) {
      const double s = std::clamp(static_cast<double>(k) / parts, kInset, 1 - kInset);
      addSection(from + length * s * s * (3 - 2 * s));  // near both ends of the range half widths go like roots
    }
  }
  std::sort(points.begin(), points.end(), [](const Vector2& a, const Vector2& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  // Andrew's monotone chain: below from left to right, above back.
  hull.clear();
  const auto addChain = [&](int i, int first) {
    const auto turnsRight = [&](const Vector2& a, const Vector2& b) {
      return (b.x() - a.x()) * (points[i].y() - a.y()) <= (b.y() - a.y()) * (points[i].x() - a.x());
    };
    while (hull.size() >= first + 2 && turnsRight(hull[hull.size() - 2], hull[hull.size() - 1])) hull.resize(hull.size() - 1);
    hull.push_back(points[i]);
  };
  for (int i = 0; i < points.size(); ++i) addChain(i, 0);
  const int above = hull.size() - 1;
  for (int i = points.size() - 1; i-- > 0;) addChain(i, above);
  v_.second.reach = 0;
  for (const Vector2& p : hull) v_.second.reach = std::max(v_.second.reach, kBeyondHull * p.norm());
  v_.second.outlined = true;
  sampleHull(evenStart(X_PQ.R.col(2).head<2>()));
}

/// Two rods' directions across n: unit, up to quarter turns the same whichever of the two is A and whichever end of a rod is first. With
/// angles α and β of the axes and γ of the line across both, seen along n, it is (α + β)/2, and γ where an axis points along n.
Vector2 RoundPatch::evenStart(const Vector2& across_both) const noexcept {
  const auto squared = [](const Vector2& c) { return Vector2(c.x() * c.x() - c.y() * c.y(), 2 * c.x() * c.y()); };  // as complex numbers
  const Vector2 a = squared(rod_.axis.head<2>()), b = squared(second_.axis.head<2>()), c = squared(squared(across_both));
  const double angle = elementary::atan2(a.x() * b.y() + a.y() * b.x() + c.y(), a.x() * b.x() - a.y() * b.y() + c.x()) / 4;
  const auto [sine, cosine] = elementary::sinCos(angle);
  return {cosine, sine};
}

/// Points of the hull in directions that are even where its second moments are those of a disc: which points of sections are its
/// corners is rounding on straight lines and must not matter. `even`: the first direction there.
void RoundPatch::sampleHull(Vector2 even) noexcept {
  LoadedVector<Vector2>&outline = v_.outline, &hull = v_.hull;
  outline.clear();
  double area = 0, xx = 0, xy = 0, yy = 0;
  Vector2 first = Vector2::Zero();
  const auto corner = [&](int i) -> Vector2 { return hull[i] - hull[0]; };
  for (int i = 1; i + 1 < hull.size(); ++i) {
    const Vector2 p = corner(i), q = corner(i + 1), s = p + q;
    const double turn = p.x() * q.y() - p.y() * q.x();
    area += turn / 2, first += turn / 6 * s;
    xx += turn / 24 * (p.x() * p.x() + q.x() * q.x() + s.x() * s.x());
    xy += turn / 24 * (p.x() * p.y() + q.x() * q.y() + s.x() * s.y());
    yy += turn / 24 * (p.y() * p.y() + q.y() * q.y() + s.y() * s.y());
  }
  if (!(area > 0)) return hull.clear();
  const Vector2 mean = first / area, middle = hull[0] + mean;
  xx = xx / area - mean.x() * mean.x(), xy = xy / area - mean.x() * mean.y(), yy = yy / area - mean.y() * mean.y();
  if (!(xx + yy > 0)) return hull.clear();
  // The moments' symmetric root, but for a factor, turns even directions into these.
  const double root = std::sqrt(std::max(0.0, xx * yy - xy * xy));
  const elementary::SineCosine step = elementary::sinCos(2 * M_PI / kDirections);
  const auto ahead = [&](const Vector2& d, int i) { return d.x() * (hull[i].y() - middle.y()) - d.y() * (hull[i].x() - middle.x()); };
  const int edges = hull.size() - 1;
  int edge = 0;
  for (int k = 0; k < kDirections; ++k) {
    const Vector2 d((xx + root) * even.x() + xy * even.y(), xy * even.x() + (yy + root) * even.y());
    for (int tries = 0; tries < edges && !(ahead(d, edge) <= 0 && ahead(d, edge + 1) > 0); ++tries) edge = edge + 1 < edges ? edge + 1 : 0;
    const double behind = ahead(d, edge), before = ahead(d, edge + 1), share = before > behind ? -behind / (before - behind) : 0;
    outline.push_back(hull[edge] + std::clamp(share, 0.0, 1.0) * (hull[edge + 1] - hull[edge]));
    even = Vector2(step.cosine * even.x() - step.sine * even.y(), step.sine * even.x() + step.cosine * even.y());
  }
  hull.clear();
  for (const Vector2& p : outline) hull.push_back(p);
  hull.push_back(outline[0]);
}

void RoundPatch::addOutline() noexcept {
  const LoadedVector<Vector2>& hull = v_.hull;
  RoundVolume::Share share{0, 0, Vector2::Zero(), kAll};
  for (int i = 0; i + 1 < hull.size(); ++i) {
    if (!v_.curves.push_back({false, 0, 1, hull[i], hull[i + 1] - hull[i], Vector2::Zero(), Vector2::Zero()})) break;
  }
  share.count = v_.curves.size();
  for (int i = 0; i < share.count; ++i) share.inside += hull[i] / share.count;
  v_.shares.push_back(share);
}

/// Faces that look back first, then those that look on: over the share of one of these it alone bounds V on that side.
template <class Faces>
void RoundPatch::addShares(const Faces& faces, const IntoP& map, bool planar) noexcept {
  for (const bool on : {false, true}) {
    for (const auto& face : faces) {
      const Vector3 level = map.level * face.normal;
      const double size = v_.oval ? level.norm() : 1;
      const Vector3 normal = level / size;
      if ((v_.sign * normal.z() > kEdgeOn) != on) continue;
      if (planar) v_.planes.push_back({normal, heightOf(face) / size + normal.dot(map.p)});
      if (on) addShare(face, map.turn, map.p, planar ? v_.planes.size() - 1 : kAll);
    }
    if (!on) v_.planes_back = v_.planes.size();
  }
}

void RoundPatch::addShare(const RoundVolume::FacePart& part, const Matrix3& R, const Vector3& p, int plane) noexcept {
  const double shadow = std::abs(part.moments.area * R.row(2).dot(part.normal));
  RoundVolume::Share share{v_.curves.size(), part.count, Vector2::Zero(), plane, shadow};
  const auto flat = [&](const Vector3& x) -> Vector2 { return (R * x).head<2>(); };
  for (int i = part.first; i < part.first + part.count; ++i) {
    const RoundVolume::Rim& rim = v_.rims[i];
    v_.curves.push_back({rim.arc, rim.from, rim.sweep, flat(rim.middle) + p.head<2>(), flat(rim.x), flat(rim.y), flat(rim.rise)});
  }
  share.inside = insideOf(v_.curves.begin() + share.first, v_.curves.size() - share.first);
  v_.shares.push_back(share);
}

void RoundPatch::addShare(const CutFace& face, const Matrix3& R, const Vector3& p, int plane) noexcept {
  const Vector2 middle = (R * (face.height * face.normal) + p).head<2>(), x = (R * face.x).head<2>(),
                y = (R * face.y).head<2>();
  const double shadow = M_PI * face.radius * face.radius * std::abs(x.x() * y.y() - x.y() * y.x());  // of all of the circle
  RoundVolume::Share share{v_.curves.size(), face.count, middle, plane, shadow};
  for (int i = 0; i < face.count; ++i) {
    const CutCurve& c = v_.cut.curves()[face.first + i];
    const Vector2 from = middle + c.p.x() * x + c.p.y() * y, to = middle + c.q.x() * x + c.q.y() * y;
    if (c.arc) {
      v_.curves.push_back({true, c.from, c.sweep, middle, face.radius * x, face.radius * y, Vector2::Zero()});
    } else {
      v_.curves.push_back({false, 0, 1, from, to - from, Vector2::Zero(), Vector2::Zero()});
    }
  }
  if (!face.whole) share.inside = insideOf(v_.curves.begin() + share.first, v_.curves.size() - share.first);
  v_.shares.push_back(share);
}

bool RoundPatch::resolves(double found) const noexcept {
  return found > kFound * contact_.volume && kFound * found < contact_.volume;
}

/// Σ weight · d = Vol: the rule's error is spread over the patch.
RoundPatch& RoundPatch::fit() noexcept {
  if (std::isnan(v_.sampled)) {
    double found = 0;
    if (v_.axial) {
      eachRing([&](double, double area, double d) { found += area * d; });
    } else {
      eachSample([&](const Vector2&, double weight, double d) { found += weight * d; });
    }
    v_.sampled = found;
  }
  if (resolves(v_.sampled)) {
    scale_ = contact_.volume / v_.sampled;
  } else {
    standIn();
  }
  return *this;
}

/// A disc of uniform thickness with V's volume and second moments.
void RoundPatch::standIn() noexcept {
  const double area = setEllipse(v_, Vector2::Zero(), contact_.V2 / contact_.volume);
  uniform_ = area > 0 ? contact_.volume / area : 0;
}

double RoundPatch::reach() const noexcept {
  double reach = 0;
  for (const RoundVolume::Curve& c : v_.curves) {
    if (!c.arc) {
      reach = std::max({reach, c.middle.norm(), (c.middle + c.x).norm()});
      if (v_.second.rod) return v_.second.reach;
    } else if (v_.axial) {
      reach = c.x.norm();
    } else {
      // Between two points of an arc, 0.3 rad apart, it goes out by 1 - cos(0.15) = 1.1 % of its radius at
      // most.
      const int parts = static_cast<int>(std::abs(c.sweep) / 0.3) + 1;
      Vector2 rate;
      for (int i = 0; i <= parts; ++i) reach = std::max(reach, 1.012 * c.at(static_cast<double>(i) / parts, rate).norm());
    }
  }
  return reach;
}

/// Where the line over r runs in the rod; false: nowhere. Lower and higher end of its part in the tube between the
/// ends' planes, and in the balls about them.
bool RoundPatch::RodInP::within(const Vector2& r, double& low, double& high) const noexcept {
  const double u = axis.z(), half = rod->halfLength(), R = rod->radius();
  const Vector3 y(r.x() - centre.x(), r.y() - centre.y(), -centre.z());  // from the centre, at z = 0
  const double along = axis.dot(y);
  low = INFINITY, high = -INFINITY;
  // a z² + 2 b z + c = 0, by its root of larger size and their product: no digits cancel near z = 0, where V is.
  const auto roots = [](double a, double b, double c, double& z0, double& z1) {
    const double square = b * b - a * c;
    if (!(square > 0)) return false;
    const double q = -(b + std::copysign(std::sqrt(square), b));
    z0 = std::min(q / a, c / q);
    z1 = std::max(q / a, c / q);
    return true;
  };
  const Vector3 across = y - along * axis;
  const double c = (across.norm() - R) * (across.norm() + R);
  double z0 = -INFINITY, z1 = INFINITY, a = (1 - u) * (1 + u);
  bool in = a > 1e-24 ? roots(a, -u * along + y.z(), c, z0, z1) : c < 0;
  if (in && std::abs(u) > 1e-12) {
    const double e0 = (-half - along) / u, e1 = (half - along) / u;
    z0 = std::max(z0, std::min(e0, e1));
    z1 = std::min(z1, std::max(e0, e1));
    in = z0 < z1;
  } else if (in) {
    in = std::abs(along) <= half;
  }
  if (in) low = z0, high = z1;
  for (int end = -1; end <= 1 && rod->isCapsule(); end += 2) {
    const Vector3 from = y - end * half * axis;
    if (roots(1, from.z(), (from.norm() - R) * (from.norm() + R), z0, z1)) low = std::min(low, z0), high = std::max(high, z1);
  }
  return low < high;
}

/// Height of V over r, before scaling; r lies in the share of that plane, or anywhere.
double RoundPatch::heightOver(const Vector2& r, int share) const noexcept {
  double low = -INFINITY, high = INFINITY;
  const auto within = [&](const Sphere& s) {
    const double r2 = (r - s.middle).squaredNorm(), left = s.radius * s.radius - r2;
    if (left <= 0) return false;
    const double rise = r2 / (s.radius + std::sqrt(left));  // of the sphere over its pole
    low = std::max(low, s.lowest + rise);
    high = std::min(high, s.highest - rise);
    return true;
  };
  if (v_.rod ? !rod_.within(r, low, high) : v_.oval ? !oval_.within(r, low, high) : !within(ball_)) return 0;
  if (v_.second.rod) {
    double from, to;
    return second_.within(r, from, to) ? std::max(0.0, std::min(high, to) - std::max(low, from)) : 0;
  }
  if (v_.other_radius > 0 && !within(other_)) return 0;
  const auto below = [&](const RoundVolume::Plane& plane) {
    const double room = plane.offset - plane.normal.head<2>().dot(r);
    if (plane.normal.z() > kEdgeOn) {
      high = std::min(high, room / plane.normal.z());
    } else if (plane.normal.z() < -kEdgeOn) {
      low = std::max(low, room / plane.normal.z());
    } else {
      return room >= 0;
    }
    return true;
  };
  const int planes = share == kAll ? v_.planes.size() : v_.planes_back;
  for (int i = 0; i < planes; ++i) {
    if (!below(v_.planes[i])) return 0;
  }
  if (share != kAll) below(v_.planes[share]);
  return std::max(0.0, high - low);
}

/// Of V at r along n [m]; 0 outside.
double RoundPatch::thickness(const Vector2& r, int share) const noexcept {
  return uniform_ > 0 ? uniform_ : scale_ * heightOver(r, share);
}

/// Along centre + t a the thickness of a ball has the root √(t₁ − t), t₁ ≥ 1 where the ray leaves its shadow. In t = s (1 + q (1 − s)) it
/// has none: t₁ − t is the square of √t₁ − s √q for this q = 1/(√t₁ + √(t₁ − 1))². Far from the root q is nearly 0. Of a rod: 0.
double RoundPatch::bendTowards(const Vector2& centre, const Vector2& a) const noexcept {
  if (v_.rod) return 0;
  const auto bend = [](const auto& from, const auto& along, double radius) {
    const double a2 = along.squaredNorm(), b = along.dot(from), square = b * b - a2 * (from.squaredNorm() - radius * radius);
    if (!(square > 0)) return 0.0;
    const double t = std::max(1.0, (std::sqrt(square) - b) / a2);
    return 1 / (2 * t - 1 + 2 * std::sqrt(t * (t - 1)));
  };
  if (v_.oval) return bend(Vector3(oval_.across * (centre - oval_.middle)), Vector3(oval_.across * a), oval_.radius);
  const double first = bend(Vector2(centre - ball_.middle), a, ball_.radius);
  return v_.other_radius > 0 ? std::max(first, bend(Vector2(centre - other_.middle), a, other_.radius)) : first;
}

/// Height along n of a plane over r [m].
double RoundPatch::levelOf(const RoundVolume::Plane& plane, const Vector2& r) const noexcept {
  return (plane.offset - plane.normal.head<2>().dot(r)) / plane.normal.z();
}

/// Over V's centroid, which is P's origin, twice V's moment about one plane has a closed form; other planes bound V over shares of
/// their own, where their distance from the first one is counted too much: ½ depth² of their shadow, or about that.
double RoundPatch::squaresBelow(const RoundVolume::Plane& main) const noexcept {
  double square = 2 * std::abs(levelOf(main, Vector2::Zero())) * contact_.volume;
  for (const RoundVolume::Share& share : v_.shares) {
    const RoundVolume::Plane& plane = v_.planes[share.plane];
    if (plane.normal == main.normal) continue;
    const bool small = 0.5 * contact_.depth * contact_.depth * share.shadow < kSmallShare * square;
    const auto remove = [&](const Vector2& r, double weight, double d) {
      square -= 2 * weight * d * std::abs(levelOf(plane, r) - levelOf(main, r));
    };
    eachSampleOf(share, remove, small);
  }
  return square;
}

/// Of the planes that bound V on the polyhedron's side, the one that is most nearly across n; null: V is bound otherwise.
const RoundVolume::Plane* RoundPatch::mainPlane() const noexcept {
  const RoundVolume::Plane* main = nullptr;
  for (const RoundVolume::Share& share : v_.shares) {
    if (share.plane < 0) return nullptr;
    const RoundVolume::Plane& plane = v_.planes[share.plane];
    if (!main || std::abs(plane.normal.z()) > std::abs(main->normal.z())) main = &plane;
  }
  return main;
}

double RoundPatch::thicknessSquared() noexcept {
  if (const RoundVolume::Plane* main = mainPlane()) return squaresBelow(*main);
  double square = 0, found = 0;
  if (v_.axial) {
    eachRing([&](double, double area, double d) {
      found += area * d;
      square += area * d * d;
    });
    const double scale = contact_.volume / found;
    if (resolves(found)) return scale * scale * square;
    square = 0;
  }
  fit();
  eachSample([&](const Vector2&, double weight, double d) { square += weight * d * d; });
  return square;
}

}  // namespace haptic
