/// From a contact volume and the relative motion of its bodies to the wrench between them.
///
/// Everything in the patch frame P of the contact volume: origin at V's centroid or `rise` over it, z = n (from A into B), on B.
/// Pressure: pressure_law.h. Friction: friction.h. Both are integrals over the patch; the wrench about P is
///     force (f, N),   torque (∫y p, -∫x p, τ).
#pragma once
#include "haptic_core/contact/friction.h"

namespace haptic {

/// Stiffness and damping of a patch about P in P's axes, rows and columns angular then linear, symmetric and positive
/// semidefinite. The implicit step, the settling of strong dampers and the certificate linearise with it.
/// With u = (θ_x, θ_y, z) the pressure at r changes by -∂p/∂d (z + θ_x y - θ_y x). Left out, because it is small or
/// would break the symmetry: the turn of n with the bodies, the share of friction that follows the normal force, the
/// slope of ḋ over the patch in ∂p/∂d.
struct PatchTangent {
  PatchMoments stiffness, damping;            ///< of the pressure
  Matrix3 compliant_area = Matrix3::Zero();   ///< of the friction layer, see FrictionForce
  double tangential_stiffness = 0, tangential_damping = 0;  ///< k_t [N/m³], b_t [N·s/m³]

  /// x K + y D. K = -∂F/∂(displacement of B against A) [N·m/rad … N/m], D = -∂F/∂(twist) [N·m·s/rad … N·s/m].
  Matrix6 combined(double x, double y) const noexcept;
};

/// The wrench between two bodies in contact, with its memory and its tangent.
struct LocatedForce {
  Wrench F_BP_P;              ///< on B at P, in P's axes
  double normal_force = 0;    ///< N [N]
  double elastic_force = 0;   ///< of it k Vol [N]
  /// Wrench of a spring with a potential beyond k Vol n: its share of F_BP_P, less where the damper takes from it, and the whole gradient.
  Wrench beyond_P, gradient_P;
  FrictionMemory memory;      ///< at this evaluation; the caller decides whether it becomes state
  bool sticking = false;      ///< friction holds the patch: μ0 is its limit
  bool clipped = false;       ///< the damper would pull somewhere: the pressure is held at 0 there
  PressedVolume pressed;      ///< of a clipped patch
  bool incomplete = false;    ///< faces laid over one another had no room for all of their corners
  PatchTangent tangent;       ///< linearisation for implicit steps and certificates
  /// Wrench of the spring: k Vol n, and the terms beyond it that make it a gradient.
  Wrench elastic() const { return {gradient_P.torque, gradient_P.force + Vector3(0, 0, elastic_force)}; }
  FrictionLayer layer;        ///< of a solve: the law of friction while only the slip rate changes
  bool on_belt = false;       ///< a belt moves one of the surfaces
  Matrix3 surface_turn = Matrix3::Identity();  ///< of A's surface by its belt since the old memory, in A's axes
  FrictionAnchor trial;       ///< see FrictionForce
  bool renewed = false;       ///< see FrictionForce
  SharedTurn since;           ///< see FrictionForce
  Vector3 yielded = Vector3::Zero();  ///< of a solve: slip that the layer gave up, (x, y, about n) [m, rad]
  /// A vector of the old memory's axes M, in those of the new one.
  Vector3 inNewAxes(const Vector3& v_M) const { return renewed ? since.toA(surface_turn * v_M) : Vector3(surface_turn * v_M); }
  /// Into the axes M of the new memory.
  Vector3 toM(const Vector3& v_A) const { return renewed ? v_A : since.toM(v_A); }
};

/// (in realtime) A pure function: nothing is stored. `workspace` holds the V that `contact` was computed from; it is
/// scratch where the pressure changes sign inside the patch. X_AB: of B's shape in A's. `V_AB_P` is the twist of B
/// relative to A at P, in P's axes. `told`: friction's memory as it was told last.
LocatedForce locatedForce(const ContactVolume& contact, const Pose& X_AB, ContactWorkspace& workspace, const Twist& V_AB_P,
                          const FrictionMemory& told, const PairLaw& law, const Advance& advance) noexcept;

}  // namespace haptic
