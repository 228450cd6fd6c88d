/// Bodies whose motion is given: platforms, lifts, turntables. They push and carry, and nothing pushes them.
///
/// A motion is a curve of poses that is smooth in velocity, so that a contact's places and speeds agree. Between two
/// points (p, R, V) a time T apart the origin runs along the cubic of Hermite that has both places and both speeds. The turn does so
/// as a rotation vector from the first: R(t) = exp[θ(t)] R_a, θ cubic, θ(0) = 0, θ(T) = log(R_b R_aᵀ). Its rate is ω = J(θ) θ̇ with
/// J the left Jacobian of the exponential, so θ̇ at the ends is ω_a and J⁻¹ ω_b (Chirikjian, Stochastic Models, Information Theory,
/// and Lie Groups 2, 2012, section 10.8). A constant turn rate gives a constant turn rate, to rounding.
///
/// Paths of a file: speeds at the rows are the differences to both sides, weighted by the other side's time (exact for parabolas); a
/// path that does not repeat begins and ends at rest. Bodies that are told poses one by one go from where they are to each of them,
/// and slow down to rest over as long again when no other comes.
///
/// Bodies that follow what another program says approach it. Where the poses told are a motion, the way that is left beyond the mean of
/// both speeds, d = p_b − p_a − (V_a + V_b) T/2, is half the change of speed times T. After a silence, a reset or a jump of the sender it
/// is any length, and covering it within T would throw a wall into the hand. So where 3/2 |d| / kFollowSpeed > T, the arrival waits:
/// T' = 3/2 |g| / kFollowSpeed, g = p_b − V_b T − p_a the gap to where the other is now, and it aims where the other will be by then. The
/// middle of a cubic from rest has 3/2 of its mean speed; and the start of a cubic that is planned anew with each pose has no acceleration,
/// (6 g/T' − 4 V)/T' = 0, at the speed V = kFollowSpeed beyond the other's. The last plan covers at most 2/3 V T + V T/2 within T, and its
/// fastest is 25/16 V.
#pragma once
#include <string>
#include <vector>

#include "haptic_core/world/definition.h"
#include "haptic_core/world/state.h"

namespace haptic {

class Model;

/// A place on a motion.
struct MotionPoint {
  Vector3 p_WL = Vector3::Zero();            ///< [m]
  Quaternion q_WL = Quaternion::Identity();  ///< orientation
  Twist V_WL;                                ///< at L's origin, in W
};

/// A MotionDef compiled for a world.
struct ModelMotion {
  std::string name;                          ///< for messages
  int link = 0;                              ///< world link index
  std::vector<double> time;                  ///< of the points [s], rising; empty: it is told its poses
  std::vector<MotionPoint> points;           ///< by time
  bool repeat = false;                       ///< after the last point it begins anew
};

/// What keeps the rows of a motion from being a path.
struct PathFault {
  int row = -1;                              ///< which, from 0; −1: nothing is wrong
  std::string what, remedy;                  ///< for a message
};
/// Of `def`: times that do not rise, a row without a pose, a number that is not finite, a turn of half a circle between two rows, a path
/// that repeats and does not close.
PathFault faultOf(const MotionDef& def);

/// Compiled from the definition; the model's trees are there already. Throws SetupError: no such link, a link on joints, a link that
/// two motions or a hand lead, times that do not rise, a turn of half a circle between two rows, a path that repeats and does not close.
std::vector<ModelMotion> compileMotions(const WorldDef& def, const Model& model);

/// (in realtime) Between two points, `t` of `T` after the first [s].
MotionPoint between(const MotionPoint& a, const MotionPoint& b, double T, double t) noexcept;

/// (in realtime) Where the body is at time t [s].
MotionPoint motionAt(const ModelMotion& motion, const MotionTarget& target, double t) noexcept;

/// The fastest that a body closes a gap to what it follows. 0.5 m/s is what a hand meets without being struck, and the fastest way of a
/// pointer's glide over 13 cm; a motion told in poses T apart may change its speed by 4/3 of it in T. More: a frame that comes back after
/// a silence strikes the hand. Less: hasty motions lag.
constexpr double kFollowSpeed = 0.5;      ///< [m/s]
constexpr double kFollowTurn = 5;    ///< the same at 0.1 m from the axis [rad/s]

/// A point that is to be reached, and the time for it.
struct Approach {
  MotionPoint to;      ///< where it arrives
  double seconds = 0;  ///< after so long [s]
};
/// (in realtime) `to`, which is to be reached from `from` after `seconds`; both are later where the gap is large.
Approach approachTo(const MotionPoint& from, const MotionPoint& to, double seconds) noexcept;

/// Where bodies that are told their poses begin: at rest at X_WL.
MotionTarget standingAt(const Pose& X_WL) noexcept;
/// (in realtime) The body leaves at `now` for a point that it reaches after `seconds`.
MotionTarget leavingFor(const ModelMotion& motion, const MotionTarget& before, const MotionPoint& to, double now, double seconds) noexcept;

}  // namespace haptic
