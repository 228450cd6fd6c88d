/// ∫ d² dA.
///
/// Where one side is a single face, of plane U: ∫ d² = 2 ∫ (U - z) dV = 2 V (U - z) at V's centroid, U being linear. So it is
/// for all that lies or stands on a face larger than itself, but for slivers where it is tilted by a microradian.
///
/// Else one face on each side is taken for the whole side. d = z_above - z_below over the projection of V, both piecewise
/// linear. Let U and L be the planes of the largest faces above and below, a = U - z_above and b = z_below - L the thickness that
/// the other faces take away: d = (U - L) - a - b, so that
///     ∫ d² = ∫ (U - z_below)² + ∫ [(z_above - L)² - (U - L)²] + 2 ∫ a b.
/// The first integral is a sum over the faces below, the second one over those above but for U's own, where it vanishes.
/// Both are sums over triangles as they come; only the last needs faces of both sides laid over one another, without the
/// two largest. A box that lies on another, across its edge, has a few slivers there.
#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/volume/contact_integrals.h"
#include "haptic_core/geometry/volume/contact_sheet.h"

namespace haptic {
namespace {

/// Slivers that count no more than this, relative to the whole, are left out: less than elastic energies of contacts need.
constexpr double kNegligible = 1e-9;

/// A linear function by its values at the corners of a triangle.
struct OnCorners {
  double value[3];
  double sum() const { return value[0] + value[1] + value[2]; }
};

/// ∫ f g over a triangle.
double productOver(double area, const OnCorners& f, const OnCorners& g) {
  return area / 12 * (f.sum() * g.sum() + f.value[0] * g.value[0] + f.value[1] * g.value[1] + f.value[2] * g.value[2]);
}

}  // namespace

/// Which faces look up and down along n, and how large they are from there.
void ContactWorkspace::projectFaces(const ContactVolume& contact) noexcept {
  projectVertices(contact);
  shadows_.clear();
  for (const ContactFace& face : faces_) {
    const double rise = face.normal.dot(contact.normal());
    FaceShadow shadow;
    shadow.side = std::abs(rise) < ContactSheet::kSteep ? FaceShadow::kSteep : rise > 0 ? FaceShadow::kAbove : FaceShadow::kBelow;
    shadows_.push_back(shadow);
  }
  for (const ContactEdge& e : edges_) {
    const Vector2 p = patch_points_[e.from].head<2>(), q = patch_points_[e.to].head<2>();
    for (const int f : {e.left, e.right}) {
      FaceShadow& shadow = shadows_[f];
      if (shadow.anchor < 0) shadow.anchor = e.from;
      const Vector2 o = patch_points_[shadow.anchor].head<2>(), op = p - o, oq = q - o;
      const double twice = op.x() * oq.y() - op.y() * oq.x();
      shadow.area += f == e.left ? 0.5 * twice : -0.5 * twice;
    }
  }
}

/// Boxes of the faces' projections, and their longest edges: for those that may lie over one another.
void ContactWorkspace::boundShadows() noexcept {
  for (const ContactEdge& e : edges_) {
    const Vector2 p = patch_points_[e.from].head<2>(), q = patch_points_[e.to].head<2>();
    for (const int f : {e.left, e.right}) {
      FaceShadow& shadow = shadows_[f];
      if ((q - p).squaredNorm() > shadow.longest.squaredNorm()) shadow.longest = q - p;
      shadow.low = shadow.low.cwiseMin(p.cwiseMin(q));
      shadow.high = shadow.high.cwiseMax(p.cwiseMax(q));
    }
  }
}

/// The same, the largest face above and below, and how far each vertex is from their planes. False: a side has no face.
bool ContactWorkspace::projectSides(const ContactVolume& contact) noexcept {
  projectFaces(contact);
  largest_[0] = largest_[1] = -1;
  for (int f = 0; f < shadows_.size(); ++f) {
    const FaceShadow& shadow = shadows_[f];
    if (shadow.side == FaceShadow::kSteep) continue;
    int& most = largest_[shadow.side];
    if (most < 0 || std::abs(shadow.area) > std::abs(shadows_[most].area)) most = f;
  }
  if (largest_[0] < 0 || largest_[1] < 0) return false;
  const ContactSheet U(faces_[largest_[0]], contact.X_AP), L(faces_[largest_[1]], contact.X_AP);
  away_.clear();
  for (const Vector3& x : patch_points_) {
    const double upper = U.at(x.head<2>()), lower = L.at(x.head<2>());
    away_.push_back(Vector3(upper - x.z(), x.z() - lower, upper - lower));
  }
  return true;
}

/// Edges by face: those of f are shadow_edges_[first … first + count - 1].
void ContactWorkspace::groupEdges() noexcept {
  for (FaceShadow& shadow : shadows_) shadow.count = 0;
  for (const ContactEdge& e : edges_) ++shadows_[e.left].count, ++shadows_[e.right].count;
  int next = 0;
  for (FaceShadow& shadow : shadows_) {
    shadow.first = next;
    next += shadow.count;
    shadow.count = 0;
  }
  shadow_edges_.resize(next);
  for (int i = 0; i < edges_.size(); ++i) {
    for (const int f : {edges_[i].left, edges_[i].right}) shadow_edges_[shadows_[f].first + shadows_[f].count++] = i;
  }
}

/// Leaves in `polygon_` what lies left of from → to: most often all of it, which is then not copied.
void ContactWorkspace::clipPolygon(const Vector2& from, const Vector2& to) noexcept {
  const Vector2 along = to - from;
  const auto height = [&](const Vector2& r) { return along.x() * (r.y() - from.y()) - along.y() * (r.x() - from.x()); };
  for (const Vector2& corner : polygon_) {
    if (!(height(corner) >= 0)) return keepAbove(height);
  }
}

/// The common part of the projections of two faces into `polygon_`, counter-clockwise.
void ContactWorkspace::overlayFaces(int above, int below) noexcept {
  const Vector2 low = shadows_[above].low.cwiseMax(shadows_[below].low),
                high = shadows_[above].high.cwiseMin(shadows_[below].high);
  polygon_.clear();
  for (const Vector2& corner : {low, Vector2(high.x(), low.y()), high, Vector2(low.x(), high.y())}) polygon_.push_back(corner);
  for (const int face : {above, below}) {
    const FaceShadow& shadow = shadows_[face];
    for (int i = shadow.first; i < shadow.first + shadow.count && polygon_.size() >= 3; ++i) {
      const ContactEdge& e = edges_[shadow_edges_[i]];
      // Seen from above loops of upper faces run counter-clockwise, those of lower ones clockwise.
      const bool forth = (e.left == face) == (face == above);
      clipPolygon(patch_points_[forth ? e.from : e.to].head<2>(), patch_points_[forth ? e.to : e.from].head<2>());
    }
  }
}

/// ∫ d² dA where one face stands for a whole side of V; 0: on both sides others count. Faces that rise by less than kSteepest and
/// cast a shadow s besides take 2 ∫ a d ≤ ½ depth² s from it, since a + d is no more than the depth; s is no more than their rise
/// times the depth times V's width.
double ContactWorkspace::squaresBelowOneFace(const ContactVolume& contact) const noexcept {
  // [1] Smaller: boxes that lie askew by a few degrees are overlaid face by face. Larger: 1.01 below no longer bounds 1/cos.
  constexpr double kSteepest = 0.1;
  const Vector3 n = contact.normal();
  const ContactFace* main[2] = {nullptr, nullptr};
  double highest[2] = {0, 0}, rises[2] = {0, 0};
  for (const ContactFace& face : faces_) {
    const double rise = face.normal.dot(n), steep = std::abs(rise);
    const int side = rise > 0 ? 0 : 1;
    rises[side] += steep;
    if (steep <= highest[side]) continue;
    highest[side] = steep;
    main[side] = &face;
  }
  double reach2 = 0;
  for (const Vector3& x : vertices_) reach2 = std::max(reach2, (x - contact.X_AP.p).squaredNorm());
  for (const int side : {0, 1}) {
    const double others = rises[side] - highest[side];
    if (!main[side] || !(others < kSteepest) || highest[side] < kSteepest) continue;
    const double level = std::abs(ContactSheet(*main[side], contact.X_AC()).height), squares = 2 * contact.volume * level;
    const double shadow = others * 1.01 * contact.depth * 2 * std::sqrt(reach2);
    if (0.5 * contact.depth * contact.depth * shadow <= kNegligible * squares) return squares;
  }
  return 0;
}

double thicknessSquared(ContactWorkspace& w, const ContactVolume& contact) noexcept {
  if (w.round().filled) return RoundPatch(w.round(), contact).thicknessSquared();
  const double below_one_face = w.squaresBelowOneFace(contact);
  if (below_one_face > 0) return below_one_face;
  if (!w.projectSides(contact)) return 0;
  const int* largest = w.largest_;
  const ContactSheet U(w.faces_[largest[0]], contact.X_AP), L(w.faces_[largest[1]], contact.X_AP);
  double sum = 0;
  bool minor[2] = {false, false};
  for (const ContactEdge& e : w.edges_) {
    for (const int f : {e.left, e.right}) {
      FaceShadow& shadow = w.shadows_[f];
      if (shadow.side == FaceShadow::kSteep) continue;
      minor[shadow.side] |= f != largest[shadow.side];
      const Vector3 &a = w.away_[shadow.anchor], &b = w.away_[e.from], &c = w.away_[e.to];
      shadow.most = std::max(shadow.most, b[shadow.side]);
      shadow.most = std::max(shadow.most, c[shadow.side]);
      if (f == largest[0] || e.from == shadow.anchor || e.to == shadow.anchor) continue;
      const bool above = shadow.side == FaceShadow::kAbove;
      const Vector3& o = w.patch_points_[shadow.anchor];
      const Vector2 op = (w.patch_points_[e.from] - o).head<2>(), oq = (w.patch_points_[e.to] - o).head<2>();
      const double area = 0.5 * (op.x() * oq.y() - op.y() * oq.x()) * ((f == e.left) == above ? 1 : -1);
      const int other = 1 - shadow.side;  // how far the face is from the largest one of the other side
      const OnCorners thick{{a[other], b[other], c[other]}}, gone{{a[2], b[2], c[2]}};
      sum += productOver(area, thick, thick) - (above ? productOver(area, gone, gone) : 0.0);
    }
  }
  if (!minor[0] || !minor[1]) return sum;
  w.boundShadows();
  bool grouped = false;
  for (int u = 0; u < w.shadows_.size(); ++u) {
    if (w.shadows_[u].side != FaceShadow::kAbove || u == largest[0]) continue;
    const ContactSheet above(w.faces_[u], contact.X_AP);
    for (int l = 0; l < w.shadows_.size(); ++l) {
      if (w.shadows_[l].side != FaceShadow::kBelow || l == largest[1] || !w.shadows_[u].meets(w.shadows_[l])) continue;
      const double most = 2 * w.shadows_[u].most * w.shadows_[l].most * w.shadows_[u].commonArea(w.shadows_[l]);
      if (most <= kNegligible * sum) continue;
      if (!grouped) w.groupEdges();
      grouped = true;
      w.overlayFaces(u, l);
      const ContactSheet below(w.faces_[l], contact.X_AP);
      // Rounding of steep faces must not leave the range between their corners.
      const auto a = [&](const Vector2& r) { return std::clamp(U.at(r) - above.at(r), 0.0, w.shadows_[u].most); };
      const auto b = [&](const Vector2& r) { return std::clamp(below.at(r) - L.at(r), 0.0, w.shadows_[l].most); };
      for (int i = 1; i + 1 < w.polygon_.size(); ++i) {
        const Vector2 &o = w.polygon_[0], &p = w.polygon_[i], &q = w.polygon_[i + 1];
        const Vector2 op = p - o, oq = q - o;
        const double area = 0.5 * (op.x() * oq.y() - op.y() * oq.x());
        sum += 2 * productOver(area, {{a(o), a(p), a(q)}}, {{b(o), b(p), b(q)}});
      }
    }
  }
  return sum;
}

}  // namespace haptic
