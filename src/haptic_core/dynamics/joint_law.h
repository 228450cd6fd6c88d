/// The law of a joint of one degree: damping, Coulomb friction, limits, a drive. Implicit in the
/// step.
///
/// Over a step h the force of a joint is a function of its velocity at the end of the step, v₁, with
/// q₁ = q + h v₁. Every part falls with v₁, so the sum is a monotone graph of straight pieces:
///   damping   −d v₁
///   spring    −k_s (q + h v₁ − q_s)
///   drive     clamp(k_p (q_ref − q − h v₁) + k_d (v_ref − v₁) + effort, ±max_effort)
///   friction  −f₊ where v₁ > 0, f₋ where v₁ < 0, any of [−f₊, f₋] at v₁ = 0 (it sticks: no creep); both f but for threads (thread.h)
///   limits    no v₁ below (lower − q)/h or above (upper − q)/h: there the force is whatever it takes
/// Falling and implicit means stable for every gain and step; stopping at a limit projects the velocity onto
/// a convex set that contains rest, in the norm of kinetic energy, so a limit never adds energy.
#pragma once
#include <limits>

#include "haptic_core/dynamics/articulation_def.h"

namespace haptic {

/// A joint moves by less than this in a step where it counts as standing [rad] or [m]: rounding of a position. Wider, steps that hit a
/// limit would pass for smooth; narrower, joints at rest on a limit would never, and would bounce there between limit and rounding.
inline constexpr double kStandingWay = 1e-12;

/// A command to a drive; the parts its mode does not use are ignored. The gains are the joint's.
struct JointCommand {
  JointDef::Drive drive = JointDef::Drive::kNone;  ///< which of the values below it follows
  double position = 0;  ///< q_ref [rad] or [m]
  double velocity = 0;  ///< v_ref [rad/s] or [m/s]
  double effort = 0;    ///< feed-forward [N·m] or [N]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.drive), visit(s.position), visit(s.velocity), visit(s.effort);
  }
};

/// Command of a joint before any is given: its own drive, at its initial position, with its feed-forward.
inline JointCommand initialCommand(const JointDef& joint) { return {joint.drive, joint.position, 0, joint.drive_effort}; }

/// Whether a drive may be given it: all numbers finite.
bool isFinite(const JointCommand& command) noexcept;

/// A piece of the graph: force = offset − slope v₁ for v₁ in [from, to], or, vertical at v₁ = from, any force
/// in [low, high].
struct ForcePiece {
  bool vertical = false;         ///< at v₁ = from the joint holds with any force from low to high
  double from = 0, to = 0;       ///< [rad/s] or [m/s]
  double offset = 0, slope = 0;  ///< [N·m] or [N]; per velocity
  double low = 0, high = 0;      ///< [N·m] or [N]
};

/// The graph of one joint for one step, pieces ordered by velocity.
struct ForceGraph {
  static constexpr int kMostPieces =
      9;  ///< two limits, friction, three kinks: at most 4 + 1 straight, 3 vertical
  ForcePiece pieces[kMostPieces];  ///< by rising velocity
  int count = 0;                   ///< pieces in use

  /// The piece to start from when the velocity is v: a vertical one at exactly v, else the straight one
  /// around it, else the end that stops it.
  int at(double v) const;
  /// One step of a search for the piece that holds the solution: `piece` moves to its neighbour when v₁ lies outside
  /// a straight one, or the force that a vertical one takes outside its range. True: it moved.
  bool follow(double v1, double force, int& piece) const noexcept;
};

/// Passes of that search in which every joint moves, before one at a time, the last that wants to (Murty's rule, which
/// cannot cycle); above, only time is lost [1].
inline constexpr int kBlockPasses = 8;
/// Passes per joint law after that; Murty's rule needs fewer in practice, its worst case is out of reach [1].
inline constexpr int kSinglePasses = 4;

/// Largest friction against a motion in either direction [N·m] or [N].
struct JointFriction {
  double forward = 0, backward = 0;  ///< where v > 0, where v < 0
  bool sticks = false;               ///< the graph has a piece at rest, whatever the two are
};

/// Friction of the joint's own bearing.
inline JointFriction frictionOf(const JointDef& joint) noexcept { return {joint.friction, joint.friction, joint.friction > 0}; }

/// (in realtime) The graph of `joint` at q over a step h.
/// A joint outside its limits is led back within 20 ms or a step, whichever is longer, so that it is not
/// thrown.
void buildForceGraph(const JointDef& joint, const JointFriction& friction, const JointCommand& command, double q, double h,
                     ForceGraph& graph) noexcept;

/// Force of the drive alone at v₁ [N·m] or [N], for the energy ledger.
double driveForce(const JointDef& joint, const JointCommand& command, double q, double h, double v1) noexcept;

/// Force of a law where it is smooth.
struct SmoothForce {
  double drive = 0;  ///< of the drive [N·m] or [N]
  double all = 0;    ///< of drive, spring, damping and friction together
  double slope = 0;  ///< that the graph of a step h has here [N·m·s/rad] or [N·s/m]
  int side = 0;      ///< of the kinks: another number beyond one
  static constexpr int kOnAKink = -1;  ///< side of a joint that sticks, or stands at or beyond a limit
};

/// (in realtime) The law at (q, v), as it is without a step.
SmoothForce smoothForce(const JointDef& joint, const JointCommand& command, double q, double v, double h) noexcept;

/// Energy of the joint's spring at q [J].
inline double springEnergy(const JointDef& joint, double q) noexcept {
  return 0.5 * joint.spring_stiffness * (q - joint.spring_position) * (q - joint.spring_position);
}

/// The joint's own law. A follower (mimic) keeps damping and spring alone: the followed one has limits,
/// friction and drive for both, and a second set would contradict them.
JointDef ownLaw(const JointDef& joint);

/// Whether commands can move it: it has a drive, or gains for one.
bool isDriven(const JointDef& joint);

/// False for a joint that only turns or slides: its graph would be zero everywhere.
bool hasLaw(const JointDef& joint);

}  // namespace haptic
