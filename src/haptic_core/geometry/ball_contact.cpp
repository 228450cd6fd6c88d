#include "haptic_core/geometry/ball_contact.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/contact_moments.h"
#include "haptic_core/geometry/nearest_point.h"
#include "haptic_core/geometry/solid_moments.h"

namespace haptic {
namespace {

using Status = ContactVolume::Status;

/// |S| below this share of the faces' areas is a remainder, as in contact_moments.cpp.
constexpr double kVanishing = 1e-6;

Vector3 lastOr(const PairCache& cache, const Vector3& otherwise) {
  return cache.normal.squaredNorm() > 0 ? cache.normal : otherwise;
}

void setSeparated(const Vector3& direction_A, double gap, NormalRule rule, PairCache& cache,
                  ContactVolume& out) {
  out.status = Status::kSeparated;
  out.flags = 0;
  out.depth = std::min(0.0, -gap);
  cache.direction = direction_A;
  if (rule == NormalRule::kHistory) cache.normal = direction_A;
}

/// Common points, but no volume that rounding resolves.
void setTouching(const Vector3& normal_A, const Vector3& point_A, PairCache& cache, ContactVolume& out) {
  const unsigned flags = out.flags;
  out = ContactVolume{};
  out.flags = flags;
  out.status = Status::kTouching;
  out.X_AP = {patchAxes(normal_A), point_A};
  cache.normal = cache.direction = normal_A;
}

/// Round about `axis`, along which the patch of radius √r2 faces.
void setAxial(const Vector3& normal_A, const Vector3& axis_A, const Vector3& centroid_A, double volume,
              double across, double r2, double depth, PairCache& cache, ContactVolume& out) {
  const double area = M_PI * r2, seen = area * normal_A.dot(axis_A);
  out.status = Status::kOverlap;
  out.X_AP = {patchAxes(normal_A), centroid_A};
  out.area_vector_A = area * axis_A;
  out.volume = volume;
  out.V2 = across * Matrix2::Identity();
  out.A0 = seen;
  out.A1.setZero();
  out.A2 = 0.25 * seen * r2 * Matrix2::Identity();
  out.depth = depth;
  cache.normal = cache.direction = normal_A;
}

SolidMoments ballMoments(double radius) {
  SolidMoments m;
  m.volume = 4 * M_PI / 3 * radius * radius * radius;
  m.second = 0.2 * m.volume * radius * radius * Matrix3::Identity();
  return m;
}

}  // namespace

/// Fills the contact, and what the workspace keeps of V.
class BallContact {
 public:
  BallContact(NormalRule rule, PairCache& cache, ContactWorkspace& workspace, ContactVolume& out)
      : rule_(rule), cache_(cache), w_(workspace), v_(workspace.round_), out_(out) {
    workspace.clear();
    v_.cut.clear();
    v_.other_radius = 0;
    v_.axial = false;
    out.status = Status::kSeparated;
    out.flags = 0;
  }

  void balls(double ra, double rb, const Vector3& p_AB);
  /// The polyhedron is A, or B; `covers` are its own.
  void polyhedron(const ConvexPolyhedron& shape, bool is_a, double radius, const Pose& X_AB,
                  const InnerFaces* covers);

 private:
  void onOnePlane(const CutFace& face);
  void onFaces(const NearestPoint& nearest, const Vector3& c, const InnerFaces* covers);
  void withoutRoom(const NearestPoint& nearest);
  Vector3 coveredArea(const InnerFaces* covers, const Vector3& c);
  Vector3 normalOf(const Vector3& surface_A, double scale, const Vector3& otherwise);
  void projectFaces(const Vector3& from_o, const Matrix3& R_QP);
  double extent(const Vector3& up) const;
  void keep();

