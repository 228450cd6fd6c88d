/// The implicit step of an island: stable for any stiffness, damping, mass ratio and step, friction inside the solve.
///
///   implicit Euler  one stage (implicit_stage.h) of length h.
///   SDIRK2          two stages, g = γ h, γ = 1 - 1/√2 (Alexander 1977: second order, L-stable, stiffly accurate):
///                   v_b = v0 + (1-γ) h a1, q_b = q0 ⊕ (1-γ) h v1, s_b = s0 + (1-γ)/γ (s1 - s0); of what sticks poses say
///                   how far s went, and only what yielded is drawn out.
///   BDF2            one stage, g = h (1 + w)/(1 + 2 w) with w = h over the last step (Hairer, Nørsett, Wanner, Solving ODEs I, III.5:
///                   second order, stable for w ≤ 1 + √2 in any sequence): v_b = v0 + (h - g) ā, q_b = q0 ⊕ (h - g) v̄, with the means
///                   of the last step, which the state keeps. It halves the solves of what goes on smoothly. The first step after an
///                   event (a contact begins or ends, friction changes its mode, a hand lets go, an explicit step) has none to go on
///                   from.
/// An attempt at second order counts when its error of position is at most `WorldSettings::accuracy` of the way that the change of
/// speed and gravity move a body in the step; BDF2's is 2/9 h² |a1 - a0|, a0 at the end of the last step, SDIRK2's .04 h² of the change
/// between its stages. One that does not is tried again by halves, down to h/8, while the error falls and the budget lasts; then it
/// counts none the less where implicit Euler, by s/2 |Δv|, would err by more. Second
/// order multiplies the impulses of impacts by up to 2.4, so where the contact set changes or a patch grows or shrinks fast, and
/// where all attempts fail, the rest of the step is done as implicit Euler. After such a step Euler comes first, and gives way where
/// its first evaluation finds the contacts of the start: in a heap they mostly go on to change. BDF2 goes on from steps that were smooth.
///
/// Friction. Within a solve a patch keeps its limit, which makes its force continuous: μ0 while stuck, μ while sliding.
/// Implicit Euler changes the limit from one step to the next. Second order locates the instant in islands of few contacts with
/// μ0 > μ (elsewhere it does as Euler): where a stuck patch would
/// have to hold more than μ0 N, or the slip of a sliding one comes to a stop, the step is solved again up to there by SDIRK2
/// (regula falsi on its length), the patch changes its mode, and the rest of the step follows.
///
/// Bounds. The budget of an island in a step is 128 evaluations of the exact geometry of a pair over the pairs that touch, but 10 at
/// least and 64 at most, shared by all attempts and instants of friction, and four factorisations for each pass. A step that has not
/// converged by then is reported with the wrench that it leaves out of balance; as implicit Euler it then has no more energy than it
/// started with. A fold hidden in an accepted step escapes that (seen at 1e12 N/m³).
#pragma once
#include <vector>

#include "haptic_core/stepping/implicit_stage.h"

namespace haptic {

/// Which implicit schemes an island may take.
enum class ImplicitOrder : unsigned char {
  kFirst,           ///< implicit Euler
  kSecond,          ///< SDIRK2 where it is smooth
  kSecondMultistep  ///< BDF2 in its place where the last step was smooth as well: half the solves
};

/// Work and convergence of the implicit step of one island.
struct ImplicitReport {
  int iterations = 0;      ///< Newton steps, line searches not counted
  int evaluations = 0;     ///< of the exact geometry
  int factorisations = 0;  ///< matrices
  double residual = 0;     ///< speed that is left to change [m/s]
  double wrench_error = 0; ///< wrench that this leaves out of balance [N], moments over the body's size
  bool converged = true;   ///< the tolerance was reached in every part
  bool joints_converged = true;  ///< every joint's force is on its graph, likewise
  bool fell_back = false;  ///< SDIRK2 was replaced by implicit Euler in a part of this step
  bool rests = false;      ///< it was at rest and stays: q and the pairs keep their bits, v is 0
  bool stands = false;     ///< so it is, and v was 0
  double position_error = 0;  ///< that the accepted attempts foresee of themselves, summed over them [m]
  double budget_used = 0;  ///< evaluations over those it may take
  int parts = 0;           ///< solved one after the other: 1; more where friction changed inside, or after halving
};

/// Implicit Euler and SDIRK2 steps of a world's islands, one island after another.
class ImplicitStep {
 public:
  explicit ImplicitStep(const Model& model);  ///< set-up: room for the largest island

  /// (in realtime) Once before the islands of a step; see ImplicitStage::begin.
  void begin(State& state, const std::vector<int>& trees, const HandWork& hands, Seams& seams, double h) noexcept;

  /// (in realtime) Advances q, v and friction of an island by h [s], and the ledger's sums in the state.
  const ImplicitReport& advance(const Island& island, double h, ImplicitOrder order) noexcept;

