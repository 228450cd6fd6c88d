/// Coulomb friction of a patch that slides and spins at once, integrated over its area.
///
/// Traction μ p(r) t̂(r) with t̂ the direction of the local slip v + ω ẑ × r. About the instant centre c of the
/// motion, r = c + x, the direction is sign(ω) ẑ × x/|x|, and p is a polynomial of x on each face of V, for
/// ∫ p dA = ∫_V (…) dV = Σ over V's faces of the height under the face. On the triangle from c to one edge, at
/// distance e from c and with u along the edge, R² = e² + u², every integral is a sum of
///     ∫ uᵐ/R du  (force)   and   ∫ uᵐ R du  (torque),
/// elementary functions with one asinh per edge: a closed form, exact for any convex patch. It loses digits with the
/// cube of |c|. From kNearCentre patch radii on the direction hardly curves over the patch, and a rule of degree 5 on
/// the triangles of V's faces is smooth and true to 1e-7 of N; from kFarCentre on the series in ω r/|v| to second
/// order, with error below (r/|c|)² times the skewness of the pressure, 1e-6 of N.
/// The coupling of sliding and spinning: P. Contensou, Couplage entre frottement de glissement et frottement de
/// pivotement dans la théorie de la toupie (1963). Cost: about 40 ns per edge of V by
/// the closed form, 50 ns by the rule; the series 10 ns.
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic {

/// Distances of the instant centre, in patch radii. Nearer than the first the rule would err by more than 1e-7, beyond it
/// the closed form by more than 1e-12, which keeps a Newton solve from converging. The second trades time for the
/// series' error.
constexpr double kNearCentre = 6;
constexpr double kFarCentre = 1000;  ///< see kNearCentre

/// Pressure over a patch as a function of thickness d and place r: p = d (k0 + k1·r) + b0 + b1·r.
/// Hunt–Crossley: k0 = k (1 - c v_z), k1; linear damper: k0 = k, b0 + b1·r = b ḋ.
struct PressureField {
  double k0 = 0;                      ///< [N/m³]
  Vector2 k1 = Vector2::Zero();       ///< [N/m⁴]
  double b0 = 0;                      ///< [N/m²]
  Vector2 b1 = Vector2::Zero();       ///< [N/m³]
};

/// Moments of the pressure about P, for the series.
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
/// the patch's extent about P. Needs the V of `contact` in the workspace. Zero for no slip at all. `clipped`: over the part of the patch
/// where k0 + k1·r is not negative; of it are the `moments`.
SlidingIntegral slidingIntegral(ContactWorkspace& workspace, const ContactVolume& contact, const PressureField& pressure,
                                const PressureMoments& moments, const Vector2& v, double w, double radius, bool clipped = false) noexcept;

}  // namespace haptic
