/// ∫ d dS and ∫ d p dS over each face of V, with one face on each side taken for the whole side, as in thickness_squared.cpp.
///
/// With U, L the planes of the largest faces above and below, a = U - z_above and b = z_below - L, the thickness is
///     U - z - a over a face below, z - L - b over a face above.
/// The terms without a and b are a sum over triangles of the face. ∫ a over L's own face is ∫ a over all, less that over the
/// other faces below: so that only faces without the two largest are laid over one another.
#include "haptic_core/geometry/volume/thickness_gradient.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/volume/contact_sheet.h"

namespace haptic {
namespace {

/// Slivers of less than this share of V are left out.
constexpr double kSliver = 1e-13;
/// Sine of the angle at which faces of A and B meet, below which the force on their edge falls to zero. It would grow as 1/s over
/// a way s d that no step resolves, where aligned walls pass one another: a block of a stack was thrown off by 1.5 m/s. The work
/// k |m| l d of such a passage is left out.
constexpr double kParallel = 1e-2;

}  // namespace

/// The sums over the faces, in the workspace's `loads_`.
class FaceLoads {
 public:
  FaceLoads(ContactWorkspace& w, const ContactVolume& contact) : w_(w), contact_(contact) {}

  /// False: V has no face above, or none below.
  bool find() noexcept;
  /// Their wrench on B.
  Wrench onB() const noexcept;

 private:
  int upper() const { return w_.largest_[0]; }
  int lower() const { return w_.largest_[1]; }
  double rise(int face) const { return std::abs(w_.loads_[face].normal.z()); }

  /// Adds ∫ f and ∫ f p over a triangle, f and p by their values at its corners, times `factor`.
  static void add(FaceLoad& to, double area, const Vector3& f, const Vector3* p, double factor = 1) {
    const double share = factor * area / 12, sum = f.sum();
    to.load += 4 * share * sum;
    to.first += share * ((sum + f[0]) * p[0] + (sum + f[1]) * p[1] + (sum + f[2]) * p[2]);
  }
  void addTriangle(int face, const ContactEdge& edge, double sign) noexcept;
  void shortenWall(int wall, int other, const ContactEdge& edge) noexcept;
  void crossSlivers() noexcept;
  void addCrossing(int above, int below) noexcept;

