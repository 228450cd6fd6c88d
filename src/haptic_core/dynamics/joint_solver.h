/// What joints do by themselves (joint_law.h), rings and mimics, on top of any linear operator.
///
/// Over a time h velocities change by u with
///   A u = h (f₀ + f + Gᵀ μ),   f_i on the graph of joint i at v_i + u_i,   G u = −(φ/h + G v),
/// A and f₀ the operator's: the inertia of one articulation (tree_motion.h), or that of an island with its contacts
/// (stepping/implicit_joints.h); φ the gaps of rings and mimics, φ' = G v.
///
/// Every joint stands on one piece of its graph. A straight piece adds h·slope to the diagonal and its offset to the forces, a
/// vertical one (stuck, at a limit) prescribes u_i, and the force it takes is read off. Then S = G A⁻¹ Gᵀ gives μ
/// (damped_cholesky.h: of redundant rows, as in a planar ring, the least forces). Joints that come out beyond their piece move to the
/// neighbouring one and the solve is repeated: block pivoting, which ends at the unique solution in one to three passes as a
/// rule; when it does not (a cycle), only the last such joint moves (Murty's rule, which cannot cycle on a positive definite
/// operator). A joint that sticks does so to the last bit; a limit ends the step on the limit; a drive is as stiff as its
/// gains say and stable for all of them.
///
/// A thread (thread.h) rubs in proportion to the axial force that its mimic's row takes, which a pass finds. Where the turn sticks that
/// force settles what friction can bear; where it moves, force and friction are linear in each other, so that two passes give both.
///
/// Cost: one factorisation and one solve per pass; with rings one more solve, and a response per row.
#pragma once
#include <vector>

#include "haptic_core/dynamics/joint_law.h"
#include "haptic_core/dynamics/damped_cholesky.h"
#include "haptic_core/dynamics/ring.h"
#include "haptic_core/dynamics/thread.h"

namespace haptic {

/// A factored symmetric positive definite A. Vectors are ordered by its rows.
class JointResponse {
 public:
  /// (in realtime) x = (A + diag)⁻¹ force, 0 where u is prescribed.
  virtual void respond(const double* force, double* x) noexcept = 0;

 protected:
  ~JointResponse() = default;
};

/// A symmetric positive definite A with its own forces f₀.
class JointOperator : public JointResponse {
 public:
  /// (in realtime) Factors A + diag; `diag[i]` = infinity: u_i is prescribed. False: not positive definite.
  virtual bool factor(const double* diag) noexcept = 0;
  /// (in realtime) u with (A + diag) u = h (f₀ + force); prescribed u_i are given in `u`. [N·m] or [N], [rad/s] or [m/s].
  virtual void solve(const double* force, double* u) noexcept = 0;
  /// (in realtime) (A u)_row/h − f₀_row for the u of the last `solve`: what all other forces together have to be at the
  /// joint of `link` [N·m] or [N].
  virtual double required(int link, int row, const double* u) noexcept = 0;

 protected:
  ~JointOperator() = default;
};

/// Work in a step or a part of it [J].
struct JointWork {
  double damping = 0;   ///< dissipated by joint damping
  double friction = 0;  ///< dissipated by joint friction and limits
  double drives = 0;    ///< work of drives on the joints
};

/// Forces of a joint of one degree by its own law in a step [N·m] or [N].
struct JointForce {
  double drive = 0;  ///< of its drive
  double all = 0;    ///< of drive, spring, damping, friction and limits together
};

/// Where an articulation's links, commands, q and v begin in the caller's arrays.
struct JointPlace {
  int link = 0, command = 0, q = 0, v = 0;  ///< indices
};

/// Damping, springs, friction, limits, drives, rings and mimics of one or several articulations.
class JointSolver {
 public:
  /// Row of a degree that the operator does not have.
  static constexpr int kAbsent = -1;

