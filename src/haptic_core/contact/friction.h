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
/// s is a displacement between two poses, not the integral of a velocity: an anchor keeps the pose of B on A and the
/// slip of the layer at one instant. Only the bodies' present pose counts, not the motion and the steps in between. A stuck
/// patch keeps its anchor, so that no integrator makes it creep on a carrier that turns. Where a belt moves a surface over its shape the
/// memory goes with the surface, by the pose that the surface has then, turning included (`carryMemory`). The anchor is set anew where
/// friction slips or sticks again, and where the bodies have turned against each other by kMostTurn: so it follows a patch
/// that rolls. s is one displacement for the whole patch. New area is unstrained: s falls as A0 grows, the force stays; area that leaves
/// takes its energy along. Where s stays as the area grows, friction gives up to a quarter of the energy that a dropped body exchanges
/// (`power.friction_given_run_rel` .24 in place of 3e-7). The price: a cube that tilts down from .1 to .6 rad at 1e5 to 1e8 N/m³ is 1 to
/// 11 % farther from a rigid one, and where it rocks and friction holds throughout it ends 1.1 to 18 times as far aside, .11 to 3.7 mm.
/// r_τ = ∫p|r|/N is taken as ⅔√2 of p's radius of gyration: exact for uniform pressure on a disc, 0.2 % off on a
/// square, 4 % on a line; it decides only when a spinning patch yields, not the force while it slides.
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/contact/pressure_law.h"

namespace haptic {

/// Power that a contact takes from its bodies [W], by cause: k Vol n, the normal damper, friction. Linear in the wrench
/// and in the twist, so also work, of an impulse, and rates.
struct ContactPower {
  double elastic = 0, damping = 0, friction = 0;  ///< what each of them takes [W]

  /// Sum of two contacts or instants.
  ContactPower operator+(const ContactPower& o) const {
    return {elastic + o.elastic, damping + o.damping, friction + o.friction};
  }
  ContactPower operator*(double s) const { return {s * elastic, s * damping, s * friction}; }  ///< scaled

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.elastic), visit(s.damping), visit(s.friction);
  }
};

/// Of the wrench F_BP_P of which `elastic` is the spring's, at the twist of B relative to A at P, in P's axes.
ContactPower contactPower(const Wrench& F_BP_P, const Wrench& elastic, const Twist& V_AB_P) noexcept;

/// Pose of two bodies at one instant, and the slip that the layer between them held.
struct FrictionAnchor {
  Pose X_AB;                         ///< of B's shape in A's
  Vector3 point_A = Vector3::Zero(); ///< the patch [m]
  Vector3 normal_A = Vector3::Zero(); ///< n there, of A's axes
  Vector3 slip_A = Vector3::Zero();  ///< elastic displacement of B against A at the patch [m]
  double twist = 0;                  ///< elastic rotation of B against A about n [rad]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.X_AB), visit(s.point_A), visit(s.normal_A), visit(s.slip_A), visit(s.twist);
  }
};

/// How B has turned against A since an anchor, and the axes M that share the turn: A's axes of the anchor, turned by half of it. A
/// pair's memory goes with M, with neither of the bodies: which one is A decides nothing.
class SharedTurn {
 public:
  SharedTurn() = default;                                         ///< none: M's axes are A's
  explicit SharedTurn(const Matrix3& E);                          ///< E: B's turn against A, in A's axes

  Vector3 toA(const Vector3& v_M) const { return turned(v_M, u_, w_); }   ///< into A's axes now
  Vector3 toM(const Vector3& v_A) const { return turned(v_A, -u_, w_); }  ///< from A's axes now
  /// By half of M's turn, into A's axes now: of a way that began in A's axes of the anchor and in B's alike.
  Vector3 halfway(const Vector3& v) const;
  const Vector3& halfAxis() const { return u_; }  ///< axis times the sine of half the angle, in A's axes [1]
  double halfCosine() const { return w_; }        ///< cosine of half the angle [1]

 private:
  /// By an angle of which |s| is the sine and c the cosine, about s.
  static Vector3 turned(const Vector3& v, const Vector3& s, double c) {
    const Vector3 across = s.cross(v);
    return v + across + s.cross(across) / (1 + c);
  }
  Vector3 u_ = Vector3::Zero();
  double w_ = 1;
};

/// A touch at the end of a step has its impact in the next: `FrictionMemory::began` there.
inline constexpr double kStillBegins = 0.5;

