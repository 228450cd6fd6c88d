/// The implicit step of an island: stable for any stiffness, damping, mass ratio and step, friction inside the solve.
///
///   implicit Euler  one stage (implicit_stage.h) of length h.
///   SDIRK2          two stages, g = γ h, γ = 1 - 1/√2 (Alexander 1977: second order, L-stable, stiffly accurate):
///                   v_b = v0 + (1-γ) h a1, q_b = q0 ⊕ (1-γ) h v1, s_b = s0 + (1-γ)/γ (s1 - s0); of what sticks poses say
///                   how far s went, and only what yielded is drawn out.
/// SDIRK2 multiplies the impulses of impacts by up to 2.4, so where the contact set changes, a patch grows or shrinks
/// fast, or the acceleration jumps, the step is done as implicit Euler, and where that happens again and again, so are the next.
///
/// Friction. Within a solve a patch keeps its limit, which makes its force continuous: μ0 while stuck, μ while sliding.
/// Implicit Euler changes the limit from one step to the next. SDIRK2 locates the instant in islands of few contacts with
/// μ0 > μ (elsewhere it does as Euler): where a stuck patch would
/// have to hold more than μ0 N, or the slip of a sliding one comes to a stop, the step is solved again up to there
/// (regula falsi on its length), the patch changes its mode, and the rest of the step follows.
///
/// Bounds. At most ten evaluations of the exact geometry (with events: 24 solves of two stages for each of at most seven) and
/// four factorisations for each pass. A step that has not converged by then is reported with the wrench that it leaves out
/// of balance; as implicit Euler it then has no more energy than it started with. A fold hidden in an accepted step
/// escapes that (seen at 1e12 N/m³).
#pragma once
#include <vector>

#include "haptic_core/stepping/implicit_stage.h"

namespace haptic {

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
  bool stands = false;     ///< it was at rest and stayed: q, v and the pairs are bit for bit what they were
  int parts = 0;           ///< solved one after the other: 1; more where friction changed inside, or after halving
};

/// Implicit Euler and SDIRK2 steps of a world's islands, one island after another.
class ImplicitStep {
 public:
  explicit ImplicitStep(const Model& model);  ///< set-up: room for the largest island

  /// (in realtime) Once before the islands of a step; see ImplicitStage::begin.
  void begin(State& state, const HandWork& hands, double h) noexcept;

  /// (in realtime) Advances q, v and friction of an island by h [s], and the ledger's sums in the state.
  const ImplicitReport& advance(const Island& island, double h, bool second_order) noexcept;

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
  void euler(double h, int passes) noexcept;
  bool solveSmooth(double g, double left) noexcept;
  double secondOrder(double h) noexcept;
  bool sdirk2(double h, double left) noexcept;
  double locate(double h) noexcept;
  double violationAtStart() const noexcept;
  double violation() const noexcept;
  double violation(const ImplicitContact& contact) const noexcept;
  void changeModes(double least, double elapsed) noexcept;
  void setBase() noexcept;
  bool sameContacts() const noexcept;
  bool staysAtRest(double h) const noexcept;
  void stand(double h) noexcept;
  void pushHands(double h, double first) noexcept;
  void gatherDone() noexcept;
  void commit(double g, double h, bool two_stages) noexcept;

  const Model& model_;
  const WorldSettings& settings_;
  State* state_ = nullptr;
  ImplicitStage stage_;
  ImplicitReport report_;
  bool locates_ = false;                   ///< instants of friction inside the step
  double length_ = 0, elapsed_ = 0;  ///< of the step, and what of it is done [s]
  std::vector<double> event_, violation_;  ///< by pair
  std::vector<double> acceleration_, change_;
  std::vector<double> coupling_work_, first_power_;  ///< by pointer
  double first_hands_power_ = 0;  ///< of the first stage [W]
  /// By pair, about W's origin: impulse of the step so far; wrench of the first stage, and of the last.
  std::vector<Wrench> impulse_, first_, done_;
  std::vector<Pose> place_;                          ///< by pair: X_WP of the patch that pressed last
  std::vector<PairCache> cache_;                     ///< by pair: before the step
  std::vector<Wrench> coupling_impulse_, first_coupling_;  ///< by pointer, likewise, about the link's origin
};

}  // namespace haptic
