/// Integrals over the last contact beyond its moments: over a part of it, of any function, of d².
///
/// All work on the V (and in the scratch memory) that `contactVolume` left in the workspace and on the
/// ContactVolume it filled (status kOverlap), in the patch frame P. (in realtime) No heap.
#pragma once
#include "haptic_core/geometry/contact_volume.h"
#include "haptic_core/geometry/contact_workspace.h"

namespace haptic {

/// Moments of a part of V about P's origin (the centroid of the whole V, so V1 need not vanish here).
struct PartMoments {
  double volume = 0;             ///< ∫ d dA [m³]
  Vector2 V1 = Vector2::Zero();  ///< ∫ r d dA [m⁴]
  Matrix2 V2 = Matrix2::Zero();  ///< ∫ r rᵀ d dA [m⁵]
  double A0 = 0;                 ///< ∫ dA [m²]
  Vector2 A1 = Vector2::Zero();  ///< ∫ r dA [m³]
  Matrix2 A2 = Matrix2::Zero();  ///< ∫ r rᵀ dA [m⁴]
};

/// Of the part where a·r ≤ b: where 1 + c ḋ > 0, say, ḋ being linear in r. `a` need not be a unit vector; a =
/// 0 gives all or nothing. Cost: about that of the moments themselves.
PartMoments momentsWhere(ContactWorkspace& workspace, const ContactVolume& contact, const Vector2& a,
                         double b) noexcept;

/// A point and weight: ∫ f(r) d dA ≈ Σ weight f(r).
struct QuadraturePoint {
  Vector2 r;      ///< [m]
  double weight;  ///< part of the volume [m³], > 0
};

/// Points for ∫ f d dA, exact for f of degree 2 (four points in each tetrahedron from the centroid to V's
/// surface); for a kinked or curved f the error falls with the square of the tetrahedra's size. Writes at
/// most `capacity` points, four per half edge of V, and returns their number; what does not fit is spread
/// over those that do, so that the weights always sum to the volume.
int quadrature(ContactWorkspace& workspace, const ContactVolume& contact, QuadraturePoint* points,
               int capacity) noexcept;

/// ∫ d² dA [m⁴]: twice the elastic energy of the foundation, divided by k. Overlays the faces below and
/// above: cost grows with the product of their numbers.
double thicknessSquared(ContactWorkspace& workspace, const ContactVolume& contact) noexcept;

}  // namespace haptic
