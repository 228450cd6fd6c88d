/// The force law of a contact with its geometry frozen: without friction the gradient of a convex function of the relative twist.
///
/// At a reference pose the patch is replaced by weighted points. With r̄ = A1/A0, C = A2/A0 - r̄ r̄ᵀ and its
/// eigenpairs (λ_j, e_j),
///     r = r̄ ± √(2 λ_j) e_j,   w = A0/4,   d = (Vol/A0) (1 ∓ √2 r̄·e_j/√λ_j),
/// which has the patch's area, its first and second moments, its volume and the centroid of its volume: force and
/// stiffness at the reference are exact. Each point is then split into two of depths d (1 ± s), with s such that ∫ d² dA,
/// and so the elastic energy, is exact too: an edge or a corner that backs out then loses its force where the true one
/// nearly does, not after a half or a third of its depth. Where the pressure is clipped inside the patch, the part that
/// presses stands for the patch.
///
/// With V the twist of B over A at P, v_n = v_z + ω_x y - ω_y x, and D = d + g v_n at the reference (the depth that stays
/// without motion along n), a point presses with
///     Hunt–Crossley   k w (D - g v_n)₊ (1 - c v_n)₊
///     linear          w (k (D - g v_n) - b v_n)₊   while D > g v_n.
/// Both fall with v_n: gradients of convex functions. The second moment of the thickness that four points miss is made
/// good by a common factor of the pressures and a common shift of the places, and what is left of the moments by a constant: the force at
/// the reference is exact. That constant, and the wrench of a spring with a potential beyond k Vol n, go with the pressure: where the patch
/// opens they end (`contact.stopped_worlds`: a constant that stays throws light bodies at 1e11 N/m³ and above).
/// Friction is a FrictionLayer, whose limit is that of this normal force. Where a patch opens or closes by
/// more than its depth the four points are a caricature:
/// stage_reference.h freezes anew at the end that they predict.
///
/// Where two nearly parallel faces meet, `spread` puts what these have in common in place of the points (face_overlay.h):
/// the same pressures, integrated over the part that presses at the twist. What rocks, tips or settles on a face moves its
/// patch from one edge to the other in turns of a micrometre; frozen, that is a change of the pressing part, exact
/// to the first order in the motion.
///
/// Cost of `freeze` and `evaluate`: about 30 ns each, 100 ns where friction slides; over faces 100 ns more.
#pragma once
#include <algorithm>
#include <cmath>

#include "haptic_core/contact/located_force.h"
#include "haptic_core/geometry/pairs/face_overlay.h"

namespace haptic {

/// The force law of one contact, with its geometry frozen at one reference.
class FrozenPatch {
 public:
  /// (in realtime) `force` is the exact one of `volume` at the twist V (of B over A at P, in P's axes), for a stage of
  /// length g [s].
  /// `squares`: ∫ d² dA [m⁴].
  void freeze(const ContactVolume& volume, double squares, const LocatedForce& force, const PairLaw& law, const Vector6& V,
              double g) noexcept;
  /// (in realtime) Bars a pair that is not in contact yet: `near` is the V of the same shapes `closer` [m] to one another along its
  /// normal. Points with a gap press once it closes, without friction; a part that touches already is left to the exact patch.
  void freezeNear(const ContactVolume& near, double closer, const PairLaw& law, const Vector6& V, double g) noexcept;
  /// (in realtime) The same for two faces that do not touch.
  void freezeNear(const FaceOverlay& faces, const PairLaw& law, const Vector6& V, double g) noexcept;
  /// (in realtime) After `freeze` at V: the faces in place of the points. False, and nothing done, where they do not press
  /// about as much as the patch.
  bool spread(const FaceOverlay& faces, const Vector6& V) noexcept;
  /// (in realtime) The bodies have come apart at a twist V at which the points still press: lets them touch there at most.
  void part(const Vector6& V) noexcept;

