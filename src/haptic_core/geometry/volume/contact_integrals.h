/// Integrals over the last contact beyond its moments: over a part of it, of d².
///
/// All work on the V (and in the scratch memory) that `contactVolume` left in the workspace and on the
/// ContactVolume it filled (status kOverlap), in the patch frame P. (in realtime) No heap.
#pragma once
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

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

/// ∫ d² dA [m⁴]: twice the elastic energy of the foundation, divided by k. Cost: a look at V's faces where one side of V is a
/// single face; else one pass over its edges, and a polygon for each two of the other faces that lie above one another
/// (thickness_squared.cpp).
double thicknessSquared(ContactWorkspace& workspace, const ContactVolume& contact) noexcept;

}  // namespace haptic
