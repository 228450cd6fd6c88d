#include "haptic_core/geometry/pairs/rod_contact.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/pairs/round_contact.h"
#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/volume/tube_on_plane.h"
#include "haptic_core/geometry/volume/volume_cutting.h"

namespace haptic {
namespace {

using Status = ContactVolume::Status;

/// A box around a piece is this many radii wide: its sides touch nothing.
constexpr double kRoom = 2;
/// 1 - cosine of an angle that changes an extent by no more than rounding does.
constexpr double kSame = 1e-15;

}  // namespace

class RodContact : public RoundContact {
 public:
  using RoundContact::RoundContact;

  /// The polyhedron is A, or B; `covers` are its own.
  void polyhedron(const ConvexPolyhedron& shape, bool is_a, const Rod& rod, const Pose& X_AB, const InnerFaces* covers);
  /// The half-space is A, or B.
  void halfSpace(bool is_a, const Rod& rod, const Pose& X_AB);

 private:
  void place(bool is_a, const Rod& rod, const Pose& X_AB);
  bool reaches(const Vector3& normal, double offset, int index, Owner owner);
  bool measure(int planes, const InnerFaces* covers);
  bool findPlanes(const ConvexPolyhedron& shape, bool is_a);
  bool cutBox(double low, double high, double from, double to);
  bool onOnePlane(const InnerFaces* covers) const;
  bool addTubeOnPlane();
  void addTube(const InnerFaces* covers);
  bool cutHalfBall(const Vector3& k, const ContactFace& plane, double height, NearestPoint& nearest);
  void addHalfBall(double end, const InnerFaces* covers);
  void addPiece(const SolidMoments& piece, const Vector3& o);
  void addPart(const Vector3& normal, double offset, int index, const PlaneMoments& moments, const Vector3& o, int first_rim);
  double reach(const Vector3& way) const;
  double extent(const Vector3& up) const;

