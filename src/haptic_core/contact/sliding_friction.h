/// Coulomb friction of a patch that slides and spins at once, integrated over its area.
///
/// Traction μ p(r) t̂(r) with t̂ the direction of the local slip v + ω ẑ × r. About the instant centre c of the
/// motion, r = c + x, the direction is sign(ω) ẑ × x/|x|, and p is a polynomial of x on each face of V, for
/// ∫ p dA = ∫_V (…) dV = Σ over V's faces of the height under the face. On the triangle from c to one edge, at
/// distance e from c and with u along the edge, R² = e² + u², every integral is a sum of
///     ∫ uᵐ/R du  (force)   and   ∫ uᵐ R du  (torque),
/// elementary functions with one asinh per edge: a closed form, exact for any convex patch.
/// Where c is farther than kFarCentre patch radii the closed form would cancel; there the series in ω r/|v| to
/// second order is used, with error below (r/|c|)² times the skewness of the pressure, 1e-3 of N.
/// The coupling of sliding and spinning: P. Contensou, Couplage entre frottement de glissement et frottement de
/// pivotement dans la théorie de la toupie (1963). Cost: about 40 ns per edge of V; the series 10 ns.
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/geometry/contact_volume.h"
#include "haptic_core/geometry/contact_workspace.h"

namespace haptic {

/// Distance of the instant centre, in patch radii, from which on the series is used. Farther out the closed form loses
/// digits with the cube of the distance.
constexpr double kFarCentre = 30;

/// Pressure over a patch as a function of thickness d and place r: p = d (k0 + k1·r) + b0 + b1·r.
/// Hunt–Crossley: k0 = k (1 - c v_z), k1; linear damper: k0 = k, b0 + b1·r = b ḋ.
struct PressureField {
  double k0 = 0;                      ///< [N/m³]
  Vector2 k1 = Vector2::Zero();       ///< [N/m⁴]
  double b0 = 0;                      ///< [N/m²]
  Vector2 b1 = Vector2::Zero();       ///< [N/m³]
};

/// Moments of the pressure about P: what the series needs.
struct PressureMoments {
  double force = 0;                   ///< ∫ p dA [N]
  Vector2 first = Vector2::Zero();    ///< ∫ r p dA [N·m]
  Matrix2 second = Matrix2::Zero();   ///< ∫ r rᵀ p dA [N·m²]
};

/// ∫ p t̂ dA and its moment about P. Friction on B is -μ times it.
struct SlidingIntegral {
  Vector2 force = Vector2::Zero();    ///< [N]
  double torque = 0;                  ///< [N·m]
};

/// (in realtime) `v` [m/s] and `w` [rad/s]: slip of B over A at P and about n, of any common scale; `radius` [m]
/// the patch's extent about P. Needs the V of `contact` in the workspace. Zero for no slip at all.
SlidingIntegral slidingIntegral(const ContactWorkspace& workspace, const ContactVolume& contact,
                                const PressureField& pressure, const PressureMoments& moments, const Vector2& v,
                                double w, double radius) noexcept;

}  // namespace haptic
