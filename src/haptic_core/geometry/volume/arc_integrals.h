/// Integrals over an arc of the unit circle, by sums, products and square roots alone: the same bits on every
/// machine.
#pragma once
#include <cmath>

namespace haptic {

/// ∫ (1 − cos θ)ᵏ dθ from −φ to φ for k = 0…3, 0 ≤ φ ≤ π/2, to rounding relative to each.
///
/// With τ = φ/2 they are 2ᵏ⁺² W_2k, W_2k = ∫ sin²ᵏ from 0 to τ, and (2k − 1) W_2k−2 = 2k W_2k + sin²ᵏ⁻¹τ cos
/// τ: a sum of positive terms from a k at which W vanishes. Beyond 0.3 rad so many terms are not needed: φ
/// itself is eight times the angle whose sine three halvings give, by the same sum, and the others are closed
/// forms, which lose a digit there.
struct ArcIntegrals {
  double k0, k1, k2, k3;  ///< by k [rad]

  /// (in realtime) Of φ, by its sine and cosine.
  ArcIntegrals(double sine, double cosine) {
    if (sine < kShort) {
      const double half = sine / std::sqrt(2 * (1 + cosine)), square = half * half,
                   rest = half * std::sqrt(1 - square);
      double w[kTerms + 1], power[kTerms];
      power[0] = rest;
      for (int k = 1; k < kTerms; ++k) power[k] = power[k - 1] * square;
      w[kTerms] = 0;
      for (int k = kTerms; k > 0; --k) w[k - 1] = (2 * k * w[k] + power[k - 1]) / (2 * k - 1);
      k0 = 4 * w[0], k1 = 8 * w[1], k2 = 16 * w[2], k3 = 32 * w[3];
      return;
    }
    double s = sine, c = cosine;
    for (int i = 0; i < 3; ++i) s /= std::sqrt(2 * (1 + c)), c = std::sqrt(0.5 * (1 + c));
    // asin s = s √(1 − s²) (1 + 2/3 s² (1 + 4/5 s² (1 + 6/7 s² (…
    double sum = 0;
    for (int k = kTerms; k > 0; --k) sum = (1 + sum) * (2 * k * s * s) / (2 * k + 1);
    const double angle = 8 * s * c * (1 + sum), sc = sine * cosine;
    k0 = 2 * angle;
    k1 = 2 * (angle - sine);
    k2 = 3 * angle - 4 * sine + sc;
    k3 = 5 * angle - 8 * sine + 3 * sc + 2.0 / 3 * sine * sine * sine;
  }

  static constexpr double kShort = 0.3;  ///< of sines: shorter arcs by the sum alone
  static constexpr int kTerms = 14;      ///< of the sum: 0.023ᵏ and 0.038ᵏ are below rounding
};

}  // namespace haptic
