/// Contact properties of surfaces and how two of them make a pair.
#pragma once
#include <limits>
#include <string>

namespace haptic {

/// Contact properties of one surface. NaN: not given; the partner's value holds, or the world's default when
/// neither gives one. A stiffness that is not given is rigid where the world's default is.
struct ContactMaterial {
  static constexpr double kUnset = std::numeric_limits<double>::quiet_NaN();  ///< not given
  static constexpr double kRigid = std::numeric_limits<double>::infinity();  ///< a stiffness: as rigid as statics ask for
  double stiffness = kUnset;             ///< k [N/m³], pressure per depth; > 0, or kRigid
  double damping = kUnset;               ///< b [N·s/m³], pressure per approach speed (linear law); ≥ 0
  double dissipation = kUnset;           ///< c [s/m] of Hunt–Crossley p = k d max(0, 1 + c ḋ); ≥ 0
  double tangential_stiffness = kUnset;  ///< k_t [N/m³], shear stress per elastic slip; > 0; unset: ⅔ k
  double tangential_damping = kUnset;    ///< b_t [N·s/m³]; ≥ 0; unset: critical for the pair's reduced mass
  double mu_static = kUnset;             ///< μ0 ≥ μ; unset: μ
  double mu_dynamic = kUnset;            ///< μ ≥ 0; unset: μ0
  // Chosen where no number is given: analysis/chosen_stiffness.h. They hold for pairs of which neither surface gives one.
  double rest_stiffness = kUnset;        ///< least k with which the body rests as it should [N/m³]
  double touch_stiffness = kUnset;       ///< k where a hand touches this surface [N/m³]
  double rigid_stiffness = kUnset;       ///< least k with which the body rests as a rigid one should [N/m³]

  bool rigid() const { return stiffness == kRigid; }           ///< it says so
  bool saysNumber() const { return stiffness < kRigid; }       ///< of its stiffness: false for a rigid surface

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.stiffness), visit(s.damping), visit(s.dissipation), visit(s.tangential_stiffness);
    visit(s.tangential_damping), visit(s.mu_static), visit(s.mu_dynamic), visit(s.rest_stiffness), visit(s.touch_stiffness);
    visit(s.rigid_stiffness);
  }
};

/// The values that a pair gets where neither surface says anything. A 0.1 m cube of 0.1 kg has k_eff = k·Area =
/// 1e4 N/m and sinks 98 µm; explicit steps of 1 ms hold it with a margin of 40.
struct DefaultMaterial {
  static constexpr double kStiffness = 1e6;    ///< [N/m³]
  static constexpr double kRigid = 1e10;       ///< [N/m³] of rigid pairs at least
  static constexpr double kDamping = 0;        ///< [N·s/m³]
  static constexpr double kDissipation = 10;   ///< [s/m]: no force while parting faster than 0.1 m/s
  static constexpr double kTangentialRatio = 2.0 / 3.0;  ///< k_t/k: shear against compression of an elastic layer
  static constexpr double kMu = 0.5;                     ///< μ0 = μ [1]
};

/// Material of a pair from its surfaces' and the world's default. Where both surfaces give a value:
///   k, k_t   harmonic mean 2ab/(a+b): two springs in series, scaled so that equal surfaces give their own value
///   b, b_t, c  arithmetic mean;   μ0, μ  geometric mean.
/// A rigid surface adds no compliance of its own: against k it makes 2k, the limit of the mean. Against a rigid one, or one that says
/// nothing, it makes the k chosen for rigid bodies. Under a rigid default every surface that says nothing is rigid. Where neither says
/// anything, nor the world's default: the touch's, else the larger of `DefaultMaterial`'s and those of the bodies at rest. The touch's
/// comes before that of rigid bodies as well.
/// Every field of the result is set but `tangential_damping`, which may stay unset (critical).
ContactMaterial combine(const ContactMaterial& a, const ContactMaterial& b, const ContactMaterial& fallback);

/// Whether `combine` makes the k that was chosen for rigid bodies.
bool isRigid(const ContactMaterial& a, const ContactMaterial& b, const ContactMaterial& fallback);

/// Throws SetupError, naming `where`, field and value: k or k_t ≤ 0, negative damping, μ < 0 or > 10, μ > μ0,
/// infinities but kRigid of k. NaN means "not given" and passes.
void check(const ContactMaterial& material, const std::string& where);

}  // namespace haptic
