/// Integrals over four arcs of the unit circle, by sums, products and quotients alone: the same bits on every
/// machine.
#pragma once
#include "haptic_core/base/lane_functions.h"

namespace haptic {

/// F_3 by powers of 4q − 1: interpolated at Chebyshev's nodes in 60 digits. Error 4e-16, relative.
inline constexpr LanePolynomial<20> kArcSeries(
    {0.18399152312290462, 0.05336158959031773, 0.015937836234647024, 0.004853137851860699, 0.0014980676477557176,
     0.0004671164862526439, 0.0001467895307633189, 4.641327880167649e-05, 1.4748990767046298e-05, 4.706336619989207e-06,
     1.507145748914075e-06, 4.840402691518782e-07, 1.5555824084471938e-07, 5.01988212169817e-08, 1.6648880959907516e-08,
     5.393701820407092e-09, 1.394964019787298e-09, 4.5264663922389356e-10, 3.141863426659423e-10, 1.024244215422127e-10});

/// ∫ (1 − cos θ)ᵏ ds along an arc of radius h, θ from −φ to φ, for k = 0…3, 0 ≤ φ ≤ π/2, to rounding relative to each.
///
/// With τ = φ/2 they are h 2ᵏ⁺² W_k, W_k = ∫ sin²ᵏ from 0 to τ, and (2k − 1) W_k−1 = 2k W_k + sin²ᵏ⁻¹τ cos τ: a
/// sum of positive terms. W_k = sin²ᵏ⁺¹τ cos τ F_k(q), q = sin² τ ≤ 1/2, so that (2k − 1) F_k−1 = 1 + 2k q F_k;
/// F_3 = ₂F₁(1, 4; 9/2; q) / 7 is one polynomial.
struct ArcIntegrals {
  Lanes k0, k1, k2, k3;  ///< by k [m]

  /// (in realtime) Of the chord 2h sin φ, its square, the sum 2h cos φ of the vectors to the ends, and h [m].
  ArcIntegrals(const Lanes& chord, const Lanes& chord2, const Lanes& sum, const Lanes& h) {
    const Lanes twice = h + h, q2 = chord2 / (twice * (twice + sum));  // 2q
    const Lanes f3 = kArcSeries(q2 + q2 - lanes(1)), f2 = lanes(1.0 / 5) + lanes(3.0 / 5) * q2 * f3,
                f1 = lanes(1.0 / 3) + lanes(2.0 / 3) * q2 * f2, f0 = lanes(1) + q2 * f1;
    // 4 sin τ cos τ h = 2 sin φ h, the chord.
    const Lanes t1 = chord * q2, t2 = t1 * q2, t3 = t2 * q2;
    k0 = chord * f0;
    k1 = t1 * f1;
    k2 = t2 * f2;
    k3 = t3 * f3;
  }
};

}  // namespace haptic
