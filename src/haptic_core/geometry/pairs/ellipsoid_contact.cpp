#include "haptic_core/geometry/pairs/ellipsoid_contact.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/pairs/round_contact.h"
#include "haptic_core/geometry/shapes/ellipsoid.h"

namespace haptic {

/// Frame Q is the ellipsoid's; y are coordinates in which it is a ball.
class EllipsoidContact : public RoundContact {
 public:
  /// The other shape is A, or B.
  EllipsoidContact(const Ellipsoid& shape, bool other_is_a, const Pose& X_AB, const ContactRequest& request, PairCache& cache,
                   ContactWorkspace& workspace, ContactVolume& out)
      : RoundContact(request, cache, workspace, out), shape_(shape), other_is_a_(other_is_a) {
    v_.X_AQ = other_is_a ? X_AB : Pose();
    v_.sign = other_is_a ? 1 : -1;
    v_.radius = elementary::cbrt(shape.radii().prod());
    v_.oval = true;
    v_.stretch = shape.radii() / v_.radius;
    X_QO_ = other_is_a ? X_AB.inverse() : X_AB;
    X_AO_ = other_is_a ? Pose() : X_AB;
  }

  void halfSpace();
  void polyhedron(const ConvexPolyhedron& other);

 private:
  /// A plane of the other shape about the ellipsoid: outward normal in Q, offset [m].
  struct Plane {
    Vector3 normal;
    double offset;
  };
  Plane planeAt(const Vector3& normal_O, double offset) const {
    const Vector3 normal = X_QO_.R * normal_O;
    return {normal, offset + normal.dot(X_QO_.p)};
  }
  double reachAlong(const Vector3& n_Q) const { return shape_.radii().cwiseProduct(n_Q).norm(); }
  /// A vector of area, or a normal times something, from y to Q.
  Vector3 areaFrom(const Vector3& a_y) const { return a_y.cwiseQuotient(v_.stretch); }
  SolidMoments stretched(const SolidMoments& y) const;
  PlaneMoments stretched(const PlaneMoments& y, double size) const;
  SolidMoments cap(const CutFace& face, double depth) const;
  void onOnePlane(const Plane& plane, double depth, const Vector3& up_A, const InnerFaces* covers);
  void onFaces(const NearestPoint& nearest, const InnerFaces* covers);
  void addPart(const CutFace& face, const PlaneMoments& y);
  void withoutRoom(const ConvexPolyhedron& other);
  Vector3 covered(const InnerFaces* covers);
  bool fits(const ConvexPolyhedron& other) const;
  void mapOther(const ConvexPolyhedron& other);
  double extent(const Vector3& up_Q) const;

