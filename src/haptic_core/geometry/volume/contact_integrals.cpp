#include "haptic_core/geometry/volume/contact_integrals.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/volume/moment_sums.h"

namespace haptic {
namespace {

PartMoments partMoments(const MomentSums& s) {
  return {s.volume, s.V1.head<2>(), s.V2, s.A0, s.A1, s.A2};
}

PartMoments wholeMoments(const ContactVolume& c) {
  return {c.volume, Vector2::Zero(), c.V2, c.A0, c.A1, c.A2};
}

}  // namespace

void ContactWorkspace::projectVertices(const ContactVolume& contact) noexcept {
  const Matrix3 R_PA = contact.X_AP.R.transpose();
  patch_points_.clear();
  for (const Vector3& x : vertices_) patch_points_.push_back(R_PA * (x - contact.X_AP.p));
}

/// The whole less the samples beyond the line: a linear function that vanishes on it continues without a jump.
PartMoments roundMomentsWhere(RoundVolume& round, const ContactVolume& contact, const Vector2& a, double b) noexcept {
  PartMoments part = wholeMoments(contact);
  RoundPatch(round, contact).fit().eachSample([&](const Vector2& r, double weight, double d) {
    if (a.dot(r) <= b) return;
    const Matrix2 square = r * r.transpose();
    part.A0 -= weight;
    part.A1 -= weight * r;
    part.A2 -= weight * square;
    part.volume -= weight * d;
    part.V1 -= weight * d * r;
    part.V2 -= weight * d * square;
  });
  return part;
}

PartMoments momentsWhere(ContactWorkspace& w, const ContactVolume& contact, const Vector2& a,
                         double b) noexcept {
  if (w.round().filled) return roundMomentsWhere(w.round(), contact, a, b);
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

}  // namespace haptic