/// Memory of a pair's contact: state of the world. Vectors at the last evaluation, in axes M since the anchor (`SharedTurn`).
struct FrictionMemory {
  FrictionAnchor anchor;              ///< where slip is measured from
  Vector3 point_A = Vector3::Zero();  ///< the patch, in A [m]
  Vector3 normal_A = Vector3::Zero(); ///< n, in A's axes
  Vector3 slip_M = Vector3::Zero();   ///< elastic displacement of B against A at the patch [m]
  Vector3 rate_M = Vector3::Zero();   ///< slip velocity [m/s]
  Vector3 force_M = Vector3::Zero();  ///< friction on B [N]
  double twist = 0;                   ///< elastic rotation of B against A about n [rad]
  double spin = 0;                    ///< ω about n [rad/s]
  double torque = 0;                  ///< of friction on B about n [N·m]
  double load = 0;                    ///< share of the limit that was used
  double area = 0, torsion = 0;       ///< A0 [m²], J [m⁴]
  double sliding = 0;                 ///< 1: slides, μ holds; 0: stuck, μ0 holds
  double touching = 0;                ///< 1: overlapped at the last evaluation
  double began = 0;                   ///< 1: that was the first; `kStillBegins`: of an implicit step, the second
  double energy = 0;                  ///< in the tangential springs [J]
  double elastic_energy = 0;          ///< ½ k ∫d² dA [J]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.anchor), visit(s.point_A), visit(s.normal_A), visit(s.slip_M), visit(s.rate_M), visit(s.force_M);
    visit(s.twist), visit(s.spin), visit(s.torque), visit(s.load), visit(s.area), visit(s.torsion);
    visit(s.sliding), visit(s.touching), visit(s.began);
    visit(s.energy), visit(s.elastic_energy);
  }
};

/// Constants of a pair.
struct PairLaw {
  ContactMaterial material;  ///< complete, see `combine`
  PressureLaw pressure = PressureLaw::kHuntCrossley;  ///< law of the normal pressure
  double reduced_mass = 0;   ///< m_A m_B/(m_A + m_B) [kg], for the critical tangential damper
  bool torsion = true;       ///< false: friction resists sliding only
  bool rigid = false;          ///< a model makes k as stiff as a step resolves, and k_t with it unless it is given
  bool shear_follows = false;  ///< no surface gives k_t
};

/// b_t of the pair [N·s/m³]: as given, or critical for its reduced mass on a patch of `area` [m²].
double tangentialDamping(const PairLaw& law, double area) noexcept;

/// How a patch may yield within one evaluation.
enum class Yielding : unsigned char {
  kAtOnce,      ///< a patch that stuck falls to μ where it has to hold more than μ0 N: explicit steps
  kNever,       ///< a patch that stuck stays elastic whatever its load
  kKeepsLimit,  ///< a patch that stuck yields at μ0 and keeps that limit: continuous, for implicit solves
  kDragged      ///< a patch that slid slides on against its last direction, wherever the slip turns
};

/// Rates at which belts carry the surfaces over their shapes, in the plane of the patch, at P in P's axes: x, y [m/s], about n [rad/s].
struct BeltRates {
  Vector3 a = Vector3::Zero(), b = Vector3::Zero();  ///< of A's surface and of B's

  bool any() const { return !a.isZero(0) || !b.isZero(0); }  ///< a surface moves over its shape
};

/// How the memory advances to this evaluation.
struct Advance {
  double time = 0;            ///< since the last one, or the base of a stage [s]; 0: the memory stays
  Yielding yielding = Yielding::kAtOnce;  ///< whether it may begin or stop sliding
  /// The damper sees the mean rate between the two poses, not the one at this instant: of steps of first order, whose rate
  /// lies off by the turn of the carrier within a step, and would hold a share of the force for ever.
  bool mean_rate = false;
  BeltRates belts;            ///< the twist that goes with them contains them; poses do not show them
  double run = 0;             ///< how long belts have run since the memory was last told [s]
  double since = 0;           ///< since the memory, where the base of a stage is later than it [s]; 0: `time`

  /// Over which springs follow their dampers from the memory [s].
  double lag() const { return since > 0 ? since : time; }
};