  const Ellipsoid& shape_;
  bool other_is_a_;
  Pose X_QO_, X_AO_;  ///< of the other shape
};

SolidMoments EllipsoidContact::stretched(const SolidMoments& y) const {
  const Vector3& m = v_.stretch;
  return {y.volume, m.cwiseProduct(y.first), (m * m.transpose()).cwiseProduct(y.second)};
}

PlaneMoments EllipsoidContact::stretched(const PlaneMoments& y, double size) const {
  const Vector3& m = v_.stretch;
  return {size * y.area, size * m.cwiseProduct(y.first), size * (m * m.transpose()).cwiseProduct(y.second)};
}

/// Of a cap as deep as `depth` in y, about the middle of its flat side.
SolidMoments EllipsoidContact::cap(const CutFace& face, double depth) const {
  const CapMoments cap(v_.radius, depth);
  const Vector3& n = face.normal;
  const double along = M_PI * depth * depth * depth * depth * (v_.radius / 6 - depth / 30);  // ∫ z²
  return {cap.volume, -cap.z * n, cap.across * Matrix3::Identity() + (along - cap.across) * n * n.transpose()};
}

void EllipsoidContact::addPart(const CutFace& face, const PlaneMoments& y) {
  const Vector3 normal = areaFrom(face.normal);
  const double size = normal.norm();
  v_.parts.push_back({normal / size, face.index, face.height / size, stretched(y, size), 0, 0});
}

Vector3 EllipsoidContact::covered(const InnerFaces* covers) {
  const Vector3 sum_y = coveredArea(v_.cut.faces(), covers, [&](const CutFace& face, const std::vector<Vector3>& whole) {
    LoadedVector<Vector3>& outline = scratchOutline();
    outline.clear();
    for (const Vector3& x : whole) outline.push_back((X_QO_ * x).cwiseQuotient(v_.stretch));
    return v_.cut.areaWithin(face, outline, Vector3::Zero());
  });
  return areaFrom(sum_y);
}

/// One cap, `depth` deep: what most contacts are. `up_A`: the plane's normal as its shape has it, free of what turning it costs.
void EllipsoidContact::onOnePlane(const Plane& plane, double depth, const Vector3& up_A, const InnerFaces* covers) {
  const CutFace& face = v_.cut.faces()[0];
  const Vector3 n = v_.sign * up_A, o_y = face.height * face.normal;
  const double size = v_.stretch.cwiseProduct(plane.normal).norm();
  v_.parts.push_back({plane.normal, face.index, plane.offset, stretched(v_.cut.moments(face, o_y), 1 / size), 0, 0});
  if (!(given_.squaredNorm() > 0)) given_ = n;
  deep_ = depth;
  if (!setMoments(stretched(cap(face, depth / size)), v_.stretch.cwiseProduct(o_y), covered(covers), n)) return;
  out_.depth = n == given_ ? depth : std::min(extent(v_.X_AQ.R.transpose() * out_.normal()), depth);
  keep();
}

void EllipsoidContact::halfSpace() {
  const Plane plane = planeAt(Vector3::UnitZ(), 0);
  const Vector3 up_A = X_AO_.R.col(2), n = v_.sign * up_A;
  const double reach = reachAlong(plane.normal), depth = plane.offset + reach;
  if (depth < 0) return setSeparated(n, -depth);
  given_ = n;  // also where all of the ellipsoid lies below
  if (plane.offset >= reach) {
    if (setMoments(stretched(SolidMoments::ofBall(v_.radius)), Vector3::Zero(), Vector3::Zero(), n)) out_.depth = 2 * reach;
    return keep();
  }
  const Vector3 normal_y = v_.stretch.cwiseProduct(plane.normal);
  const double size = normal_y.norm();
  v_.cut.addCircle(normal_y / size, plane.offset / size, v_.radius);
  if (v_.cut.faces().empty()) return setCube(n, v_.X_AQ * ((plane.offset - 0.5 * depth) * plane.normal), depth);
  onOnePlane(plane, depth, up_A, nullptr);
}

bool EllipsoidContact::fits(const ConvexPolyhedron& other) const {
  const CutSolid& solid = w_.solid();
  return v_.cut.fits(other) && solid.points.capacity() >= other.vertexCount() && solid.faces.capacity() >= other.faceCount() &&
         solid.loop.capacity() >= 2 * other.edgeCount();
}

/// The other shape in y, as a solid of the workspace.
void EllipsoidContact::mapOther(const ConvexPolyhedron& other) {
  CutSolid& solid = scratchSolid();
  solid.points.clear(), solid.faces.clear(), solid.loop.clear();
  for (const Vector3& x : other.vertices()) solid.points.push_back((X_QO_ * x).cwiseQuotient(v_.stretch));
  for (int f = 0; f < other.faceCount(); ++f) {
    const ConvexPolyhedron::Face& face = other.faces()[f];
    const Plane plane = planeAt(face.normal, face.offset);
    const Vector3 normal = v_.stretch.cwiseProduct(plane.normal);
    const double size = normal.norm();
    const ContactFace mapped{normal / size, plane.offset / size, f, other_is_a_ ? Owner::kA : Owner::kB};
    solid.faces.push_back({mapped, face.first, face.count});
    for (int h = face.first; h < face.first + face.count; ++h) solid.loop.push_back(other.loopVertex(h));
  }
}

void EllipsoidContact::polyhedron(const ConvexPolyhedron& other) {
  if (cache_.direction.squaredNorm() > 0) {
    const Vector3 up_Q = v_.sign * (v_.X_AQ.R.transpose() * cache_.direction), up_O = X_QO_.R.transpose() * up_Q;
    int& hint = other_is_a_ ? cache_.vertex_a : cache_.vertex_b;
    hint = other.support(up_O, hint);
    const double gap = -up_Q.dot(X_QO_ * other.vertices()[hint]) - reachAlong(up_Q);
    if (gap > 0) return setSeparated(cache_.direction, gap);
  }
  const InnerFaces* covers = other_is_a_ ? request_.inner.a : request_.inner.b;
  if (!fits(other)) return withoutRoom(other);
  mapOther(other);
  const int beyond = v_.cut.cut(w_.solid(), Vector3::Zero(), v_.radius);
  if (beyond >= 0) {
    const Plane plane = planeAt(other.faces()[beyond].normal, other.faces()[beyond].offset);
    return setSeparated(v_.sign * (X_AO_.R * other.faces()[beyond].normal), std::max(0.0, -plane.offset - reachAlong(plane.normal)));
  }
  const auto& faces = v_.cut.faces();
  if (faces.size() == 1 && faces[0].whole) {
    const ConvexPolyhedron::Face& face = other.faces()[faces[0].index];
    const Plane plane = planeAt(face.normal, face.offset);
    return onOnePlane(plane, std::max(0.0, plane.offset + reachAlong(plane.normal)), X_AO_.R * face.normal, covers);
  }
  const NearestPoint nearest = nearestPoint(w_.solid(), v_.radius, Vector3::Zero());
  if (nearest.distance >= v_.radius) {
    const Vector3 way = areaFrom(nearest.direction);
    const double size = way.norm();
    return setSeparated(-v_.sign * (v_.X_AQ.R * (way / size)), (nearest.distance - v_.radius) / size);
  }
  onFaces(nearest, covers);
}

void EllipsoidContact::onFaces(const NearestPoint& nearest, const InnerFaces* covers) {
  const Vector3 o_y = nearest.distance * nearest.direction, way = areaFrom(nearest.direction).normalized();
  SolidMoments sums;
  for (const CutFace& face : v_.cut.faces()) {
    const PlaneMoments part = v_.cut.moments(face, o_y);
    addPart(face, part);
    sums.addCone(part, face.height - face.normal.dot(o_y));
  }
  if (!v_.cut.faces().empty())
    addSphericalPart(v_.cut, nearest.direction, nearest.distance, sums);
  else if (nearest.distance == 0)
    sums = SolidMoments::ofBall(v_.radius);
  if (!setMoments(stretched(sums), v_.stretch.cwiseProduct(o_y), covered(covers), -v_.sign * (v_.X_AQ.R * way))) return;
  out_.depth = extent(v_.X_AQ.R.transpose() * out_.normal());
  const Vector3 support = supportNormal();
  if (!support.isZero(0)) out_.depth = std::min(out_.depth, extent(support));
  keep();
}

/// V's extent along a direction, which is another one in y.
double EllipsoidContact::extent(const Vector3& up_Q) const {
  const Vector3 up_y = v_.stretch.cwiseProduct(up_Q);
  const double size = up_y.norm();
  return size * v_.cut.extent(up_y / size);
}

/// The least overlap along a face's normal.
void EllipsoidContact::withoutRoom(const ConvexPolyhedron& other) {
  double depth = INFINITY;
  Plane least{Vector3::UnitZ(), 0};
  for (const ConvexPolyhedron::Face& face : other.faces()) {
    const Plane plane = planeAt(face.normal, face.offset);
    const double overlap = plane.offset + reachAlong(plane.normal);
    if (overlap < depth) depth = overlap, least = plane;
  }
  const Vector3 n = v_.sign * (v_.X_AQ.R * least.normal);
  if (!(depth > 0)) return setSeparated(n, -depth);
  setCube(n, v_.X_AQ * ((least.offset - 0.5 * depth) * least.normal), depth);
}

void halfSpaceEllipsoidContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                               ContactVolume& out) noexcept {
  EllipsoidContact(*pair.second.ellipsoid(), !pair.turned, pair.X_AB, request, cache, workspace, out).halfSpace();
}

void polyhedronEllipsoidContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                                ContactVolume& out) noexcept {
  EllipsoidContact(*pair.second.ellipsoid(), !pair.turned, pair.X_AB, request, cache, workspace, out)
      .polyhedron(*pair.first.polyhedron());
}

}  // namespace haptic