  /// The frozen force at one twist.
  struct Force {
    Vector6 F = Vector6::Zero();  ///< on B at P, in P's axes [N·m, N]
    double normal = 0;            ///< N [N]
    FrictionLayer::Hold friction;     ///< of it
    Vector3 first = Vector3::Zero();  ///< N, ∫ x p, ∫ y p: moments with (1, x, y) [N, N·m]
    double share = 1;                 ///< N over that at the reference, at most 1: by it the constant moments and `beyond_` count
  };
  /// (in realtime) The force at a twist.
  void evaluate(const Vector6& V, Force& out) const noexcept;
  /// (in realtime) The same at the twist of `freeze` or `spread`, where pressure is known. False: it was changed since.
  bool evaluateAtReference(const Vector6& V, Force& out) const noexcept;
  /// (in realtime) Friction as if it stuck, whatever it has to hold: in place of that in `out`, of `evaluate` there.
  void stick(const Vector6& V, Force& out) const noexcept;
  /// (in realtime) Friction at V under the normal force of a wrench F that a step took for it, less F's own [N]: F kept another limit.
  Vector2 missedFriction(const Vector6& V, const Vector6& F_done) const noexcept;
  /// (in realtime) -g ∂F/∂V while friction's limit stays, symmetric and positive semidefinite [N·s·m … N·s/m]; its last row is of the
  /// normal force. `force`: of `evaluate` there, likewise below.
  Matrix6 tangent(const Vector6& V, const Force& force) const noexcept;
  /// (in realtime) ∂F/∂N that the limit adds to it [m … 1].
  Vector6 perLoad(const Vector6& V, const Force& force) const noexcept;

  /// (in realtime) Takes an exact contact from the reference to the twist V: force, friction's memory, powers, and the
  /// elastic energy to the first order. `at_V`: of `evaluate` there.
  void carry(const Vector6& V, const Force& at_V, const Pose& X_AP, LocatedForce& force, double& elastic) const noexcept;

  /// (in realtime) No force.
  void forget() noexcept { points_ = 0, faces_.clear(), constant_.setZero(), beyond_.setZero(), is_known_ = false; }
  /// (in realtime) Whether this patch of the same pair lies elsewhere than `other`, not within its extent.
  bool isElsewhere(const FrozenPatch& other) const noexcept { return (place_ - other.place_).norm() > 1.5 * other.radius_; }

  /// (in realtime) Depth that the frozen geometry misses after a motion of twist V over the stage [m], to its order.
  double missedDepth(const Vector6& V, double mean_depth) const noexcept;
  double stiffness() const noexcept { return k_ * scale_ * (faces_.empty() ? weight_ * points_ : faces_.area()); }  ///< along n [N/m]
  double extent() const noexcept { return 2 * radius_; }  ///< about half the width of the patch [m]

 private:
  double approachOf(const Vector6& V, int i) const noexcept {  // v_n, positive while parting
    return V[5] + V[0] * y_[i & 3] - V[1] * x_[i & 3];
  }
  Vector3 slipRate(const Vector6& V) const noexcept {
    return {V[3], V[4], torsion_ ? V[2] : 0.0};
  }
  double press(double v_n, double reach, double& slope) const noexcept;
  void layOut(const ContactVolume& volume, const PatchMoments& area, double thickness, const Vector2& V1) noexcept;
  void setLaw(const PairLaw& law, double g) noexcept;
  void sum(const Vector6& V, Vector3& first) const noexcept;
  LinearField approachField(const Vector6& V) const noexcept { return {V[5], -V[1], V[0]}; }
  LinearField openField(const Vector6& V) const noexcept;
  LinearField pressureField(const Vector6& V) const noexcept;
  void setForce(Force& out) const noexcept;
  template <class Visit>
  void eachPressing(const Vector6& V, Visit&& visit) const noexcept;
  void setReach(const Vector6& V) noexcept;
  void matchForce(const Vector3& exact, const Vector6& V) noexcept;
  Vector2 springsOver(const LinearField& thickness) const noexcept;
  Vector2 springsGained(const Vector6& V) const noexcept;

  double g_ = 0, k_ = 0, c_ = 0, b_ = 0, weight_ = 0;
  bool linear_ = false, torsion_ = true;
  static constexpr int kPoints = 8;
  int points_ = 4;                       ///< 4, or 8 where s counts; point i and i + 4 stand at one place
  double x_[4], y_[4];                   ///< the places [m]
  double depth_[kPoints], reach_[kPoints];  ///< d and D [m]
  Vector3 constant_ = Vector3::Zero();   ///< rest of the exact force at the reference: N, ∫ x p, ∫ y p
  Vector6 beyond_ = Vector6::Zero();     ///< wrench of the spring beyond k Vol n, as at the reference (LocatedForce)
  Vector3 place_ = Vector3::Zero();      ///< centroid in A's frame [m]
  double radius_ = 0;                    ///< of gyration of its area [m]
  double load_ = 0;                      ///< pressure of points or faces at the reference [N]
  Vector3 first_ = Vector3::Zero();      ///< sums at the reference, while they are known
  bool is_known_ = false;
  FaceOverlay faces_;                    ///< in place of the points, unless empty
  LinearField faces_reach_;              ///< D over the faces [m]
  double scale_ = 1;                     ///< of all pressures
  FrictionLayer friction_;
};

}  // namespace haptic
