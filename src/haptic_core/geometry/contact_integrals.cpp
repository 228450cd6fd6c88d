#include "haptic_core/geometry/contact_integrals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/moment_sums.h"

namespace haptic {
namespace {

PartMoments partMoments(const MomentSums& s) {
  return {s.volume, s.V1.head<2>(), s.V2, s.A0, s.A1, s.A2};
}

PartMoments wholeMoments(const ContactVolume& c) {
  return {c.volume, Vector2::Zero(), c.V2, c.A0, c.A1, c.A2};
}

/// Steeper faces than this (n·N) have no projection to speak of: their share of ∫ d² is this small, and the
/// height above r loses as many digits.
constexpr double kSteep = 1e-9;

}  // namespace

void ContactWorkspace::projectVertices(const ContactVolume& contact) noexcept {
  const Matrix3 R_PA = contact.X_AP.R.transpose();
  patch_points_.clear();
  for (const Vector3& x : vertices_) patch_points_.push_back(R_PA * (x - contact.X_AP.p));
}

PartMoments momentsWhere(ContactWorkspace& w, const ContactVolume& contact, const Vector2& a,
                         double b) noexcept {
  w.projectVertices(contact);
  // The origin moves onto the cutting plane: then the cut's own polygon, and the closing piece of the cut
  // outline, span no tetrahedron or triangle with it and need not be built.
  const double a2 = a.squaredNorm();
  const Vector2 on_line = a2 > 0 ? Vector2(b / a2 * a) : Vector2::Zero();
  double highest = -INFINITY, lowest = INFINITY;
  for (const Vector3& x : w.patch_points_) {
    highest = std::max(highest, a.dot(x.head<2>()) - b);
    lowest = std::min(lowest, a.dot(x.head<2>()) - b);
  }
  if (highest <= 0) return wholeMoments(contact);
  if (lowest >= 0) return PartMoments{};
  const Vector3 o(on_line.x(), on_line.y(), 0);
  w.leave_.clear();
  w.return_.clear();
  for (int f = 0; f < w.faces_.size(); ++f) {
    w.leave_.push_back(Vector3::Zero());
    w.return_.push_back(Vector3::Zero());
  }
  const auto foot = [&](int f) {
    const ContactFace& face = w.faces_[f];
    const Vector3 N = contact.X_AP.R.transpose() * face.normal;
    return Vector3((face.offset - face.normal.dot(contact.X_AP.p) - N.dot(o)) * N);
  };
  MomentSums sums;
  for (const ContactEdge& e : w.edges_) {
    Vector3 p = w.patch_points_[e.from] - o, q = w.patch_points_[e.to] - o;
    const double hp = a.dot(p.head<2>()), hq = a.dot(q.head<2>());
    if (hp > 0 && hq > 0) continue;
    if (hp > 0 || hq > 0) {
      const Vector3 x = p + hp / (hp - hq) * (q - p);
      (hq > 0 ? w.leave_ : w.return_)[e.left] = (hq > 0 ? w.return_ : w.leave_)[e.right] = x;
      (hq > 0 ? q : p) = x;
    }
    sums.addTetrahedron(foot(e.left), p, q);
    sums.addTetrahedron(foot(e.right), q, p);
    if (&e >= w.edges_.begin() + w.seam_begin_) sums.addTriangle(p, q);
  }
  for (int f = 0; f < w.faces_.size(); ++f) sums.addTetrahedron(foot(f), w.leave_[f], w.return_[f]);
  return partMoments(sums.about(-o));
}

namespace {

/// A face of V over the patch: z = height + slope·r.
struct Sheet {
  double height;
  Vector2 slope;
  double at(const Vector2& r) const { return height + slope.dot(r); }
};

Sheet sheet(const ContactFace& face, const Pose& X_AP) {
  const Vector3 N = X_AP.R.transpose() * face.normal;
  return {(face.offset - face.normal.dot(X_AP.p)) / N.z(), -N.head<2>() / N.z()};
}

/// ∫ d² over a triangle with a linear d, by its values at the corners.
double squareOver(double area, double a, double b, double c) {
  return area / 12 * ((a + b + c) * (a + b + c) + a * a + b * b + c * c);
}

double integrateSquare(const Sheet& upper, const Sheet& lower, const LoadedVector<Vector2>& polygon,
                       double depth) {
  // Rounding of steep sheets must not leave the range that d has.
  const auto d = [&](const Vector2& r) { return std::clamp(upper.at(r) - lower.at(r), 0.0, depth); };
  double sum = 0;
  const Vector2& a = polygon[0];
  const double da = d(a);
  for (int i = 1; i + 1 < polygon.size(); ++i) {
    const Vector2 ab = polygon[i] - a, ac = polygon[i + 1] - a;
    const double db = d(polygon[i]), dc = d(polygon[i + 1]), area = 0.5 * (ab.x() * ac.y() - ab.y() * ac.x());
    sum += squareOver(area, da, db, dc);
  }
  return sum;
}

}  // namespace

void ContactWorkspace::clipPolygon(const Vector2& from, const Vector2& to) noexcept {
  const Vector2 along = to - from;
  const auto height = [&](const Vector2& r) {
    return along.y() * (r.x() - from.x()) - along.x() * (r.y() - from.y());
  };
  clipped_.clear();
  for (int i = 0; i < polygon_.size(); ++i) {
    const Vector2 &p = polygon_[i], &q = polygon_[i + 1 < polygon_.size() ? i + 1 : 0];
    const double hp = height(p), hq = height(q);
    if (hp <= 0) clipped_.push_back(p);
    if ((hp <= 0) != (hq <= 0)) clipped_.push_back(p + hp / (hp - hq) * (q - p));
  }
  std::swap(polygon_, clipped_);
}

namespace {

/// How many faces of V look up and down along n, and the last of each.
struct Sides {
  int count[2] = {0, 0}, last[2] = {-1, -1};
};

Sides sidesOf(const ContactWorkspace& w, const Vector3& n) {
  Sides sides;
  for (int f = 0; f < w.faces().size(); ++f) {
    const double rise = w.faces()[f].normal.dot(n);
    if (std::abs(rise) < kSteep) continue;
    const int side = rise > 0 ? 0 : 1;
    ++sides.count[side];
    sides.last[side] = f;
  }
  return sides;
}

/// One face on one side (a ball on a table): the other side's faces tile the projection, and the triangles from their
/// middles to their edges can be summed as they come. `points`: V's vertices in P.
double squareOverOneFace(ContactWorkspace& w, const LoadedVector<Vector3>& points, const ContactVolume& contact,
                         const Sides& sides) {
  const bool one_above = sides.count[0] == 1;
  const Sheet one = sheet(w.faces()[sides.last[one_above ? 0 : 1]], contact.X_AP);
  const Matrix3 R_PA = contact.X_AP.R.transpose();
  const auto d = [&](const Vector3& x) { return std::clamp(std::abs(one.at(x.head<2>()) - x.z()), 0.0, contact.depth); };
  const LoadedVector<Vector3>& middles = w.faceCentres();
  double sum = 0;
  for (const ContactEdge& e : w.edges()) {
    const Vector3 &p = points[e.from], &q = points[e.to];
    const double dp = d(p), dq = d(q);
    for (const int f : {e.left, e.right}) {
      const double rise = w.faces()[f].normal.dot(contact.normal());
      if (one_above ? rise > -kSteep : rise < kSteep) continue;
      const Vector3 m = R_PA * (middles[f] - contact.X_AP.p);
      const Vector2 mp = (p - m).head<2>(), mq = (q - m).head<2>();
      // Seen from above loops of upper faces run counter-clockwise, those of lower ones clockwise.
      const double area = 0.5 * (mp.x() * mq.y() - mp.y() * mq.x());
      sum += squareOver((f == e.left) == one_above ? -area : area, d(m), dp, dq);
    }
  }
  return sum;
}

}  // namespace

/// Of the faces above and below only those pairs count that overlap: boxes tell most of the others apart.
double thicknessSquared(ContactWorkspace& w, const ContactVolume& contact) noexcept {
  w.projectVertices(contact);
  const Sides sides = sidesOf(w, contact.normal());
  if (sides.count[0] == 0 || sides.count[1] == 0) return 0;
  if (sides.count[0] == 1 || sides.count[1] == 1) {
    return squareOverOneFace(w, w.patch_points_, contact, sides);
  }
  w.buildLoops();
  const auto point = [&](const ContactLoop& l, int i) -> Vector2 {
    return w.patch_points_[w.loop_vertices_[l.first + i % l.count]].head<2>();
  };
  // Per loop: the lower corner of its box and how it faces, and the upper corner.
  w.leave_.clear();
  w.return_.clear();
  for (const ContactLoop& l : w.loops_) {
    const double rise = w.faces_[l.face].normal.dot(contact.normal());
    Eigen::AlignedBox2d box(point(l, 0));
    for (int k = 1; k < l.count; ++k) box.extend(point(l, k));
    w.leave_.push_back(Vector3(box.min().x(), box.min().y(), rise));
    w.return_.push_back(Vector3(box.max().x(), box.max().y(), 0));
  }
  const auto rise = [&](int l) { return w.leave_[l].z(); };
  const auto meet = [&](int a, int b) {
    return w.leave_[a].x() <= w.return_[b].x() && w.leave_[b].x() <= w.return_[a].x() &&
           w.leave_[a].y() <= w.return_[b].y() && w.leave_[b].y() <= w.return_[a].y();
  };
  double sum = 0;
  for (int u = 0; u < w.loops_.size(); ++u) {
    if (rise(u) < kSteep) continue;
    const ContactLoop& upper = w.loops_[u];
    const Sheet above = sheet(w.faces_[upper.face], contact.X_AP);
    for (int l = 0; l < w.loops_.size(); ++l) {
      if (rise(l) > -kSteep || !meet(u, l)) continue;
      const ContactLoop& lower = w.loops_[l];
      w.polygon_.clear();
      for (int i = 0; i < upper.count; ++i) w.polygon_.push_back(point(upper, i));
      // Inside lies to the left of the lower loop's edges taken backwards.
      for (int i = 0; i < lower.count && w.polygon_.size() >= 3; ++i) w.clipPolygon(point(lower, i + 1), point(lower, i));
      if (w.polygon_.size() < 3) continue;
      sum += integrateSquare(above, sheet(w.faces_[lower.face], contact.X_AP), w.polygon_, contact.depth);
    }
  }
  return sum;
}

}  // namespace haptic