  ContactWorkspace& w_;
  const ContactVolume& contact_;
  bool minor_[2] = {false, false};
};

/// The triangle of a face over one of its edges, from the face's anchor.
void FaceLoads::addTriangle(int face, const ContactEdge& edge, double sign) noexcept {
  FaceShadow& shadow = w_.shadows_[face];
  FaceLoad& load = w_.loads_[face];
  const int corner[3] = {shadow.anchor, edge.from, edge.to};
  const Vector3 p[3] = {w_.patch_points_[corner[0]], w_.patch_points_[corner[1]], w_.patch_points_[corner[2]]};
  const double area = 0.5 * sign * load.normal.dot((p[1] - p[0]).cross(p[2] - p[0]));
  const auto away = [&](int which) {
    return Vector3(w_.away_[corner[0]][which], w_.away_[corner[1]][which], w_.away_[corner[2]][which]);
  };
  if (shadow.side == FaceShadow::kSteep) return add(load, area, away(2), p, 0.5);  // (U - z) and (z - L)
  const int own = shadow.side, other = 1 - own;
  add(load, area, away(other), p);
  if (face == w_.largest_[own]) return;
  minor_[own] = true;
  shadow.most = std::max(shadow.most, away(own).maxCoeff());
  // The largest face of the other side looks at this one, not at its own side's plane.
  const int facing = w_.largest_[other];
  const double to_plane = own == FaceShadow::kAbove ? -1 : 1;  // from a corner to the plane of that face
  Vector3 q[3];
  for (int i = 0; i < 3; ++i) q[i] = p[i] + Vector3(0, 0, to_plane * w_.away_[corner[i]][other]);
  add(w_.loads_[facing], area * rise(face), away(own), q, -1 / rise(facing));
}

/// A wall along n ends at the plane of the largest face above, or at this edge below it; likewise at its foot.
void FaceLoads::shortenWall(int wall, int other, const ContactEdge& edge) noexcept {
  const int side = w_.shadows_[other].side;
  if (side == FaceShadow::kSteep || other == w_.largest_[side]) return;
  const Vector3 &p = w_.patch_points_[edge.from], &q = w_.patch_points_[edge.to];
  const Vector3 &at_p = w_.away_[edge.from], &at_q = w_.away_[edge.to];
  const double length = (q - p).head<2>().norm(), down = side == FaceShadow::kAbove ? -0.5 : 0.5;
  FaceLoad& load = w_.loads_[wall];
  // Simpson's rule, exact to the third degree: a loss times a height times a place.
  for (int i = 0; i < 3; ++i) {
    const double t = 0.5 * i, weight = length * (i == 1 ? 4 : 1) / 6;
    const Vector3 away = at_p + t * (at_q - at_p);
    const double loss = 0.5 * weight * away[side] * away[1 - side];
    load.load -= loss;
    load.first -= loss * (p + t * (q - p) + Vector3(0, 0, down * away[1 - side]));
  }
}

/// Where faces that are not the largest of their sides lie above one another.
void FaceLoads::addCrossing(int above, int below) noexcept {
  const FaceShadow &high = w_.shadows_[above], &low = w_.shadows_[below];
  w_.overlayFaces(above, below);
  const ContactSheet U(w_.faces_[upper()], contact_.X_AP), L(w_.faces_[lower()], contact_.X_AP);
  const ContactSheet top(w_.faces_[above], contact_.X_AP), foot(w_.faces_[below], contact_.X_AP);
  for (int i = 1; i + 1 < w_.polygon_.size(); ++i) {
    const Vector2 r[3] = {w_.polygon_[0], w_.polygon_[i], w_.polygon_[i + 1]};
    const Vector2 u = r[1] - r[0], v = r[2] - r[0];
    const double area = 0.5 * (u.x() * v.y() - u.y() * v.x());
    Vector3 a, b, at_upper[3], at_lower[3], at_top[3], at_foot[3];
    for (int k = 0; k < 3; ++k) {
      a[k] = std::clamp(U.at(r[k]) - top.at(r[k]), 0.0, high.most);  // steep faces must not leave the range between
      b[k] = std::clamp(foot.at(r[k]) - L.at(r[k]), 0.0, low.most);  // their corners
      const double z_upper = U.at(r[k]), z_lower = L.at(r[k]);
      at_upper[k] << r[k], z_upper;
      at_lower[k] << r[k], z_lower;
      at_top[k] << r[k], z_upper - a[k];
      at_foot[k] << r[k], z_lower + b[k];
    }
    add(w_.loads_[lower()], area, a, at_lower, 1 / rise(lower()));
    add(w_.loads_[below], area, a, at_foot, -1 / rise(below));
    add(w_.loads_[upper()], area, b, at_upper, 1 / rise(upper()));
    add(w_.loads_[above], area, b, at_top, -1 / rise(above));
  }
}

void FaceLoads::crossSlivers() noexcept {
  w_.boundShadows();
  bool grouped = false;
  for (int u = 0; u < w_.shadows_.size(); ++u) {
    if (w_.shadows_[u].side != FaceShadow::kAbove || u == upper()) continue;
    for (int l = 0; l < w_.shadows_.size(); ++l) {
      if (w_.shadows_[l].side != FaceShadow::kBelow || l == lower() || !w_.shadows_[u].meets(w_.shadows_[l])) continue;
      const double area = w_.shadows_[u].commonArea(w_.shadows_[l]) / std::min(rise(u), rise(l));
      if (std::max(w_.shadows_[u].most, w_.shadows_[l].most) * area <= kSliver * contact_.volume) continue;
      if (!grouped) w_.groupEdges();
      grouped = true;
      addCrossing(u, l);
    }
  }
}

bool FaceLoads::find() noexcept {
  if (!w_.projectSides(contact_)) return false;
  w_.loads_.clear();
  for (const ContactFace& face : w_.faces_) {
    FaceLoad load;
    load.normal = contact_.X_AP.R.transpose() * face.normal;
    w_.loads_.push_back(load);
  }
  for (const ContactEdge& edge : w_.edges_) {
    addTriangle(edge.left, edge, 1);
    addTriangle(edge.right, edge, -1);
    if (w_.shadows_[edge.left].side == FaceShadow::kSteep) shortenWall(edge.left, edge.right, edge);
    if (w_.shadows_[edge.right].side == FaceShadow::kSteep) shortenWall(edge.right, edge.left, edge);
  }
  if (minor_[0] && minor_[1]) crossSlivers();
  return true;
}

Wrench FaceLoads::onB() const noexcept {
  Wrench on_b;
  Vector3 whole = Vector3::Zero();  // τ
  for (int f = 0; f < w_.loads_.size(); ++f) {
    const FaceLoad& face = w_.loads_[f];
    const Vector3 moment = face.first.cross(face.normal);
    whole += moment;
    if (w_.faces_[f].owner != Owner::kB) continue;
    on_b.force -= face.load * face.normal;
    on_b.torque -= moment;
  }
  if (contact_.turns_with_b >= 0) {
    on_b.torque += contact_.turns_with_b * whole;
    return on_b;
  }
  const Vector3 m = Vector3(whole.y(), -whole.x(), 0) / contact_.area_vector_A.norm();
  for (int i = w_.seam_begin_; i < w_.edges_.size(); ++i) {
    const ContactEdge& edge = w_.edges_[i];
    const Vector3 &p = w_.patch_points_[edge.from], along = w_.patch_points_[edge.to] - p;
    const Vector3 &N_a = w_.loads_[edge.left].normal, &N_b = w_.loads_[edge.right].normal;
    const double length2 = along.squaredNorm(), sine = N_b.dot(along.cross(N_a));  // times the length
    if (length2 == 0) continue;
    const Vector3 force = m.dot(N_a) * length2 * sine / std::max(sine * sine, kParallel * kParallel * length2) * N_b;
    on_b.force += force;
    on_b.torque += (p + 0.5 * along).cross(force);
  }
  return on_b;
}

Wrench thicknessGradient(ContactWorkspace& w, const ContactVolume& contact) noexcept {
  const Wrench along_normal{Vector3::Zero(), Vector3(0, 0, contact.volume)};
  if (w.round().filled || (contact.flags & ContactVolume::kCapacityExceeded) != 0) return along_normal;
  FaceLoads loads(w, contact);
  return loads.find() ? loads.onB() : along_normal;
}

}  // namespace haptic
