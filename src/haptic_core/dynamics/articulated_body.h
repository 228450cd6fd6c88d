/// Forward dynamics of a tree by the articulated-body algorithm.
///
/// Solves (M(q) + diag) v̇ + c(q, v) = τ + Σ Jᵀ F_ext + gravity in O(links), without forming M: a sparse
/// factorisation from the leaves to the root and back.
/// Source: R. Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 7, table 7.1, with these
/// deviations:
/// * W axes and the reference point O of each link instead of link coordinates: an articulated inertia goes
/// to
///   its parent by a shift alone, no 6×6 rotation; r = p_O − p_Oparent is a small difference formed first.
/// * classical accelerations of points instead of spatial ones: bias (ω_P × S_ω v, ω_P × (ω_P × r + 2 S_v
/// v)).
/// * the sparsity of the axes: revolute and spherical axes pass through O (S = [a; 0]), sliding ones have no
///   angular part.
/// Symbols, per link: I = [A B; Bᵀ M] articulated inertia, p bias wrench, b bias acceleration, a = (α, a_O):
///   U = I S, D = SᵀU + diag, u = τ − Sᵀp,
///   I_parent += Xᵀ(I − U D⁻¹ Uᵀ)X,  p_parent += Xᵀ(p + I b + U D⁻¹ (u − Uᵀ b)),
///   v̇ = D⁻¹(u − Uᵀ a'),  a' = X a_parent + b,  a = a' + S v̇.
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/dynamics/kinematics.h"

namespace haptic {

/// (in realtime) v̇ [nv] from the last forwardKinematics and addWrench. Fills alpha and acceleration of every
/// link as well.
///
/// `tau`: generalised forces of joints, [nv], or null for none. For floating joints: torque and force about
/// O. `diag`: added to M's diagonal, ≥ 0, [nv], or null: rotor inertia; or h d + h² k, which makes a joint's
/// damping and stiffness implicit in the velocity step v + h v̇ (tau then holds them at the start of the step,
/// the spring's also for the way h v). `diag[i]` = infinity: degree i moves with the acceleration that the
/// caller put into `vdot[i]`; all degrees of one joint or none. That is how a link is moved from outside (a
/// hand) or a joint is locked; the force it takes is `jointWrench`.
void accelerations(const Articulation& articulation, const Vector3& gravity, const double* tau,
                   const double* diag, LinkWork* work, double* vdot) noexcept;

/// (in realtime) v̇ = (M + diag)⁻¹ τ with the factorisation that the last `accelerations` left in `work`
/// (called with a `diag`, which a free body needs for this); degrees it prescribed stay at 0. About a third
/// of its cost. `scratch`: 12 doubles per link.
void accelerationResponse(const Articulation& articulation, const double* tau, const LinkWork* work,
                          double* scratch, double* v_dot) noexcept;

/// (in realtime) The diagonal of (M + diag)⁻¹ [nv] with the factorisation that the last `accelerations` left in `work`; not of a free
/// body: how far each degree gives way to a force of its own. From the root on, Ω = P Ω_parent Pᵀ + S D⁻¹ Sᵀ with P = (1 − S D⁻¹ Uᵀ) X
/// is the mobility of a link, of (α, a) by a wrench on it, and D⁻¹ + D⁻¹ Uᵀ X Ω_parent Xᵀ U D⁻¹ the block of a joint. Costs a sixth more
/// than `accelerations`. `scratch`: 36 doubles per link.
void jointMobilities(const Articulation& articulation, const LinkWork* work, double* scratch, double* mobility) noexcept;

/// After accelerations: what acts through the joint on the link, about O, in W [N·m, N] (motor, bearing and
/// hand together); on the parent acts the opposite. Zero for free floating joints.
Wrench jointWrench(const Articulation& articulation, const LinkWork* work, int link,
                   const Vector3& gravity) noexcept;

}  // namespace haptic
