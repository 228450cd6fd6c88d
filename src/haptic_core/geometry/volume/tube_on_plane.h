/// What one plane cuts off a cylinder: most contacts of a rod.
///
/// Let the plane's normal lean from the axis by an angle of sine s ≥ 0 and cosine c ≥ 0 (else the axis is turned round). Of the
/// points of the cylinder the one deepest below the plane is o, at the depth D, where a line of the tube meets an end. With w from
/// o across the axis and ℓ along it, V goes from 0 to ℓ(w) = min(L, (D - s w)/c) over the chord 2 √(w (2R - w)). Where ℓ = L it is
/// a circle's segment times L: closed forms. Where the plane cuts, w = R (1 - cos θ), and the integrands are trigonometric
/// polynomials of degree 5 in θ, of one sign, for Gauss's rule: exact to rounding. A plane along the axis has no such part, one
/// across the axis nothing else; the same code does all between.
#pragma once
#include "haptic_core/geometry/volume/solid_moments.h"

namespace haptic {

/// V and the plane's part that bounds it.
struct TubeOnPlane {
  Vector3 o = Vector3::Zero();      ///< the deepest point, about which the moments are
  SolidMoments solid;               ///< V
  PlaneMoments face;                ///< part of the plane in the tube
  Vector3 e, f, k;                  ///< axes: across the tube from o, to the side, along the tube from o
  double theta0 = 0, sweep = 0;     ///< where the plane cuts: θ goes from theta0 over `sweep` [rad]
  double l0 = 0, l1 = 0;            ///< ℓ at its ends [m]
  bool whole_end = false;           ///< V reaches the other end

  /// (in realtime) A tube about z of `radius` and `half` of a length [m], below normal·x = offset. False: the plane does not
  /// cross the tube's surface.
  bool find(double radius, double half, const Vector3& normal, double offset) noexcept;
};

}  // namespace haptic
