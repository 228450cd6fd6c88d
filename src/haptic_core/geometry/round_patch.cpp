#include "haptic_core/geometry/round_patch.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/contact_volume.h"
#include "haptic_core/geometry/rod.h"

namespace haptic {
namespace {

/// Faces flatter than this against n have no share of the patch worth integrating.
constexpr double kEdgeOn = 1e-9;
/// Sine of an angle to n that is rounding.
constexpr double kOnePlane = 1e-12;
/// The patch stands for V while the samples find at least this share of it, and at most its inverse. Else V
/// folds over (a ball more than half inside, a plate through a ball), and an ellipse of V's moments stands
/// in.
constexpr double kFound = 0.5;

/// The outline becomes an ellipse with second moments C about its middle, for a unit of its area, which is returned.
double setEllipse(RoundVolume& v, const Vector2& middle, const Matrix2& C) {
  const double mean = 0.5 * (C(0, 0) + C(1, 1)), half = 0.5 * (C(0, 0) - C(1, 1)), root = std::hypot(half, C(0, 1));
  const double angle = root > 0 ? 0.5 * std::atan2(C(0, 1), half) : 0;
  const double a = 2 * std::sqrt(std::max(0.0, mean + root)), b = 2 * std::sqrt(std::max(0.0, mean - root));
  const Vector2 along(std::cos(angle), std::sin(angle)), across(-along.y(), along.x());
  v.curves.clear();
  v.shares.clear();
  v.curves.push_back({true, 0, 2 * M_PI, middle, a * along, v.sign * b * across, Vector2::Zero()});
  v.shares.push_back({0, 1, middle, -1});
  return M_PI * a * b;
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

RoundPatch::RoundPatch(RoundVolume& v, const ContactVolume& contact) noexcept : v_(v), contact_(contact) {
  const Pose X_PQ = contact.X_AC().inverse() * v.X_AQ;
  ball_ = sphereAt(X_PQ.p, v.radius);
  v.curves.clear();
  v.shares.clear();
  v.planes.clear();
  if (v.rod) {
    rod_centre_ = X_PQ.p;
    rod_axis_ = X_PQ.R.col(2);
    if (v.other_radius > 0) {
      // A ball on a rod: nearly an ellipse.
      other_ = sphereAt(X_PQ * v.other_Q, v.other_radius);
      const Vector2 middle = contact.A0 > 0 ? Vector2(contact.A1 / contact.A0) : Vector2(Vector2::Zero());
      setEllipse(v, middle, contact.A0 > 0 ? Matrix2(contact.A2 / contact.A0 - middle * middle.transpose()) : Matrix2(Matrix2::Zero()));
      return;
    }
    addShares(v.parts, X_PQ, true);
    return;
  }
  if (v.other_radius > 0) other_ = sphereAt(X_PQ * v.other_Q, v.other_radius);
  addShares(v.cut.faces(), X_PQ, !(v.other_radius > 0));
}

/// Faces that look back first, then those that look on: over the share of one of these it alone bounds V on that side.
template <class Faces>
void RoundPatch::addShares(const Faces& faces, const Pose& X_PQ, bool planar) noexcept {
  for (const bool on : {false, true}) {
    for (const auto& face : faces) {
      const Vector3 normal = X_PQ.R * face.normal;
      if ((v_.sign * normal.z() > kEdgeOn) != on) continue;
      if (planar) v_.planes.push_back({normal, heightOf(face) + normal.dot(X_PQ.p)});
      if (on) addShare(face, X_PQ.R, X_PQ.p, planar ? v_.planes.size() - 1 : kAll);
    }
    if (!on) v_.planes_back = v_.planes.size();
  }
}

void RoundPatch::addShare(const RoundVolume::FacePart& part, const Matrix3& R, const Vector3& p, int plane) noexcept {
  RoundVolume::Share share{v_.curves.size(), part.count, Vector2::Zero(), plane};
  const auto flat = [&](const Vector3& x) -> Vector2 { return (R * x).head<2>(); };
  for (int i = part.first; i < part.first + part.count; ++i) {
    const RoundVolume::Rim& rim = v_.rims[i];
    const RoundVolume::Curve curve{rim.arc, rim.from, rim.sweep, flat(rim.middle) + p.head<2>(), flat(rim.x), flat(rim.y), flat(rim.rise)};
    Vector2 rate;
    share.inside += curve.at(0.5, rate) / part.count;
    v_.curves.push_back(curve);
  }
  v_.shares.push_back(share);
}

void RoundPatch::addShare(const CutFace& face, const Matrix3& R, const Vector3& p, int plane) noexcept {
  const Vector2 middle = (R * (face.height * face.normal) + p).head<2>(), x = (R * face.x).head<2>(),
                y = (R * face.y).head<2>();
  RoundVolume::Share share{v_.curves.size(), face.count, middle, plane};
  if (!face.whole) share.inside.setZero();
  for (int i = 0; i < face.count; ++i) {
    const CutCurve& c = v_.cut.curves()[face.first + i];
    const Vector2 from = middle + c.p.x() * x + c.p.y() * y, to = middle + c.q.x() * x + c.q.y() * y;
    if (!face.whole) share.inside += from / face.count;
    if (c.arc) {
      v_.curves.push_back({true, c.from, c.sweep, middle, face.radius * x, face.radius * y, Vector2::Zero()});
    } else {
      v_.curves.push_back({false, 0, 1, from, to - from, Vector2::Zero(), Vector2::Zero()});
    }
  }
  v_.shares.push_back(share);
}

bool RoundPatch::resolves(double found) const noexcept {
  return found > kFound * contact_.volume && kFound * found < contact_.volume;
}

/// Σ weight · d = Vol: what the rule misses of it is spread over the patch.
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

/// Where the line over r runs in the rod; false: nowhere. Lower and higher end of what it has in common with the tube between the
/// ends' planes, and with balls about them.
bool RoundPatch::withinRod(const Vector2& r, double& low, double& high) const noexcept {
  const double u = rod_axis_.z(), half = v_.rod->halfLength(), R = v_.radius;
  const Vector3 y(r.x() - rod_centre_.x(), r.y() - rod_centre_.y(), -rod_centre_.z());  // from the centre, at z = 0
  const double along = rod_axis_.dot(y);
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
  const Vector3 across = y - along * rod_axis_;
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
  for (int end = -1; end <= 1 && v_.rod->isCapsule(); end += 2) {
    const Vector3 from = y - end * half * rod_axis_;
    if (roots(1, from.z(), (from.norm() - R) * (from.norm() + R), z0, z1)) low = std::min(low, z0), high = std::max(high, z1);
  }
  return low < high;
}

/// Height of V over r, of what is not scaled; r lies in the share of that plane, or anywhere.
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
  if (v_.rod ? !withinRod(r, low, high) : !within(ball_)) return 0;
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

/// Whether all of the polyhedron's surface in V is one plane across n; its height over V's centroid.
bool RoundPatch::onOneFace(double& height) const noexcept {
  if (v_.planes.empty()) return false;
  const RoundVolume::Plane& first = v_.planes[0];
  for (const RoundVolume::Plane& plane : v_.planes) {
    if (plane.normal != first.normal) return false;
  }
  height = std::abs(first.offset);
  return first.normal.head<2>().norm() < kOnePlane;
}

double RoundPatch::thicknessSquared() noexcept {
  double square = 0, found = 0, height;
  if (onOneFace(height)) return 2 * height * contact_.volume;
  if (v_.axial) {
    eachRing([&](double, double area, double d) {
      found += area * d;
      square += area * d * d;
    });
    const double scale = contact_.volume / found;
    if (resolves(found)) return scale * scale * square;
    square = 0;
  } else if (std::isnan(v_.sampled)) {  // what `fit` samples is all that it takes: each height costs a look at every plane
    found = 0;
    eachSample([&](const Vector2&, double weight, double d) {
      found += weight * d;
      square += weight * d * d;
    });
    v_.sampled = found;
    fit();
    if (!(uniform_ > 0)) return scale_ * scale_ * square;
    square = 0;
  }
  fit();
  eachSample([&](const Vector2&, double weight, double d) { square += weight * d * d; });
  return square;
}

}  // namespace haptic
