/// How fast the wrench on a hand may change: the one law between two ticks, for every force.
///
/// The device multiplies the whole wrench by one gain s in 0…1, just before the tensions; what is presented follows s·F by this law. So
/// whatever sets s or F (pause, restore, grab, release, a late tick, REDUCED, a study's condition, another scene) changes no force faster.
/// STOP, FAULT, an interruption and the dead-man switch alone end it at once.
///
/// With ρ the rate, x, θ the measured grip, K the largest wall that the loop bears (wall_bound.h), r the reach of what the wrench acts
/// through, as the grip has it,
///     |F_n - F_(n-1)| ≤ K |x_n - x_(n-1)| + ρ h,      |T_n - T_(n-1)| ≤ r (K |x_n - x_(n-1)| + K r |θ_n - θ_(n-1)| + ρ h).
/// A wall within its own bound (world/hand_bound.h) changes no faster by the hand's way: the law leaves it as it is. The rest that
/// changes a contact's force is the world's own: a cube slips from under the tool, a face takes over from an edge, the tool comes free.
/// It takes a tick in the world and is a stroke on the hand. A step is made of two parts:
///     the world's own change since the last tick, at most K |Δx|; then, of the rest, the unused part of K |Δx|, and ρ h.
/// The first turns in the tick in which the world's force turns: a law that only ran after the force came late where it turned, and a
/// light tool in the air swung by 9 N. The second makes the held-back force good, as a spring of K would.
///
/// Energy. A force F that is released while the hand moves along it gives F²/2(K + ρ/v), v the hand's speed: at most F²/2K, what the
/// stiffest wall that the loop bears gives back itself, 11 mJ of 10 N; at rest nothing. The bound F² v/2ρ of a release by ρ alone does not
/// come near, because K |Δx| releases as well. The passivity observer counts it, for the tensions that it sums are those presented; its
/// controller (loop/passivity.h) acts behind this law and may take force away faster, against the motion.
/// Source: the energy-bounding algorithm of Kim and Ryu (IJRR 29(6), 2010) bounds the force's change over the grip's way by what
/// the device's damping takes. Deviation: K is the loop's own bound; ρ lets a force come and go under a hand that rests.
#pragma once
#include "haptic_core/base/spatial.h"

namespace haptic {

/// How long a hand is led out of its force before its port goes to another owner, which waits a second for it [s]. The law takes 10 N away
/// in .1 s.
constexpr double kLeadOutSeconds = 0.3;

/// What bounds a wrench's change.
struct ForceSlew {
  double stiffness = 0;  ///< K [N/m]
  double reach = 0;      ///< r [m]
  double rate = 0;       ///< ρ [N/s]

  /// (in realtime) The wrench on the hand where the one wanted is `world`, both were `last_world` and `last` a tick of h [s] ago, and the
  /// grip has moved at `moved` [rad/s, m/s] on average since then.
  Wrench led(const Wrench& world, const Wrench& last_world, const Wrench& last, const Twist& moved, double h) const noexcept {
    const double by_way = h * stiffness * moved.linear.norm();
    const double by_turn = reach * (by_way + h * stiffness * reach * moved.angular.norm());
    const auto next = [](const Vector3& to, const Vector3& before, const Vector3& from, double by_grip, double by_time) {
      const auto part = [](const Vector3& v, double most) { return v.norm() > most ? Vector3(most / v.norm() * v) : v; };
      if ((to - from).norm() <= by_grip + by_time) return to;
      const Vector3 along = part(to - before, by_grip);
      return Vector3(from + along + part(to - from - along, by_grip - along.norm() + by_time));
    };
    return {next(world.torque, last_world.torque, last.torque, by_turn, reach * rate * h),
            next(world.force, last_world.force, last.force, by_way, rate * h)};
  }
};

}  // namespace haptic