  /// A joint of one degree. Indices are those of the caller's links, commands, q and v.
  struct Law {
    JointDef joint;                           ///< of a mimic's follower nothing but damping
    int link = 0, command = 0, q = 0, v = 0;  ///< the caller's indices
    int row = 0;                              ///< of the operator
    double q_start = 0;                       ///< at the start of the step [rad] or [m]
    JointFriction friction;                   ///< of its bearing and of the threads on it
    ForceGraph graph;                         ///< of this step
    int piece = 0;                            ///< index of the piece it stands on
    double force = 0;                         ///< in the last solve [N·m] or [N]

    const ForcePiece& now() const { return graph.pieces[piece]; }  ///< the piece it stands on
    /// Of the law at v₁: the graph's, on a vertical piece that of the last solve.
    double forceAt(double v1) const { return now().vertical ? force : now().offset - now().slope * v1; }
  };

  /// Set-up: one more articulation. It must outlive the solver. Throws SetupError as `Rings` does.
  void add(const Articulation& articulation, const std::vector<RingDef>& rings, const JointPlace& place = {});
  void reserveRows(int most);  ///< set-up, after the last `add`: room for operators of up to `most` rows
  bool empty() const { return laws_.empty() && damped_.empty() && gap_.empty(); }  ///< no joint does anything by itself
  bool hasRings() const { return !rings_.empty(); }  ///< or mimics
  bool hasThreads() const { return !threads_.empty(); }  ///< some friction follows a force

  /// (in realtime) The rows of the operator: how many, and `rowOf(v)` of the caller's velocity v, kAbsent where the
  /// operator does not have it. The rows of one articulation follow one another.
  template <class RowOf>
  void select(int rows, RowOf&& rowOf) noexcept {
    rows_ = rows;
    present_.clear(), present_damped_.clear(), present_rings_.clear();
    for (Law& law : laws_) {
      if ((law.row = rowOf(law.v)) != kAbsent) present_.push_back(&law - laws_.data());
    }
    for (Damped& d : damped_) {
      if ((d.row = rowOf(d.v)) != kAbsent) present_damped_.push_back(&d - damped_.data());
    }
    for (PlacedRings& r : rings_) {
      if ((r.row = rowOf(r.place.v)) != kAbsent) present_rings_.push_back(&r - rings_.data());
    }
    orderRings();
  }

  /// (in realtime) The graphs over a time h from q.
  void start(const JointCommand* commands, const double* q, double h) noexcept;
  void standAt(const double* v) noexcept;          ///< (in realtime) begins on the pieces around v
  void putWithinLimits(double* v) const noexcept;  ///< (in realtime)
  /// (in realtime) v of joints on a vertical piece, to the last bit: rounding in v + u would move a joint that sticks.
  void settle(double* v) const noexcept;
  void follow(double* q, double* v) const noexcept;  ///< (in realtime) followers of mimics to their leaders, by less than a gap

  /// (in realtime) Rings at these poses: of their gaps `share` is left to close. `v`: the velocities that u adds to, which
  /// move the gaps as well; null where the poses are those of the step's end.
  void lookAtRings(const LinkWork* work, const double* q, double share, const double* v) noexcept;

  /// How the search ended: all joints on their pieces, the bound on passes reached, or a factorisation that failed.
  enum class Found : unsigned char { kAll, kCycled, kUnsolved };
  /// (in realtime) The change u of velocities, by row; `v` by the caller's velocity.
  Found solve(JointOperator& A, const double* v, double* u) noexcept;
  /// (in realtime) After `solve`, for other forces f₀ of the operator: u of joints that stay on their pieces, on the factor it has.
  void solveAgain(JointOperator& A, const double* v, double* u) noexcept;
  int passes() const { return passes_; }  ///< of the last `solve`

  /// (in realtime) S of the rings' last poses on the factor that A has.
  void factorRings(JointResponse& A) noexcept;
  /// (in realtime) After `factorRings`: adds to v̇ the accelerations by the forces of rings, so that G v̇ + G' v = 0. `work` holds the
  /// links' accelerations at v̇. Of one articulation.
  void holdAccelerations(const LinkWork* work, double* v_dot) noexcept;
  /// (in realtime) G v of the poses and velocities of the last `lookAtRings` with a share of 0; the largest [m/s, rad/s].
  double openingRate() const noexcept;
  /// (in realtime) After `factorRings`: takes G v of the last `lookAtRings` from v, by the impulse of the rings alone. Of one
  /// articulation.
  void holdVelocities(double* v) noexcept;
  /// (in realtime) The gaps of rings and mimics at these poses [m, rad]; the largest.
  double gapAt(const LinkWork* work, const double* q) noexcept;
  /// (in realtime) The shortest way that closes the gaps of the last `gapAt`, in the inertia of the last `factorRings`, by
  /// row.
  void closingWay(double* way) noexcept;
  double closure(const LinkWork* work) const noexcept;  ///< largest distance in a ring, absent ones included [m]