/// The friction law while the slip rate alone changes within a step: an elastic layer within an ellipsoid.
///     t(u) = -L (k s + b w + (b + h k) u),   L = diag(A0, A0, J),   s before, u the rate: (x, y, about n)
///     f = N o + the point of { |f|² / (μ N)² + τ²/(μ N r)² ≤ 1 } nearest to t - N o in the metric L⁻¹
/// f is the negative gradient of a convex function of u while N stays.
struct FrictionLayer {
  Vector3 area = Vector3::Zero();     ///< A0, A0, J [m², m⁴]
  double stiffness = 0, damping = 0;  ///< k_t [N/m³], b_t [N·s/m³]
  Vector3 before = Vector3::Zero();   ///< s without the slip of u within the step [m, rad]
  Vector3 rest = Vector3::Zero();     ///< w: rate of the damper beside u [m/s, rad/s]
  Vector3 offset = Vector3::Zero();   ///< o, where the area integral stands off the ellipsoid, per N [1, m]
  double mu = 0, radius = 0;          ///< μ, r [m]
  bool limited = true;                ///< false: elastic whatever the load
  bool dragged = false;               ///< f = N o, whatever the slip
  bool slid = false;                  ///< it slid at the start
  double lag = 0;                     ///< since `before`, where that is the memory's and the stage is shorter [s]; 0: the stage's length

  /// Force of the law for one rate.
  struct Hold {
    Vector3 force = Vector3::Zero();   ///< f [N, N·m]
    double straight = 1, turning = 1;  ///< shares of t - N o that are left of its force and torque [1]
    bool outside = false;              ///< t was beyond the limit
  };
  /// (in realtime) Of the rate u [m/s, rad/s] over `time` [s] under the normal force N [N].
  Hold hold(const Vector3& rate, double time, double N) const noexcept;
  /// (in realtime) How it answers a change of slip, see FrictionForce. `held`: of `hold` with the same N, likewise below.
  Matrix3 compliantArea(const Hold& held, double N) const noexcept;
  /// (in realtime) ∂f/∂N [1, 1, m] where t is beyond the limit, else 0: f is homogeneous of degree one in t and N, so it is
  /// (f - ∂f/∂t t)/N.
  Vector3 perLoad(const Hold& held, const Vector3& rate, double time, double N) const noexcept;
  /// (in realtime) Slip of the springs at the end [m, rad].
  Vector3 slip(const Hold& held, const Vector3& rate, double time, double N) const noexcept;
  double load(const Hold& held, double N) const noexcept;  ///< (in realtime) share of the limit that t uses [1]

 private:
  Vector3 strain(const Vector3& rate, double time) const noexcept;  ///< -L⁻¹ t [N/m², N/m³]
};

/// Friction of a patch at one evaluation, and the memory that it leaves.
struct FrictionForce {
  Vector2 force = Vector2::Zero();          ///< on B, in P's axes [N]
  double torque = 0;                        ///< about n [N·m]
  Vector2 slip = Vector2::Zero();           ///< elastic, new [m]
  double twist = 0;                         ///< [rad]
  double load = 0;                          ///< share of the limit that is used [1]
  bool sliding = false;                     ///< μ holds; else μ0
  /// The layer as it answers a change of slip, in (x, y, about n): A0, A0, J [m², m⁴] while stuck, without the
  /// direction of slip while sliding. ∂f/∂slip = -k_t times it, ∂f/∂rate = -b_t times it.
  Matrix3 compliant_area = Matrix3::Zero();
  FrictionLayer layer;                      ///< the law that gave it, where `yielding` is one of solves
  FrictionAnchor trial;                     ///< here and now, with the slip of a layer that does not yield
  bool renewed = false;                     ///< `trial`, less the slip that yielded, is the anchor from here on; else the old one stays
  SharedTurn since;                         ///< the old anchor
  Vector3 spread = Vector3::Zero();         ///< slip that is gone because the area has grown [m, m, rad]
};

/// (in realtime) Moves what the memory knows of the surfaces with them over `run` [s], forward or back: after that the memory is of shapes
/// whose surfaces stand, at these poses. Returns how A's surface turned, in A's axes.
Matrix3 carryMemory(const BeltRates& belts, double run, const Pose& X_AB, const Pose& X_AP, FrictionMemory& memory) noexcept;

/// (in realtime) A pure function. X_AB: of B's shape in A's. `V`: twist of B relative to A at P, in P's axes. `memory`: as belts have
/// carried it to this instant.
FrictionForce frictionForce(const ContactVolume& contact, const Pose& X_AB, ContactWorkspace& workspace,
                            const NormalPressure& normal, const Twist& V, const FrictionMemory& memory,
                            const PairLaw& law, const Advance& advance) noexcept;

/// Area of the layer under a patch [m²]: A0, and where a body is through another, so that the two cuts of the surface cancel,
/// no less than half of Vol/depth. A layer without area would hold μ N by a spring of no stiffness, with any energy in it.
double layerArea(const ContactVolume& contact) noexcept;

/// J of a patch [m⁴].
double torsionArea(const ContactVolume& contact) noexcept;

}  // namespace haptic