  NormalRule rule_;
  PairCache& cache_;
  ContactWorkspace& w_;
  RoundVolume& v_;
  ContactVolume& out_;
};

void BallContact::balls(double ra, double rb, const Vector3& p_AB) {
  const double distance = p_AB.norm(), depth = ra + rb - distance;
  const Vector3 n = distance > 0 ? Vector3(p_AB / distance) : lastOr(cache_, Vector3::UnitZ());
  if (depth < 0) return setSeparated(n, -depth, rule_, cache_, out_);
  const Vector3 normal = rule_ == NormalRule::kHistory ? lastOr(cache_, n) : n;
  v_.radius = ra;
  v_.other_radius = rb;
  v_.other_Q = p_AB;
  v_.X_AQ = Pose();
  v_.sign = 1;
  v_.filled = true;
  if (distance <= std::abs(ra - rb)) {
    const double r = std::min(ra, rb);
    if (!(distance > 0)) out_.flags |= ContactVolume::kNormalFromHistory;
    const SolidMoments ball = ballMoments(r);
    setAxial(normal, n, rb <= ra ? p_AB : Vector3(Vector3::Zero()), ball.volume, ball.second(0, 0), 0, 2 * r,
             cache_, out_);
    return;
  }
  // Heights of the caps over the plane of the circle in which the spheres meet.
  const double da = depth * (rb - ra + distance) / (2 * distance),
               db = depth * (ra - rb + distance) / (2 * distance);
  const CapMoments a(ra, da), b(rb, db);
  const double volume = a.volume + b.volume;
  if (!(volume > 0)) return setTouching(n, (ra - da) * n, cache_, out_);
  v_.cut.addCircle(n, ra - da, ra);
  v_.axial = normal == n;
  setAxial(normal, n, (ra - da + (a.z - b.z) / volume) * n, volume, a.across + b.across, da * (2 * ra - da),
           depth, cache_, out_);
  if (!v_.axial) {
    // About another normal the moments along the axis count too.
    const double tilt = std::sqrt(std::max(0.0, 1 - normal.dot(n) * normal.dot(n)));
    out_.depth += 2 * std::min(ra, rb) * tilt;
  }
}

void BallContact::polyhedron(const ConvexPolyhedron& shape, bool is_a, double radius, const Pose& X_AB,
                             const InnerFaces* covers) {
  // The ball's centre in the polyhedron's frame; Q has its axes.
  const Vector3 c = is_a ? X_AB.p : Vector3(-(X_AB.R.transpose() * X_AB.p));
  v_.X_AQ = is_a ? Pose(Matrix3::Identity(), X_AB.p) : Pose(X_AB.R, Vector3::Zero());
  v_.sign = is_a ? 1 : -1;
  v_.radius = radius;
  if (cache_.direction.squaredNorm() > 0) {
    const Vector3 up = v_.sign * (v_.X_AQ.R.transpose() * cache_.direction);
    int& hint = is_a ? cache_.vertex_a : cache_.vertex_b;
    hint = shape.support(up, hint);
    const double gap = up.dot(c - shape.vertices()[hint]) - radius;
    if (gap > 0) return setSeparated(cache_.direction, gap, rule_, cache_, out_);
  }
  if (!v_.cut.fits(shape)) return withoutRoom(nearestPoint(shape, c));
  const int beyond = v_.cut.cut(shape, c, radius);
  if (beyond >= 0) {
    const ConvexPolyhedron::Face& face = shape.faces()[beyond];
    const double gap = face.normal.dot(c) - face.offset - radius;
    return setSeparated(v_.sign * (v_.X_AQ.R * face.normal), gap, rule_, cache_, out_);
  }
  const auto& faces = v_.cut.faces();
  const bool plain = faces.size() == 1 && faces[0].whole && rule_ == NormalRule::kAreaVector;
  if (plain && !(covers && covers->has(faces[0].index))) {
    onOnePlane(faces[0]);
  } else {
    const NearestPoint nearest = nearestPoint(shape, c);
    if (nearest.distance >= radius) {
      return setSeparated(-v_.sign * (v_.X_AQ.R * nearest.direction), nearest.distance - radius, rule_,
                          cache_, out_);
    }
    onFaces(nearest, c, covers);
  }
  if (out_.status == Status::kOverlap) keep();
}

/// One cap: what most contacts are.
void BallContact::onOnePlane(const CutFace& face) {
  const double depth = v_.radius + face.height;
  const CapMoments cap(v_.radius, depth);
  const Vector3 up = v_.X_AQ.R * face.normal, n = v_.sign * up;
  if (!(cap.volume > 0)) return setTouching(n, v_.X_AQ.p + face.height * up, cache_, out_);
  const Vector3 centroid = v_.X_AQ.p + (face.height - cap.z / cap.volume) * up;
  setAxial(n, n, centroid, cap.volume, cap.across, face.radius * face.radius, depth, cache_, out_);
  v_.axial = true;
}

void BallContact::onFaces(const NearestPoint& nearest, const Vector3& c, const InnerFaces* covers) {
  const Vector3 o = nearest.distance * nearest.direction;  // in Q
  const Vector3 way_out_A = -v_.sign * (v_.X_AQ.R * nearest.direction);
  SolidMoments sums;
  Vector3 area_Q = Vector3::Zero();
  double scale = 0;
  v_.parts.clear();
  for (const CutFace& face : v_.cut.faces()) {
    const PlaneMoments part = v_.cut.moments(face, o);
    v_.parts.push_back(part);
    area_Q += part.area * face.normal;
    scale += part.area;
    sums.addCone(part, face.height - face.normal.dot(o));
  }
  if (!v_.cut.faces().empty())
    addSphericalPart(v_.cut, nearest.direction, nearest.distance, sums);
  else if (nearest.distance == 0)
    sums = ballMoments(v_.radius);
  if (!(sums.volume > 0)) return setTouching(way_out_A, v_.X_AQ * o, cache_, out_);
  const Vector3 covered_Q = coveredArea(covers, c), seen_Q = area_Q - covered_Q;
  out_.area_vector_A = v_.sign * (v_.X_AQ.R * area_Q);
  // Where nothing of the faces is surface, the whole of them stands in.
  const bool seen = seen_Q.norm() > kVanishing * scale;
  const Vector3 n =
      normalOf(seen ? Vector3(v_.sign * (v_.X_AQ.R * seen_Q)) : out_.area_vector_A, scale, way_out_A);
  const Vector3 centroid = sums.first / sums.volume;  // from o
  const Matrix3 R_AP = patchAxes(n), R_QP = v_.X_AQ.R.transpose() * R_AP;
  out_.status = Status::kOverlap;
  out_.X_AP = {R_AP, v_.X_AQ * (o + centroid)};
  out_.volume = sums.volume;
  const Matrix3 about_centroid = sums.second - sums.volume * centroid * centroid.transpose();
  out_.V2 = (R_QP.transpose() * about_centroid * R_QP).topLeftCorner<2, 2>();
  projectFaces(centroid, R_QP);
  out_.depth = extent(R_QP.col(2));
  cache_.normal = cache_.direction = n;
}

/// A0, A1 and A2: the faces' parts seen along n, from the centroid.
void BallContact::projectFaces(const Vector3& centroid, const Matrix3& R_QP) {
  double area = 0;
  Vector3 first = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();
  for (int f = 0; f < v_.parts.size(); ++f) {
    const PlaneMoments& part = v_.parts[f];
    const double rise = v_.sign * v_.cut.faces()[f].normal.dot(R_QP.col(2));
    area += rise * part.area;
    first += rise * (part.first - part.area * centroid);
    const Matrix3 mixed = part.first * centroid.transpose();
    second += rise * (part.second - mixed - mixed.transpose() + part.area * centroid * centroid.transpose());
  }
  out_.A0 = area;
  out_.A1 = (R_QP.transpose() * first).head<2>();
  out_.A2 = (R_QP.transpose() * second * R_QP).topLeftCorner<2, 2>();
}

/// V's extent along `up`: to the sphere's pole, or where that is cut off to the faces' outlines.
double BallContact::extent(const Vector3& up) const {
  double sum = 0;
  for (const Vector3& way : {up, Vector3(-up)}) {
    const Vector3 pole = v_.radius * way;
    double reach = -v_.radius;
    bool pole_inside = true;
    for (const CutFace& face : v_.cut.faces()) {
      pole_inside &= face.normal.dot(pole) <= face.height;
      const Vector2 slope(face.x.dot(way), face.y.dot(way));
      const double middle = face.height * face.normal.dot(way);
      for (int i = face.first; i < face.first + face.count; ++i) {
        reach = std::max(reach, middle + v_.cut.curves()[i].reach(slope, face.radius));
      }
    }
    sum += pole_inside ? v_.radius : std::min(v_.radius, reach);
  }
  return sum;
}

/// Where pieces of the polyhedron's body cover it: area vector, outward, in Q.
Vector3 BallContact::coveredArea(const InnerFaces* covers, const Vector3& c) {
  Vector3 sum = Vector3::Zero();
  if (!covers) return sum;
  for (const CutFace& face : v_.cut.faces()) {
    if (!covers->has(face.index)) continue;
    for (const InnerFaces::Cover& cover : covers->covers) {
      if (cover.face != face.index) continue;
      const double area = v_.cut.areaWithin(face, cover.outline, c);
      if (!(area > 0)) continue;
      sum += area * face.normal;
      out_.flags |= ContactVolume::kOnSeam;
    }
  }
  return sum;
}

Vector3 BallContact::normalOf(const Vector3& surface_A, double scale, const Vector3& otherwise) {
  if (rule_ == NormalRule::kHistory && cache_.normal.squaredNorm() > 0) return cache_.normal;
  const double size = surface_A.norm();
  if (size > kVanishing * scale) return surface_A / size;
  out_.flags |= ContactVolume::kNormalFromHistory;
  return lastOr(cache_, otherwise);
}

/// A polyhedron that the workspace was not made for: a cube as deep as the shortest way out stands for V, so
/// that the pair still pushes apart.
void BallContact::withoutRoom(const NearestPoint& nearest) {
  const double depth = v_.radius + nearest.depth - nearest.distance;
  const Vector3 n = -v_.sign * (v_.X_AQ.R * nearest.direction);
  if (!(depth > 0)) return setSeparated(n, -depth, rule_, cache_, out_);
  out_.flags |= ContactVolume::kCapacityExceeded;
  const double r2 = depth * depth / M_PI;
  setAxial(n, n, v_.X_AQ * Vector3((nearest.distance + 0.5 * depth) * nearest.direction),
           depth * depth * depth, depth * depth * depth * r2 / 4, r2, depth, cache_, out_);
}

void BallContact::keep() {
  v_.filled = true;
  for (const CutFace& face : v_.cut.faces()) {
    const Vector3 normal = v_.X_AQ.R * face.normal;
    w_.faces_.push_back(
        {normal, face.height + normal.dot(v_.X_AQ.p), face.index, v_.sign > 0 ? Owner::kA : Owner::kB});
  }
}

void roundContact(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, PairCache& cache,
                  ContactWorkspace& workspace, ContactVolume& out, NormalRule rule,
                  const InnerSides& inner) noexcept {
  BallContact contact(rule, cache, workspace, out);
  if (!A.ball()) {
    contact.polyhedron(*A.polyhedron(), true, B.ball()->radius(), X_AB, inner.a);
  } else if (!B.ball()) {
    contact.polyhedron(*B.polyhedron(), false, A.ball()->radius(), X_AB, inner.b);
  } else {
    contact.balls(A.ball()->radius(), B.ball()->radius(), X_AB.p);
  }
}

}  // namespace haptic