  /// (in realtime) −h (f + Gᵀ μ)·u at a velocity on the way from v to v + u, all by the caller's velocity.
  double slope(const double* v, const double* u) const noexcept;
  /// (in realtime) Whether no joint hit a limit, stuck or came loose in a step that began with v0.
  bool isSmooth(const double* v0) const noexcept;
  /// (in realtime) Adds the work over a time `share` of the step at the mean of `v0` and `v1`, which with a constant force is
  /// exactly the change of kinetic energy; `forces[law.link]` becomes the joint's force.
  /// `q0`: at v0, where drives and dampers work by the mean of their forces at both ends; null: by that of the end.
  void account(const JointCommand* commands, double share, const double* q0, const double* v0, const double* v1, JointForce* forces,
               JointWork& sum) const noexcept;

 private:
  /// A degree of a joint of several; of these damping alone is simulated.
  struct Damped {
    int v = 0, row = 0;
    double damping = 0;  ///< [N·m·s/rad] or [N·s/m]
  };
  /// Rings and mimics of one articulation.
  struct PlacedRings {
    Rings rings;
    JointPlace place;
    int nv;
    int row = 0;        ///< first of the articulation's rows in the operator
    int first = 0;      ///< of its equations
    std::size_t G = 0;  ///< where its Jacobian begins: equations × nv
  };
  /// A thread with friction.
  struct PlacedThread {
    Thread thread;
    std::size_t law, rings;       ///< of the turn; of its articulation
    int equation;                 ///< of these rings
    JointFriction friction = {};  ///< in the next pass
    int side = 0;                 ///< of the motion that the next two belong to: 1 forward, −1 backward; 0: there are none
    double force = 0, rubbed = 0; ///< axial force that an earlier pass found, with which friction [N], [N·m]
  };
  using Indices = std::vector<std::ptrdiff_t>;
  /// Calls `visit(equation, row of G, rings)` for every present equation.
  template <class Visit>
  void forEachEquation(Visit&& visit) const noexcept {
    for (const std::ptrdiff_t i : present_rings_) {
      const PlacedRings& r = rings_[i];
      for (int k = 0; k < r.rings.rows(); ++k) visit(r.first + k, G_.data() + r.G + k * r.nv, r);
    }
  }
  void addThreads(const Articulation& articulation, const PlacedRings& placed);
  void orderRings() noexcept;
  void hold(const double* v, double* u) noexcept;
  void closeRings(JointOperator& A, double* u) noexcept;
  void addResponse(const double* force, double* x) const noexcept;  ///< x += A⁻¹ Gᵀ force
  void readForces(JointOperator& A, const double* v, const double* u) noexcept;
  void buildGraph(Law& law) const noexcept;
  /// Friction of threads: as it was in the pass, to be tried in the next one, or larger than any that lets a joint slide on.
  enum class Rubbed : unsigned char { kFound, kNext, kJams };
  Rubbed rub() noexcept;
  bool move(bool all, const double* v, const double* u) noexcept;

  std::vector<Law> laws_;
  std::vector<Damped> damped_;
  std::vector<PlacedRings> rings_;
  std::vector<PlacedThread> threads_;
  Indices present_, present_damped_, present_rings_;  ///< in the operator
  int rows_ = 0, equations_ = 0, passes_ = 0;
  double h_ = 1;
  const JointCommand* commands_ = nullptr;
  // By row.
  std::vector<double> force_, ring_force_, diag_;
  // By equation of rings and mimics.
  std::vector<double> gap_, rate_, mu_, G_, Y_;
  DampedCholesky S_;
};

}  // namespace haptic
