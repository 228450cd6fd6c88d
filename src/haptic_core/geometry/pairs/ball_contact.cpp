#include "haptic_core/geometry/pairs/ball_contact.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/pairs/round_contact.h"
#include "haptic_core/geometry/volume/contact_moments.h"

namespace haptic {
namespace {

using Status = ContactVolume::Status;

}  // namespace

class BallContact : public RoundContact {
 public:
  using RoundContact::RoundContact;

  void balls(double ra, double rb, const Vector3& p_AB);
  /// The polyhedron is A, or B; `covers` are its own.
  void polyhedron(const ConvexPolyhedron& shape, bool is_a, double radius, const Pose& X_AB,
                  const InnerFaces* covers);
  /// The half-space is A, or B.
  void halfSpace(bool is_a, double radius, const Pose& X_AB);

 private:
  Vector3 place(bool is_a, double radius, const Pose& X_AB);
  void onOnePlane(const CutFace& face);
  void onFaces(const NearestPoint& nearest, const Vector3& c, const InnerFaces* covers);
  void withoutRoom(const NearestPoint& nearest);
};

void BallContact::balls(double ra, double rb, const Vector3& p_AB) {
  const double distance = p_AB.norm(), depth = ra + rb - distance;
  const Vector3 n = distance > 0 ? Vector3(p_AB / distance) : lastOr(Vector3::UnitZ());
  if (depth < 0) return setSeparated(n, -depth);
  const Vector3 normal = given_.squaredNorm() > 0 ? given_ : n;
  v_.radius = ra;
  v_.other_radius = rb;
  v_.other_Q = p_AB;
  v_.X_AQ = Pose();
  v_.sign = 1;
  v_.filled = true;
  if (distance <= std::abs(ra - rb)) {
    const double r = std::min(ra, rb);
    if (!(distance > 0)) out_.flags |= ContactVolume::kNormalFromHistory;
    const SolidMoments ball = SolidMoments::ofBall(r);
    setAxial(normal, n, rb <= ra ? p_AB : Vector3(Vector3::Zero()), ball.volume, ball.second(0, 0), 0, 2 * r);
    return;
  }
  // Heights of the caps over the plane of the circle in which the spheres meet.
  const double da = depth * (rb - ra + distance) / (2 * distance),
               db = depth * (ra - rb + distance) / (2 * distance);
  const CapMoments a(ra, da), b(rb, db);
  const double volume = a.volume + b.volume;
  if (!(volume > 0)) return setTouching(n, (ra - da) * n);
  v_.cut.addCircle(n, ra - da, ra);
  v_.axial = normal == n && !v_.cut.faces().empty();
  setAxial(normal, n, (ra - da + (a.z - b.z) / volume) * n, volume, a.across + b.across, da * (2 * ra - da),
           depth);
  if (!v_.axial) {
    // About another normal the moments along the axis count too.
    const double tilt = std::sqrt(std::max(0.0, 1 - normal.dot(n) * normal.dot(n)));
    out_.depth += 2 * std::min(ra, rb) * tilt;
  }
}

/// Frames, with the other shape as A or B. Returns the ball's centre in that shape's frame, whose axes Q has.
Vector3 BallContact::place(bool is_a, double radius, const Pose& X_AB) {
  v_.X_AQ = is_a ? Pose(Matrix3::Identity(), X_AB.p) : Pose(X_AB.R, Vector3::Zero());
  v_.sign = is_a ? 1 : -1;
  v_.radius = radius;
  return is_a ? X_AB.p : Vector3(-(X_AB.R.transpose() * X_AB.p));
}

void BallContact::halfSpace(bool is_a, double radius, const Pose& X_AB) {
  const double height = -place(is_a, radius, X_AB).z();  // of the plane over the centre
  const Vector3 n = v_.sign * v_.X_AQ.R.col(2);
  if (height <= -radius) return setSeparated(n, -height - radius);
  given_ = n;  // also where all of the ball lies below
  if (height >= radius) {
    if (setMoments(SolidMoments::ofBall(radius), Vector3::Zero(), Vector3::Zero(), n)) out_.depth = 2 * radius;
    return keep();
  }
  v_.cut.addCircle(Vector3::UnitZ(), height, radius);
  if (v_.cut.faces().empty()) return setCube(n, v_.X_AQ * Vector3(0, 0, 0.5 * (height - radius)), radius + height);
  onOnePlane(v_.cut.faces()[0]);
  if (out_.status == Status::kOverlap) keep();
}

void BallContact::polyhedron(const ConvexPolyhedron& shape, bool is_a, double radius, const Pose& X_AB,
                             const InnerFaces* covers) {
  const Vector3 c = place(is_a, radius, X_AB);
  if (cache_.direction.squaredNorm() > 0) {
    const Vector3 up = v_.sign * (v_.X_AQ.R.transpose() * cache_.direction);
    int& hint = is_a ? cache_.vertex_a : cache_.vertex_b;
    hint = shape.support(up, hint);
    const double gap = up.dot(c - shape.vertices()[hint]) - radius;
    if (gap > 0) return setSeparated(cache_.direction, gap);
  }
  if (!v_.cut.fits(shape)) return withoutRoom(nearestPoint(shape, c));
  const int beyond = v_.cut.cut(shape, c, radius);
  if (beyond >= 0) {
    const ConvexPolyhedron::Face& face = shape.faces()[beyond];
    const double gap = face.normal.dot(c) - face.offset - radius;
    return setSeparated(v_.sign * (v_.X_AQ.R * face.normal), gap);
  }
  const auto& faces = v_.cut.faces();
  const bool plain = faces.size() == 1 && faces[0].whole && !(given_.squaredNorm() > 0);
  if (plain && !(covers && covers->has(faces[0].index))) {
    onOnePlane(faces[0]);
  } else {
    const NearestPoint nearest = nearestPoint(shape, c);
    if (nearest.distance >= radius) {
      return setSeparated(-v_.sign * (v_.X_AQ.R * nearest.direction), nearest.distance - radius);
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
  if (!(cap.volume > 0)) return setTouching(n, v_.X_AQ.p + face.height * up);
  const Vector3 centroid = v_.X_AQ.p + (face.height - cap.z / cap.volume) * up;
  setAxial(n, n, centroid, cap.volume, cap.across, face.radius * face.radius, depth);
  v_.axial = true;
  v_.parts.push_back({face.normal, face.index, face.height, {}, 0, 0});
}

void BallContact::onFaces(const NearestPoint& nearest, const Vector3& c, const InnerFaces* covers) {
  const Vector3 o = nearest.distance * nearest.direction;  // in Q
  SolidMoments sums;
  for (const CutFace& face : v_.cut.faces()) {
    const PlaneMoments part = v_.cut.moments(face, o);
    v_.parts.push_back({face.normal, face.index, face.height, part, 0, 0});
    sums.addCone(part, face.height - face.normal.dot(o));
  }
  if (!v_.cut.faces().empty())
    addSphericalPart(v_.cut, nearest.direction, nearest.distance, sums);
  else if (nearest.distance == 0)
    sums = SolidMoments::ofBall(v_.radius);
  const Vector3 way_out_A = -v_.sign * (v_.X_AQ.R * nearest.direction);
  deep_ = v_.radius - nearest.distance;
  const Vector3 covered = coveredArea(v_.cut.faces(), covers, [&](const CutFace& face, const std::vector<Vector3>& outline) {
    return v_.cut.areaWithin(face, outline, c);
  });
  if (!setMoments(sums, o, covered, way_out_A)) return;
  out_.depth = v_.cut.extent(v_.X_AQ.R.transpose() * out_.normal());
  const Vector3 support = supportNormal();
  if (!support.isZero(0)) out_.depth = std::min(out_.depth, v_.cut.extent(support));
}

void BallContact::withoutRoom(const NearestPoint& nearest) {
  const double depth = v_.radius + nearest.depth - nearest.distance;
  const Vector3 n = -v_.sign * (v_.X_AQ.R * nearest.direction);
  if (!(depth > 0)) return setSeparated(n, -depth);
  setCube(n, v_.X_AQ * Vector3((nearest.distance + 0.5 * depth) * nearest.direction), depth);
}

void ballsContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                  ContactVolume& out) noexcept {
  BallContact(request, cache, workspace, out).balls(pair.A().ball()->radius(), pair.B().ball()->radius(), pair.X_AB.p);
}

void polyhedronBallContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                           ContactVolume& out) noexcept {
  BallContact(request, cache, workspace, out)
      .polyhedron(*pair.first.polyhedron(), !pair.turned, pair.second.ball()->radius(), pair.X_AB,
                  pair.turned ? request.inner.b : request.inner.a);
}

void halfSpaceBallContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                          ContactVolume& out) noexcept {
  BallContact(request, cache, workspace, out).halfSpace(!pair.turned, pair.second.ball()->radius(), pair.X_AB);
}

}  // namespace haptic