  const Rod* rod_ = nullptr;
  Pose X_QS_;                         ///< of the polyhedron in the rod's frame
  Vector3 way_out_Q_ = Vector3::UnitZ();  ///< for the rod
  double way_ = INFINITY;             ///< how far [m]
  Vector3 o_ = Vector3::Zero();       ///< the point about which the pieces are summed
  SolidMoments sums_;
  Vector3 covered_Q_ = Vector3::Zero();
  bool end_inside_[2] = {false, false};  ///< whether some of the disc at the lower and the upper end of the axis lies in V
  bool complete_ = true;
};

/// Frames, with the other shape as A or B.
void RodContact::place(bool is_a, const Rod& rod, const Pose& X_AB) {
  rod_ = v_.rod = &rod;
  X_QS_ = is_a ? X_AB.inverse() : X_AB;
  v_.X_AQ = is_a ? X_AB : Pose();
  v_.sign = is_a ? 1 : -1;
  v_.radius = rod.radius();
  v_.rims.clear();
  v_.near.clear();
}

void RodContact::halfSpace(bool is_a, const Rod& rod, const Pose& X_AB) {
  place(is_a, rod, X_AB);
  const Vector3 normal = X_QS_.R.col(2);
  given_ = v_.sign * (v_.X_AQ.R * normal);  // also where all of the rod lies below
  if (reaches(normal, normal.dot(X_QS_.p), 0, is_a ? Owner::kA : Owner::kB)) measure(1, nullptr);
}

void RodContact::polyhedron(const ConvexPolyhedron& shape, bool is_a, const Rod& rod, const Pose& X_AB,
                            const InnerFaces* covers) {
  place(is_a, rod, X_AB);
  if (cache_.direction.squaredNorm() > 0) {
    const Vector3 up = v_.sign * (v_.X_AQ.R.transpose() * cache_.direction), up_S = X_QS_.R.transpose() * up;
    int& hint = is_a ? cache_.vertex_a : cache_.vertex_b;
    hint = shape.support(up_S, hint);
    const double gap = up.dot(rod.core(-up) - X_QS_ * shape.vertices()[hint]) - rod.rounding();
    if (gap > 0) return setSeparated(cache_.direction, gap);
  }
  if (!findPlanes(shape, is_a) || measure(shape.faceCount(), covers)) return;
  // Nothing found: nearly always separated, which a direction must prove.
  ClosestPoints near;
  const Pose X_SQ = X_QS_.inverse();
  closestPoints(shape, rod, X_SQ, X_QS_.R.transpose() * way_out_Q_, near);
  const Vector3 direction_A = v_.sign * (v_.X_AQ.R * (X_QS_.R * near.direction));
  if (near.separated) return setSeparated(direction_A, near.distance);
  out_.X_AP.p = v_.X_AQ * (X_QS_ * near.p_A);
}

/// V of what `near` leaves of the rod; there are so many planes. False: nothing was found.
bool RodContact::measure(int planes, const InnerFaces* covers) {
  const Vector3 way_out_A = v_.sign * (v_.X_AQ.R * way_out_Q_);
  const Vector3 lowest = rod_->core(-way_out_Q_) - rod_->rounding() * way_out_Q_;
  if (v_.near.capacity() < planes || w_.solid().faces.capacity() < planes + 6) {
    setCube(way_out_A, v_.X_AQ * Vector3(lowest + 0.5 * way_ * way_out_Q_), way_);
    return true;
  }
  deep_ = way_;
  if (!onOnePlane(covers) || !addTubeOnPlane()) addTube(covers);
  if (rod_->isCapsule()) {
    addHalfBall(-1, covers);
    addHalfBall(1, covers);
  }
  if (!complete_) out_.flags |= ContactVolume::kCapacityExceeded;
  if (!setMoments(sums_, o_, covered_Q_, way_out_A)) return false;
  const Vector3 up = v_.X_AQ.R.transpose() * out_.normal();
  const bool one_plane = v_.near.size() == 1 && std::abs(up.dot(v_.near[0].normal)) > 1 - kSame;
  out_.depth = one_plane ? std::min(way_, 2 * (rod_->core(up).dot(up) + rod_->rounding())) : extent(up);
  const Vector3 support = supportNormal();
  if (!one_plane && !support.isZero(0)) out_.depth = std::min(out_.depth, extent(support));
  keep();
  return true;
}

/// Keeps a plane that reaches the rod, in its frame; first the one that leaves least of it, so that cuts begin with the deepest.
/// False: the rod lies beyond, and they are separated.
bool RodContact::reaches(const Vector3& normal, double offset, int index, Owner owner) {
  const double reach = normal.dot(rod_->core(normal)) + rod_->rounding();
  // The rod is symmetric about its centre: it goes as far the other way.
  if (offset + reach <= 0) {
    setSeparated(v_.sign * (v_.X_AQ.R * normal), -offset - reach);
    return false;
  }
  const bool least = offset + reach < way_;
  if (least) way_ = offset + reach, way_out_Q_ = normal;
  if (reach > offset && v_.near.push_back({normal, offset, index, owner}) && least) {
    std::swap(v_.near[0], v_.near[v_.near.size() - 1]);
  }
  return true;
}

/// The polyhedron's planes that reach the rod, in its frame. False: one has it beyond, and they are separated.
bool RodContact::findPlanes(const ConvexPolyhedron& shape, bool is_a) {
  for (int f = 0; f < shape.faceCount(); ++f) {
    const ConvexPolyhedron::Face& face = shape.faces()[f];
    const Vector3 normal = X_QS_.R * face.normal;
    if (!reaches(normal, face.offset + normal.dot(X_QS_.p), f, is_a ? Owner::kA : Owner::kB)) return false;
  }
  return true;
}

/// A box around the part of the rod from `low` to `high`, where its axis goes `from`…`to`, cut by the planes. False: nothing is left.
bool RodContact::cutBox(double low, double high, double from, double to) {
  const double R = v_.radius, middle = 0.5 * (from + to), half = 0.5 * (to - from);
  const bool tube = half > 0;
  const auto heightOver = [&](const ContactFace& plane) { return plane.offset - plane.normal.z() * middle; };
  const auto reachOf = [&](const ContactFace& plane) {
    return R * (tube ? plane.normal.head<2>().norm() : 1) + half * std::abs(plane.normal.z());
  };
  for (const ContactFace& plane : v_.near) {
    if (heightOver(plane) <= -reachOf(plane)) return false;
  }
  ConvexShape::Box left{Vector3(-kRoom * R, -kRoom * R, low), Vector3(kRoom * R, kRoom * R, high)};
  startBox(left.lower, left.upper, w_);
  for (const ContactFace& plane : v_.near) {
    const Vector3 outer = (plane.normal.array() > 0).select(left.upper, left.lower);
    if (plane.normal.dot(outer) <= plane.offset || heightOver(plane) >= reachOf(plane)) continue;
    if (!cutSolid(plane, w_, complete_)) return false;
    left = {Vector3::Constant(INFINITY), Vector3::Constant(-INFINITY)};
    for (const Vector3& x : w_.solid().points) left = {left.lower.cwiseMin(x), left.upper.cwiseMax(x)};
  }
  return true;
}

/// One plane alone reaches the rod, none of it covered.
bool RodContact::onOnePlane(const InnerFaces* covers) const {
  return v_.near.size() == 1 && !(covers && covers->has(v_.near[0].index));
}

/// Where one plane alone reaches the rod. False: it does not cross the tube, and nothing is added.
bool RodContact::addTubeOnPlane() {
  const ContactFace& plane = v_.near[0];
  const double R = v_.radius;
  TubeOnPlane tube;
  if (!tube.find(R, rod_->halfLength(), plane.normal, plane.offset)) return false;
  // φ from the direction in which the plane looks out, counter-clockwise seen from outside; the arcs end where they turn back.
  const double side = tube.k.z(), from = M_PI - tube.theta0, to = from - tube.sweep;
  const double z0 = tube.o.z() + side * tube.l0, z1 = tube.o.z() + side * tube.l1;
  const Vector3 y = side * tube.f;
  const auto point = [&](double phi, double z) -> Vector3 {
    const auto [sine, cosine] = elementary::sinCos(phi);
    return R * (cosine * tube.e + sine * y) + Vector3(0, 0, z);
  };
  const auto addArc = [&](double start, double sweep, double za, double zb) {
    v_.rims.push_back({true, start, sweep, Vector3(0, 0, za), R * tube.e, R * y, Vector3(0, 0, zb - za)});
  };
  const auto addLine = [&](double phi, double z) {
    const Vector3 p = point(phi, z), q = point(-phi, z);
    v_.rims.push_back({false, 0, 1, p, q - p, Vector3::Zero(), Vector3::Zero()});
  };
  const int first = v_.rims.size();
  addArc(side * to, side * tube.sweep, z1, z0);
  if (tube.theta0 > 0) addLine(side * from, z0);
  addArc(-side * from, side * tube.sweep, z0, z1);
  if (tube.theta0 + tube.sweep < M_PI) addLine(-side * to, z1);
  end_inside_[side < 0] = true;
  end_inside_[side > 0] |= tube.whole_end;
  addPart(plane.normal, plane.offset, plane.index, tube.face, tube.o, first);
  addPiece(tube.solid, tube.o);
  return true;
}

void RodContact::addTube(const InnerFaces* covers) {
  const double half = rod_->halfLength();
  if (!cutBox(-half, half, -half, half) || !v_.tube.cut(w_.solid(), v_.radius)) return;
  TubeCut& tube = v_.tube;
  const Vector3 o = tube.inside();
  SolidMoments piece;
  for (const TubeFace& face : tube.faces()) {
    const PlaneMoments part = tube.moments(face, o);
    piece.addCone(part, face.offset - face.normal.dot(o));
    if (face.index < 0) {
      end_inside_[face.normal.z() > 0] = true;
      continue;
    }
    const int first = v_.rims.size();
    for (int i = face.first; i < face.first + face.count; ++i) {
      const TubeCurve curve = tube.curves()[i];
      if (!curve.arc) {
        v_.rims.push_back({false, 0, 1, curve.p, curve.q - curve.p, Vector3::Zero(), Vector3::Zero()});
        continue;
      }
      const auto [sine, cosine] = elementary::sinCos(face.apex);
      const Vector3 x = v_.radius * Vector3(cosine, sine, 0), y(-x.y(), x.x(), 0);
      tube.eachPart(face, curve, [&](const TubeArc& arc) {
        v_.rims.push_back({true, arc.from, arc.sweep, Vector3(0, 0, arc.z0), x, y, Vector3(0, 0, arc.z1 - arc.z0)});
      });
    }
    addPart(face.normal, face.offset, face.index, part, o, first);
  }
  tube.addSide(o, piece);
  addPiece(piece, o);
  covered_Q_ += coveredArea(tube.faces(), covers, [&](const TubeFace& face, const std::vector<Vector3>& whole) {
    const auto& outline = outlineBetween(whole, X_QS_, -half, half);
    return outline.size() >= 3 ? tube.areaWithin(face, outline) : 0;
  });
}

/// A half ball on the side of k against one plane at `height` over its centre: cut, and the point nearest to that centre of what lies
/// below. False: nothing is left.
bool RodContact::cutHalfBall(const Vector3& k, const ContactFace& plane, double height, NearestPoint& nearest) {
  if (!v_.cut.cutHalf(k, plane.normal, height, plane.index, v_.radius)) return false;
  const double c = plane.normal.dot(k);
  if (height >= 0) {
    nearest.distance = 0;
    nearest.direction = k;
  } else if (c <= 0) {
    nearest.distance = -height;
    nearest.direction = -plane.normal;
  } else {
    // On the line in which the plane meets the flat side.
    const Vector3 across = plane.normal - c * k;
    const double s = across.norm();
    nearest.distance = -height / s;
    nearest.direction = across / -s;
  }
  return true;
}

/// `end`: 1 or -1.
void RodContact::addHalfBall(double end, const InnerFaces* covers) {
  const double R = v_.radius, middle = end * rod_->halfLength(), tip = middle + end * kRoom * R;
  const double low = std::min(middle, tip), high = std::max(middle, tip);
  const Vector3 c(0, 0, middle);
  NearestPoint nearest;
  if (onOnePlane(covers)) {
    const ContactFace& plane = v_.near[0];
    if (!cutHalfBall(end * Vector3::UnitZ(), plane, plane.offset - plane.normal.dot(c), nearest)) return;
  } else {
    if (!cutBox(low, high, middle, middle) || v_.cut.cut(w_.solid(), c, R) >= 0) return;
    nearest = nearestPoint(w_.solid(), kRoom * R, c);
    if (nearest.distance >= R) return;
  }
  const Vector3 from_c = nearest.distance * nearest.direction, o = c + from_c;
  SolidMoments piece;
  for (const CutFace& face : v_.cut.faces()) {
    const PlaneMoments part = v_.cut.moments(face, from_c);
    piece.addCone(part, face.height - face.normal.dot(from_c));
    if (face.index < 0) continue;
    const int first = v_.rims.size();
    const Vector3 centre = c + face.height * face.normal;
    for (int i = face.first; i < face.first + face.count; ++i) {
      const CutCurve& curve = v_.cut.curves()[i];
      const Vector3 p = centre + curve.p.x() * face.x + curve.p.y() * face.y, q = centre + curve.q.x() * face.x + curve.q.y() * face.y;
      if (curve.arc) {
        v_.rims.push_back({true, curve.from, curve.sweep, centre, face.radius * face.x, face.radius * face.y, Vector3::Zero()});
      } else {
        v_.rims.push_back({false, 0, 1, p, q - p, Vector3::Zero(), Vector3::Zero()});
      }
    }
    addPart(face.normal, face.height + face.normal.dot(c), face.index, part, o, first);
  }
  addSphericalPart(v_.cut, nearest.direction, nearest.distance, piece);
  addPiece(piece, o);
  covered_Q_ += coveredArea(v_.cut.faces(), covers, [&](const CutFace& face, const std::vector<Vector3>& whole) {
    const auto& outline = outlineBetween(whole, X_QS_, low, high);
    return outline.size() >= 3 ? v_.cut.areaWithin(face, outline, c) : 0;
  });
}

void RodContact::addPart(const Vector3& normal, double offset, int index, const PlaneMoments& moments, const Vector3& o,
                         int first_rim) {
  if (sums_.volume == 0 && v_.parts.empty()) o_ = o;
  v_.parts.push_back({normal, index, offset, moments.shifted(o - o_), first_rim, v_.rims.size() - first_rim});
}

void RodContact::addPiece(const SolidMoments& piece, const Vector3& o) {
  if (!(piece.volume > 0)) return;
  if (sums_.volume == 0 && v_.parts.empty()) o_ = o;
  sums_.add(piece, o - o_);
}

/// Height of the polyhedron's part of V along `way`. Along an arc it is a constant and a cosine and a sine of the angle, which are
/// greatest at their ends or where both point.
double RodContact::reach(const Vector3& way) const {
  double reach = -INFINITY;
  for (const RoundVolume::Rim& rim : v_.rims) {
    if (!rim.arc) {
      reach = std::max({reach, way.dot(rim.middle), way.dot(rim.middle + rim.x)});
      continue;
    }
    const elementary::SineCosine from = elementary::sinCos(rim.from), to = elementary::sinCos(rim.from + rim.sweep);
    reach = std::max(reach, way.dot(rim.middle + from.cosine * rim.x + from.sine * rim.y));
    reach = std::max(reach, way.dot(rim.middle + to.cosine * rim.x + to.sine * rim.y + rim.rise));
    const double fall = from.cosine - to.cosine, slope = fall != 0 ? way.dot(rim.rise) / fall : 0;
    const double x = way.dot(rim.x) - slope, y = way.dot(rim.y), side = std::copysign(1, rim.sweep);
    const double highest = way.dot(rim.middle) + slope * from.cosine + elementary::hypot(x, y);
    if (!(highest > reach)) continue;
    double past = elementary::atan2(side * (from.cosine * y - from.sine * x), from.cosine * x + from.sine * y);
    if (past < 0) past += 2 * M_PI;
    if (past < std::abs(rim.sweep)) reach = highest;
  }
  return reach;
}

/// V's extent along `up`: to the rod's highest point or line, or where that is cut off to the faces' outlines.
double RodContact::extent(const Vector3& up) const {
  double sum = 0;
  for (const Vector3& way : {up, Vector3(-up)}) {
    // The points of the rod that are highest, to rounding: a line where the axis is level.
    const Vector3 pole = rod_->core(way) + rod_->rounding() * way;
    const bool level = std::abs(way.z()) * rod_->halfLength() < 1e-12 * v_.radius;
    const Vector3 along(0, 0, level ? -2 * pole.z() : 0);
    double enter = 0, leave = 1;
    for (const ContactFace& plane : v_.near) {
      const double height = plane.offset - plane.normal.dot(pole), slope = plane.normal.dot(along);
      if (slope > 0) leave = std::min(leave, height / slope);
      if (slope < 0) enter = std::max(enter, height / slope);
      if (slope == 0 && height < 0) leave = -1;
    }
    const bool flat = !rod_->isCapsule() && way.head<2>().norm() < 1e-12 && end_inside_[way.z() > 0];
    const double most = way.dot(pole);
    sum += enter <= leave || flat ? most : std::min(most, reach(way));
  }
  return sum;
}

void halfSpaceRodContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                         ContactVolume& out) noexcept {
  RodContact(request, cache, workspace, out).halfSpace(!pair.turned, *pair.second.rod(), pair.X_AB);
}

void polyhedronRodContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                          ContactVolume& out) noexcept {
  RodContact(request, cache, workspace, out)
      .polyhedron(*pair.first.polyhedron(), !pair.turned, *pair.second.rod(), pair.X_AB,
                  pair.turned ? request.inner.b : request.inner.a);
}

}  // namespace haptic
