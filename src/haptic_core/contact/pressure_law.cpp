#include "haptic_core/contact/pressure_law.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/volume/contact_integrals.h"
#include "haptic_core/geometry/volume/contact_sheet.h"
#include "haptic_core/geometry/volume/thickness_gradient.h"

namespace haptic {
namespace {

/// d counts as uniform when its mean is this close to its largest value, relatively: the part of the patch where it
/// can be less than half is then below four times this, and so is the error of not clipping there.
constexpr double kUniform = 1e-6;

/// A damper that pulls with less than this share of the mean elastic pressure is let pull: the patch is at rest, and
/// the pull is below the rounding of a depth of micrometres.
constexpr double kNegligiblePull = 1e-9;

/// Share of the elastic pressure below which a damper takes the tangential part of the spring away too.
constexpr double kFading = 0.25;

double patchReach(ContactWorkspace& workspace, const ContactVolume& contact) {
  if (workspace.round().filled) {
    if (workspace.round().axial) return workspace.round().cut.faces()[0].radius;
    return RoundPatch(workspace.round(), contact).reach();
  }
  const Vector3 n = contact.X_AP.R.col(2), p = contact.X_AP.p;
  double reach2 = 0;
  for (const Vector3& vertex : workspace.vertices()) {
    const Vector3 r = vertex - p;
    const double z = n.dot(r);
    reach2 = std::max(reach2, r.squaredNorm() - z * z);
  }
  return std::sqrt(std::max(0.0, reach2));
}

/// Approach rate ḋ = rate + slope·r, without what only spins a body of revolution.
struct Approach {
  double rate;
  Vector2 slope;
};

/// Read back from the force and its derivatives.
PressedVolume pressedVolume(const NormalPressure& p, const Approach& a, PressureLaw law, double k, double damping) {
  if (!p.clipped || !(p.force > 0)) return {};
  if (!jumpsAtTouch(law)) return {p.damping.m0 / (k * damping), p.damping.m1 / (k * damping)};
  const PatchMoments area = p.stiffness * (1 / k);
  return {(p.force - damping * (a.rate * area.m0 + a.slope.dot(area.m1))) / k,
          (p.first - damping * (a.rate * area.m1 + area.m2 * a.slope)) / k};
}

/// A damper acts on the motions alone that it answers: its moments, and the tangent in their rates.
void feelCompressing(const CompressingRate& compressing, NormalPressure& out) {
  if (compressing.all) return;
  const Matrix2& T = compressing.slope;
  const Vector2& l = compressing.lever;
  out.first = T * out.first + (out.force - out.elastic_force) * l;
  PatchMoments& w = out.damping;
  const Vector2 first = T * w.m1;
  w.m2 = T * w.m2 * T + first * l.transpose() + l * first.transpose() + w.m0 * l * l.transpose();
  w.m1 = first + w.m0 * l;
}

/// p = k d (φ + g·r) where positive, φ = 1 + c ḋ(0) and g = c ∇ḋ.
void damperWithin(const ContactVolume& contact, ContactWorkspace& workspace, const Approach& a, double k, double c,
                  NormalPressure& out) {
  const double phi = 1 + c * a.rate;
  const Vector2 g = c * a.slope;
  out.field = {k * phi, k * g, 0, Vector2::Zero()};
  out.clipped = phi - g.norm() * out.radius < 0;
  if (!out.clipped) {
    out.force = k * phi * contact.volume;
    out.first = k * contact.V2 * g;
    out.stiffness = PatchMoments{contact.A0, contact.A1, contact.A2} * (k * std::max(kLeastPressing, phi));
    out.damping = PatchMoments{contact.volume, Vector2::Zero(), contact.V2} * (k * c);
    return;
  }
  const PartMoments part = momentsWhere(workspace, contact, -g, phi);
  out.force = std::max(0.0, k * (phi * part.volume + g.dot(part.V1)));
  out.first = k * (phi * part.V1 + part.V2 * g);
  if (part.volume <= 0) return;
  const double pressing = std::max(kLeastPressing, out.force / (k * part.volume));
  out.stiffness = PatchMoments{part.A0, part.A1, part.A2} * (k * pressing);
  out.damping = PatchMoments{part.volume, part.V1, part.V2} * (k * c);
}

/// Adds ∫ p and ∫ r p over a polygon on which p is affine, and the moments of its area.
template <class Pressure>
void addPiece(const LoadedVector<Vector2>& piece, Pressure pressure, NormalPressure& out, PatchMoments& area) {
  for (int i = 1; i + 1 < piece.size(); ++i) {
    const Vector2 corner[3] = {piece[0], piece[i], piece[i + 1]};
    const Vector2 ab = corner[1] - corner[0], ac = corner[2] - corner[0];
    const double twelfth = (ab.x() * ac.y() - ab.y() * ac.x()) / 24;
    const double p[3] = {pressure(corner[0]), pressure(corner[1]), pressure(corner[2])};
    const double sum = p[0] + p[1] + p[2];
    out.force += 4 * twelfth * sum;
    for (int j = 0; j < 3; ++j) out.first += twelfth * (sum + p[j]) * corner[j];
    // ∫ 1, r, r rᵀ over the triangle: its area a = 12 · twelfth, a/3 Σ r, a/12 (Σ r rᵀ + Σ r Σ rᵀ).
    const Vector2 corners = corner[0] + corner[1] + corner[2];
    area.m0 += 12 * twelfth;
    area.m1 += 4 * twelfth * corners;
    area.m2 += twelfth * corners * corners.transpose();
    for (int j = 0; j < 3; ++j) area.m2 += twelfth * corner[j] * corner[j].transpose();
  }
}

/// ∫ max(0, k d + b ḋ) over a round patch: the integral without clipping, and over samples the addition of clipping.
void clipRound(const ContactVolume& contact, RoundVolume& round, const Approach& a, double k, double b, NormalPressure& out) {
  PatchMoments area{contact.A0, contact.A1, contact.A2};
  out.force = k * contact.volume + b * (a.rate * contact.A0 + a.slope.dot(contact.A1));
  out.first = b * (a.rate * contact.A1 + contact.A2 * a.slope);
  RoundPatch(round, contact).fit().eachSample([&](const Vector2& r, double weight, double d) {
    const double p = k * d + b * (a.rate + a.slope.dot(r));
    if (p >= 0) return;
    out.force -= weight * p;
    out.first -= weight * p * r;
    area.m0 -= weight;
    area.m1 -= weight * r;
    area.m2 -= weight * r * r.transpose();
  });
  out.force = std::max(0.0, out.force);
  out.stiffness = area * k;
  out.damping = area * b;
}

/// ∫ max(0, k d + b ḋ) by overlaying the faces of A (above) and of B (below).
void overlay(const ContactVolume& contact, ContactWorkspace& workspace, const Approach& a, double k, double b,
             NormalPressure& out) {
  workspace.buildLoops();
  PatchMoments area;
  const Vector3 n = contact.normal();
  const auto rise = [&](const ContactLoop& loop) { return workspace.faces()[loop.face].normal.dot(n); };
  const auto point = [&](const ContactLoop& loop, int i) -> Vector2 {
    const int vertex = workspace.loopVertices()[loop.first + i % loop.count];
    return (contact.X_AP.R.transpose() * (workspace.vertices()[vertex] - contact.X_AP.p)).head<2>();
  };
  // The faces of one side cover V's projection: a single one there contains all of the other side.
  int above_count = 0, below_count = 0;
  for (const ContactLoop& loop : workspace.loops()) {
    above_count += rise(loop) >= ContactSheet::kSteep;
    below_count += rise(loop) <= -ContactSheet::kSteep;
  }
  const bool from_below = above_count == 1, crossed = above_count > 1 && below_count > 1;
  const int dropped = workspace.dropped();
  LoadedVector<Vector2>& piece = workspace.polygon();
  for (const ContactLoop& upper : workspace.loops()) {
    if (rise(upper) < ContactSheet::kSteep) continue;
    const ContactSheet above(workspace.faces()[upper.face], contact.X_AP);
    for (const ContactLoop& lower : workspace.loops()) {
      if (rise(lower) > -ContactSheet::kSteep) continue;
      const ContactSheet below(workspace.faces()[lower.face], contact.X_AP);
      // Seen from above the lower loop runs clockwise: inside lies to the right of its edges.
      piece.clear();
      for (int i = 0; i < upper.count && !from_below; ++i) piece.push_back(point(upper, i));
      for (int i = lower.count; i-- > 0 && from_below;) piece.push_back(point(lower, i));
      for (int i = 0; i < lower.count && crossed && piece.size() >= 3; ++i) {
        const Vector2 from = point(lower, i), along = point(lower, i + 1) - from;
        workspace.keepAbove([&](const Vector2& r) {
          return along.y() * (r.x() - from.x()) - along.x() * (r.y() - from.y());
        });
      }
      const auto pressure = [&](const Vector2& r) {
        return k * (above.at(r) - below.at(r)) + b * (a.rate + a.slope.dot(r));
      };
      workspace.keepAbove(pressure);
      addPiece(piece, pressure, out, area);
    }
  }
  out.dropped = workspace.dropped() - dropped;
  out.stiffness = area * k;
  out.damping = area * b;
}

void damperBeside(const ContactVolume& contact, ContactWorkspace& workspace, const Approach& a, double k, double b,
                  NormalPressure& out) {
  out.field = {k, Vector2::Zero(), b * a.rate, b * a.slope};
  const double mean = contact.volume / contact.A0, slowest = a.rate - a.slope.norm() * out.radius;
  const bool uniform = contact.depth - mean <= kUniform * contact.depth;
  const double pull = -b * slowest;
  out.clipped = pull > kNegligiblePull * k * mean && !(uniform && pull <= 0.5 * k * mean);
  if (out.clipped && workspace.round().filled) return clipRound(contact, workspace.round(), a, k, b, out);
  if (out.clipped) return overlay(contact, workspace, a, k, b, out);
  out.force = k * contact.volume + b * (a.rate * contact.A0 + a.slope.dot(contact.A1));
  out.first = b * (a.rate * contact.A1 + contact.A2 * a.slope);
  const PatchMoments area{contact.A0, contact.A1, contact.A2};
  out.stiffness = area * k;
  out.damping = area * b;
}

}  // namespace

Wrench beyondNormal(const ContactVolume& contact, ContactWorkspace& workspace, PressureLaw law,
                    const NormalPressure& pressure) noexcept {
  if (!kindOf(law).potential) return {};
  const Wrench along_n{Vector3::Zero(), Vector3(0, 0, contact.volume)};
  return (thicknessGradient(workspace, contact) - along_n) * (pressure.elastic_force / contact.volume);
}

double shareBeyond(const NormalPressure& pressure) noexcept {
  return std::clamp(pressure.force / (kFading * pressure.elastic_force), 0.0, 1.0);
}

NormalPressure normalPressure(const ContactVolume& contact, ContactWorkspace& workspace, const Twist& V,
                              PressureLaw law, const ContactMaterial& m) noexcept {
  const Vector2 slope(V.angular.y(), -V.angular.x());
  Approach a{-V.linear.z(), slope};
  if (!contact.compressing.all) a = {contact.compressing.lever.dot(slope) - V.linear.z(), contact.compressing.slope * slope};
  NormalPressure out;
  out.radius = patchReach(workspace, contact);
  if (jumpsAtTouch(law)) {
    damperBeside(contact, workspace, a, m.stiffness, kindOf(law).damping(m), out);
  } else {
    damperWithin(contact, workspace, a, m.stiffness, kindOf(law).damping(m), out);
  }
  out.elastic_force = m.stiffness * contact.volume;
  out.pressed = pressedVolume(out, a, law, m.stiffness, kindOf(law).damping(m));
  feelCompressing(contact.compressing, out);
  return out;
}

}  // namespace haptic
