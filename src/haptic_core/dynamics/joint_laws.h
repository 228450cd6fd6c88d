/// What joints do by themselves (joint_law.h), on top of whichever linear solver finds their motion.
///
/// Every joint stands on one piece of its graph. The solver takes the pieces as given: a straight one adds its slope to the
/// diagonal and its offset to the right side, a vertical one (stuck, at a limit) prescribes the velocity, and the force it
/// takes is read off. Joints that come out beyond their piece move to the neighbouring one and the solve is repeated: block
/// pivoting, which ends at the unique solution in one to three passes as a rule; when it does not (a cycle), only the last
/// such joint moves (Murty's rule, which cannot cycle on a positive definite operator).
///
/// The operator is the inertia of one articulation (tree_motion.h), or that of an island with its contacts
/// (stepping/implicit_joints.h).
#pragma once
#include <vector>

#include "haptic_core/dynamics/articulation.h"
#include "haptic_core/dynamics/joint_law.h"

namespace haptic {

/// Work in a step or a part of it [J].
struct JointWork {
  double damping = 0;   ///< dissipated by joint damping
  double friction = 0;  ///< dissipated by joint friction and limits
  double drives = 0;    ///< work of drives on the joints
};

/// Damping, friction, limits and drives of the joints of one or several articulations.
class JointLaws {
 public:
  /// A joint of one degree. Indices are those of the caller's links, commands, q and v.
  struct Law {
    JointDef joint;  ///< of a mimic's follower nothing but damping
    int link = 0, command = 0, q = 0, v = 0;  ///< the caller's indices
    double q_start = 0;                       ///< at the start of the step [rad] or [m]
    ForceGraph graph;                         ///< of this step
    int piece = 0;                            ///< index of the piece it stands on

    const ForcePiece& now() const { return graph.pieces[piece]; }  ///< the piece it stands on
  };
  /// A degree of a joint of several; of these damping alone is simulated.
  struct Damped {
    int v = 0;           ///< index of its velocity
    double damping = 0;  ///< [N·m·s/rad] or [N·s/m]
  };
  /// How a joint came out: its velocities before and after, and the force of its law [N·m] or [N].
  struct Outcome {
    double v0 = 0, v1 = 0, force = 0;  ///< [rad/s] or [m/s]; force [N·m] or [N]
  };

  /// Set-up: the joints of an articulation whose links, commands, q and v begin at these indices.
  void add(const Articulation& articulation, int link = 0, int command = 0, int q = 0, int v = 0);
  bool empty() const { return laws_.empty() && damped_.empty(); }  ///< no joint does anything by itself
  const std::vector<Law>& laws() const { return laws_; }           ///< joints of one degree
  const std::vector<Damped>& damped() const { return damped_; }    ///< degrees of joints of several

  /// (in realtime) The graphs over a step h from q.
  void start(const JointCommand* commands, const double* q, double h) noexcept;
  void standAt(const double* v) noexcept;       ///< (in realtime) begins on the pieces around v
  void putWithinLimits(double* v) const noexcept;  ///< (in realtime)

  /// How the search ended: all joints on their pieces, the bound on passes reached, or a solve that failed.
  enum class Found : unsigned char { kAll, kCycled, kUnsolved };
  /// (in realtime) Moves the joints over their pieces until all are where they come out. `solve(pass)` solves with the
  /// pieces as they are (false: it cannot), `outcome(k)` says how the joint of law k came out of it.
  template <class Solve, class OutcomeOf>
  Found search(Solve&& solve, OutcomeOf&& outcome) noexcept {
    const int most = kBlockPasses + kSinglePasses * static_cast<int>(laws_.size());
    for (int pass = 0;; ++pass) {
      if (!solve(pass)) return Found::kUnsolved;
      if (!move(pass < kBlockPasses, outcome)) return Found::kAll;
      if (pass == most) return Found::kCycled;
    }
  }

  /// (in realtime) v of joints on a vertical piece, to the last bit: rounding in v + Δv would move a joint that sticks.
  void settle(double* v) const noexcept;

  /// (in realtime) Adds the work over a time `share` of the step at the mean velocity, which with a constant force is
  /// exactly the change of kinetic energy; `drive_force[law.link]` becomes the drive's force. `v0`, `v1`: by degree.
  template <class OutcomeOf>
  void account(const JointCommand* commands, double share, OutcomeOf&& outcome, const double* v0, const double* v1,
               double* drive_force, JointWork& sum) const noexcept {
    for (std::size_t k = 0; k < laws_.size(); ++k) {
      const Law& law = laws_[k];
      const Outcome o = outcome(k);
      const double way = 0.5 * share * (o.v0 + o.v1);
      const double drive = driveForce(law.joint, commands[law.command], law.q_start, h_, o.v1);
      drive_force[law.link] = drive;
      sum.damping += law.joint.damping * o.v1 * way;
      sum.drives += drive * way;
      sum.friction -= (o.force - drive + law.joint.damping * o.v1) * way;
    }
    for (const Damped& d : damped_) sum.damping += d.damping * v1[d.v] * 0.5 * share * (v0[d.v] + v1[d.v]);
  }

 private:
  /// Moves joints that left their piece to the next one: all of them, or the last. False: all are where they belong.
  template <class OutcomeOf>
  bool move(bool all, OutcomeOf&& outcome) noexcept {
    bool moved = false;
    for (int k = static_cast<int>(laws_.size()) - 1; k >= 0 && (all || !moved); --k) {
      Law& law = laws_[k];
      const Outcome o = outcome(k);
      moved |= law.graph.follow(o.v1, o.force, law.piece);
    }
    return moved;
  }

  std::vector<Law> laws_;
  std::vector<Damped> damped_;
  double h_ = 0;
};

}  // namespace haptic
