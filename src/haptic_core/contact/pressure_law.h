/// Normal pressure over a patch, never negative, and its exact integrals.
///
/// With r = (x, y) in the patch frame, thickness d(r), and V the twist of B relative to A at P, the approach rate is
///     ḋ(r) = -(v_z + ω_x y - ω_y x),
/// less the spins that compress nothing (CompressingRate): a ball or a cylinder that rolls moves its patch along its surface. Its damper
/// has no moment about such an axis, so the rest is dissipative.
///     damper beside the spring   p = max(0, k d + b ḋ)      jumps at touch
///     damper within it           p = k d max(0, 1 + c ḋ)    continuous at touch and at parting
/// These pressures stand along n. k V n is no gradient where n turns with the bodies; a law with a `potential` adds what
/// makes it one (`beyondNormal`).
/// A law is one of the two and where its b or c comes from (kPressureKinds); `linear` (the seeds' law) and Hunt–Crossley
/// are the two themselves.
/// Where nothing is clipped, force and moments are sums over the moments of the volume. Where 1 + c ḋ changes sign
/// the patch is cut along that line; where k d + b ḋ does, the faces below and above are overlaid and each piece,
/// on which p is linear, is cut. Both are exact.
#pragma once
#include "haptic_core/contact/contact_material.h"
#include "haptic_core/contact/sliding_friction.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic {

/// The laws that files can name: a linear damper beside the spring, or Hunt & Crossley's within it; and the latter with a spring
/// that has a potential.
enum class PressureLaw : unsigned char { kLinear, kHuntCrossley, kPotential };

/// A row of `kPressureKinds`: all properties of a law.
struct PressureKind {
  PressureLaw law;                            ///< the law it describes
  const char* name;                           ///< in files
  /// Where the damper stands: p = k d + b ḋ beside the spring, p = k d (1 + c ḋ) within it.
  enum class Damper : unsigned char { kBesideSpring, kWithinSpring } damper;
  double (*damping)(const ContactMaterial&);  ///< b [N·s/m³] beside the spring, c [s/m] within it; ≥ 0
  /// The spring's wrench is the gradient of ½ k ∫ d² dA (thickness_gradient.h), not k V n alone.
  bool potential = false;
};

/// All laws, in the order of `PressureLaw`.
inline constexpr PressureKind kPressureKinds[] = {
    {PressureLaw::kLinear, "linear", PressureKind::Damper::kBesideSpring,
     [](const ContactMaterial& m) { return m.damping; }},
    {PressureLaw::kHuntCrossley, "hunt_crossley", PressureKind::Damper::kWithinSpring,
     [](const ContactMaterial& m) { return m.dissipation; }},
    {PressureLaw::kPotential, "potential", PressureKind::Damper::kWithinSpring,
     [](const ContactMaterial& m) { return m.dissipation; }, true},
};

/// The row of a law.
constexpr const PressureKind& kindOf(PressureLaw law) { return kPressureKinds[static_cast<int>(law)]; }
/// The pressure jumps from 0 where a contact begins while bodies approach.
constexpr bool jumpsAtTouch(PressureLaw law) { return kindOf(law).damper == PressureKind::Damper::kBesideSpring; }

/// The factor (1 + c ḋ) of the stiffness does not fall below this: a patch that parts fast presses little, but a
/// Newton step that believed it weightless would throw it back in.
constexpr double kLeastPressing = 0.05;

/// ∫ w, ∫ r w, ∫ r rᵀ w dA of a weight w over the patch.
struct PatchMoments {
  double m0 = 0;                                                               ///< ∫ w dA
  Vector2 m1 = Vector2::Zero();                                                ///< ∫ r w dA
  Matrix2 m2 = Matrix2::Zero();                                                ///< ∫ r rᵀ w dA
  PatchMoments operator*(double s) const { return {s * m0, s * m1, s * m2}; }  ///< scaled
  /// Sum of two patches or weights.
  PatchMoments operator+(const PatchMoments& o) const { return {m0 + o.m0, m1 + o.m1, m2 + o.m2}; }
};

/// V where the pressure is not held at 0.
struct PressedVolume {
  double volume = 0;                ///< ∫ d dA [m³]
  Vector2 first = Vector2::Zero();  ///< ∫ r d dA [m⁴]
};

/// Normal pressure over a patch, and its integrals.
struct NormalPressure {
  double force = 0;                    ///< ∫ p dA [N]
  Vector2 first = Vector2::Zero();     ///< ∫ r p dA [N·m]
  double elastic_force = 0;            ///< k ∫ d dA [N]: the part at rest
  double radius = 0;                   ///< extent of the patch about P [m]
  PressureField field;                 ///< p before clipping, for the friction integral
  int dropped = 0;                     ///< corners of the overlay for which there was no room
  bool clipped = false;                ///< somewhere in the patch p is held at 0
  PressedVolume pressed;               ///< of a clipped patch
  PatchMoments stiffness, damping;     ///< of ∂p/∂d (its factor 1 + c ḋ taken at its mean) and of ∂p/∂ḋ

  /// Moments for the friction series: the second is the elastic one, scaled to the force.
  PressureMoments moments(const ContactVolume& contact) const {
    return {force, first, contact.volume > 0 ? Matrix2(force / contact.volume * contact.V2) : Matrix2::Zero()};
  }
};

/// (in realtime) Wrench of a spring with a potential beyond k V n, on B about P in P's axes; zero under the other laws.
/// Cost: thicknessGradient.
Wrench beyondNormal(const ContactVolume& contact, ContactWorkspace& workspace, PressureLaw law, const NormalPressure& pressure) noexcept;

/// (in realtime) Share of it that the damper leaves [1]: all but where it takes most of the pressure away, none where it takes
/// all. A patch that no longer presses must not pull.
double shareBeyond(const NormalPressure& pressure) noexcept;

/// (in realtime) `V` is the twist of B relative to A at P in P's axes. `workspace` holds V of `contact`.
NormalPressure normalPressure(const ContactVolume& contact, ContactWorkspace& workspace, const Twist& V,
                              PressureLaw law, const ContactMaterial& material) noexcept;

}  // namespace haptic
