/// Dry friction of a patch: sticks with memory, slips by Coulomb's law over the area.
///
/// Stuck, the patch is an elastic layer k_t [N/m³] with its damper b_t: with s the elastic slip and φ the elastic
/// twist of B over A at P, A0 = ∫dA, J = ∫|r - r̄|² dA,
///     f = -A0 (k_t s + b_t v),   τ = -J (k_t φ + b_t ω).
/// It yields when (|f|/(μ0 N))² + (τ/(μ0 N r_τ))² > 1, and then slides with μ: f and τ are -μ times the integral of
/// the pressure along the direction of the plastic slip (sliding_friction.h): the trial force is brought back to the
/// nearest point of the limit surface in the metric of the springs (elastoplastic return mapping), an ellipsoid in
/// (f, τ) moved to where the area integral lies for the present direction of slip. So the force is a continuous and
/// monotone function of the slip, and the springs then hold just what slides. It sticks again when the springs would
/// push the motion on: the slip has come to a stop inside the step.
/// s lives in A's axes and is the integral of the slip at the patch, so it follows a patch that rolls or moves; it is
/// one displacement for the whole patch, whatever area joins or leaves. (Area that joined unstrained, s A0 kept, was
/// tried: the anchors of a tilting cube then stay behind, and its model error grows two to five times.) What a patch
/// gains by growing while it is strained is at most the energy at which it yields, (μ N)²/(2 k_t A0).
/// r_τ = ∫p|r|/N is taken as ⅔√2 of p's radius of gyration: exact for uniform pressure on a disc, 0.2 % off on a
/// square, 4 % on a line; it decides only when a spinning patch yields, not the force while it slides.
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/contact/pressure_law.h"

namespace haptic {

/// What a contact takes from its bodies, by what takes it [W]: k Vol n, the normal damper, friction. Linear in the wrench
/// and in the twist, so also work, of an impulse, and rates.
struct ContactPower {
  double elastic = 0, damping = 0, friction = 0;

  ContactPower operator+(const ContactPower& o) const {
    return {elastic + o.elastic, damping + o.damping, friction + o.friction};
  }
  ContactPower operator*(double s) const { return {s * elastic, s * damping, s * friction}; }

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.elastic), visit(s.damping), visit(s.friction);
  }
};

/// Of the wrench F_BP_P of which `elastic` [N] along n is k Vol, at the twist of B relative to A at P, in P's axes.
ContactPower contactPower(const Wrench& F_BP_P, double elastic, const Twist& V_AB_P) noexcept;

/// What a pair remembers of its contact: state of the world. Vectors in A's axes, at the last evaluation.
struct FrictionMemory {
  Vector3 slip_A = Vector3::Zero();   ///< elastic displacement of B against A at the patch [m]
  Vector3 rate_A = Vector3::Zero();   ///< slip velocity [m/s]
  Vector3 force_A = Vector3::Zero();  ///< friction on B [N]
  double twist = 0;                   ///< elastic rotation of B against A about n [rad]
  double spin = 0;                    ///< ω about n [rad/s]
  double torque = 0;                  ///< of friction on B about n [N·m]
  double load = 0;                    ///< share of the limit that was used
  double area = 0, torsion = 0;       ///< A0 [m²], J [m⁴]
  double sliding = 0;                 ///< 1: slides, μ holds; 0: stuck, μ0 holds
  double touching = 0;                ///< 1: overlapped at the last evaluation
  ContactPower power;                 ///< [W]
  ContactPower power_rate;            ///< of the same wrench while the bodies speed up [W/s]; explicit steps with a ledger
  double energy = 0;                  ///< in the tangential springs [J]
  double elastic_energy = 0;          ///< ½ k ∫d² dA [J]; filled when the ledger is kept

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.slip_A), visit(s.rate_A), visit(s.force_A), visit(s.twist), visit(s.spin), visit(s.torque), visit(s.load);
    visit(s.area), visit(s.torsion), visit(s.sliding), visit(s.touching), visit(s.power), visit(s.power_rate);
    visit(s.energy), visit(s.elastic_energy);
  }
};

/// Constants of a pair.
struct PairLaw {
  ContactMaterial material;  ///< complete, see `combine`
  PressureLaw pressure = PressureLaw::kHuntCrossley;
  double reduced_mass = 0;   ///< m_A m_B/(m_A + m_B) [kg], for the critical tangential damper
  bool torsion = true;       ///< false: friction resists sliding only
};

/// b_t of the pair [N·s/m³]: as given, or critical for its reduced mass on a patch of `area` [m²].
double tangentialDamping(const PairLaw& law, double area) noexcept;

/// What a patch may do within one evaluation.
enum class Yielding : unsigned char {
  kAtOnce,      ///< a patch that stuck falls to μ where it has to hold more than μ0 N: explicit steps
  kNever,       ///< a patch that stuck stays elastic whatever its load
  kKeepsLimit,  ///< a patch that stuck yields at μ0 and keeps that limit: continuous, for implicit solves
  kDragged      ///< a patch that slid slides on against its last direction, wherever the slip turns
};

/// How far the memory advances to this evaluation.
struct Advance {
  double time = 0;       ///< [s]; 0: the memory stays
  double old_share = 0;  ///< weight of the last slip velocity in the displacement: 0 Euler, ½ trapezoidal rule
  Yielding yielding = Yielding::kAtOnce;
};

struct FrictionForce {
  Vector2 force = Vector2::Zero();          ///< on B, in P's axes [N]
  double torque = 0;                        ///< about n [N·m]
  Vector2 slip = Vector2::Zero();           ///< elastic, new [m]
  double twist = 0;                         ///< [rad]
  double load = 0;
  bool sliding = false;
  double event = 1;                         ///< share of the step after which it began to slide or stuck; 1: neither
  Vector2 impulse = Vector2::Zero();        ///< what the trapezoidal rule misses of ∫f dt because of the event [N·s]
  double angular_impulse = 0;               ///< [N·m·s]
  /// The layer as it answers a change of slip, in (x, y, about n): A0, A0, J [m², m⁴] while stuck, without the
  /// direction of slip while sliding. ∂f/∂slip = -k_t times it, ∂f/∂rate = -b_t times it.
  Matrix3 compliant_area = Matrix3::Zero();
};

/// (in realtime) A pure function. `V`: twist of B relative to A at P, in P's axes.
FrictionForce frictionForce(const ContactVolume& contact, ContactWorkspace& workspace,
                            const NormalPressure& normal, const Twist& V, const FrictionMemory& memory,
                            const PairLaw& law, const Advance& advance) noexcept;

/// J of a patch [m⁴].
double torsionArea(const ContactVolume& contact) noexcept;

}  // namespace haptic