  /// By pointer; the caller sets their targets before `advance`.
  std::vector<ImplicitCoupling>& couplings() { return stage_.couplings; }
  /// Mean wrench of a contact of the last island over its step, on B at X_WP.p, in W's axes: its impulse over h.
  Wrench meanWrench(const ImplicitContact& contact) const noexcept {
    return (impulse_[contact.pair] * (1 / length_)).shifted(contact.X_WP.p);
  }
  /// (in realtime) Visits (pair, X_WP, mean wrench as above) of the pairs of the last island that pressed and touch no more.
  template <class Visit>
  void eachParted(Visit&& visit) const noexcept {
    const Island& island = stage_.island();
    int next = 0;
    for (int i = 0; i < island.pair_count; ++i) {
      const int pair = island.pairs[i];
      if (next < contacts().size() && contacts()[next].pair == pair) {
        ++next;
      } else if (!impulse_[pair].vector().isZero(0)) {
        visit(pair, place_[pair], (impulse_[pair] * (1 / length_)).shifted(place_[pair].p));
      }
    }
  }
  /// Mean wrench of a pointer's coupling on its link over the step, about the link's origin, in W's axes.
  Wrench meanCoupling(int pointer) const noexcept { return coupling_impulse_[pointer] * (1 / length_); }
  /// Work of a pointer's coupling on its link since `begin` [J].
  double couplingWork(int pointer) const { return coupling_work_[pointer]; }
  const ImplicitJoints& joints() const { return stage_.joints(); }  ///< of the last island
  /// Share of the step after which the friction of a pair last changed its mode in this step; 1: it did not.
  double event(int pair) const { return event_[pair]; }
  /// Of the last island, at the end of its step.
  const LoadedVector<ImplicitContact>& contacts() const { return stage_.contacts(); }

 private:
  /// Instants whose mean are the forces of a step.
  enum class Mean { kOfEnd, kOfEnds, kOfStages };
  enum class Smooth { kYes, kNo, kFrictionChanges };
  /// A solve of second order over `length` that the stage holds.
  struct Attempt {
    double g = 0, length = 0;  ///< of its last stage; of all; 0: there is none [s]
    Mean mean = Mean::kOfEnds;
    double error = 0, euler_error = 0;  ///< of position that it foresees, and that implicit Euler would [m]
  };
  double lastStep() const noexcept;
  bool euler(double h, int passes, bool if_jumps) noexcept;
  void goOn(double done) noexcept;
  void subSteps() noexcept;
  bool affords(double evaluations, double s) const noexcept;
  int used() const noexcept { return stage_.evaluations - evaluations_before_; }
  Smooth bdf2(double s, double last) noexcept;
  Attempt attemptOf(double g, double s, Mean mean) noexcept;
  void accelerations(double g) noexcept;
  double speedGained() noexcept;
  bool errs(double share, double s) noexcept;
  void remember(double g, double h, Mean mean, double taken_up) noexcept;
  void setModes() noexcept;
  bool solveSmooth(double g, double left) noexcept;
  double secondOrder(double s) noexcept;
  bool sdirk2(double h, double left) noexcept;
  bool keepSdirk2(double s) noexcept;
  double locate(double s) noexcept;
  double violationAtStart() const noexcept;
  double violation() const noexcept;
  double violation(const ImplicitContact& contact) const noexcept;
  void forget() noexcept;
  void changeModes(double least, double elapsed) noexcept;
  void setBase() noexcept;
  bool sameContacts() const noexcept;
  double restBound(double h) const noexcept;
  bool staysAtRest(double h) const noexcept;
  void stand(double h) noexcept;
  void pushHands(double h, double w, bool two_stages) noexcept;
  void gatherDone() noexcept;
  void commit(const Attempt& attempt) noexcept;
  void commit(double g, double h, Mean mean, double taken_up) noexcept;

  const Model& model_;
  const WorldSettings& settings_;
  State* state_ = nullptr;
  ImplicitStage stage_;
  ImplicitReport report_;
  bool locates_ = false;                   ///< instants of friction inside the step
  ImplicitOrder order_ = ImplicitOrder::kFirst;
  double length_ = 0, left_ = 0;           ///< of the step, and its rest that is not done yet [s]
  Attempt attempt_;                        ///< the last one of second order that was not taken
  double error_ = 0;                       ///< of the last attempt, over its tolerance
  double position_error_ = 0;              ///< of the last attempt [m]
  int budget_ = 0, evaluations_before_ = 0;
  std::vector<double> event_, violation_;  ///< by pair
  std::vector<double> acceleration_, change_, kick_;
  std::vector<double> coupling_work_, first_power_;  ///< by pointer
  double first_hands_power_ = 0;  ///< of the first stage [W]
  ForcePower first_force_power_, force_power_before_;  ///< of the first stage, and at the end of the last part
  /// By pair, about W's origin: impulse of the step so far; wrench of the first stage, and of the last.
  std::vector<Wrench> impulse_, first_, done_;
  std::vector<double> hands_power_;                  ///< by pair: of the last stage [W]
  std::vector<Pose> place_;                          ///< by pair: X_WP of the patch that pressed last
  std::vector<PairCache> cache_;                     ///< by pair: before the step
  std::vector<Wrench> coupling_impulse_, first_coupling_;  ///< by pointer, likewise, about the link's origin
};

}  // namespace haptic
