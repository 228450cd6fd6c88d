/// The contacts of a stage: which patches stand in its problem, where each was frozen, and when it is looked at again.
///
/// A pair that touches has a patch. After a pass it keeps it while the error of the frozen geometry is small
/// (`staysValid`), else it is evaluated again. Beside the patches stand those of near pairs: a gap that may close within
/// the next pass, and a contact of an earlier pass that this one no longer finds, as far as it may still touch. Bodies that
/// bounce between two passes would never settle.
#pragma once
#include <vector>

#include "haptic_core/contact/located_force.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "haptic_core/stepping/frozen_problem.h"
#include "haptic_core/stepping/held_links.h"
#include "haptic_core/world/contact_evaluation.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/seams.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// A contact as the last evaluation found it, carried to the velocity that the stage ended with.
struct ImplicitContact {
  int pair = 0;  ///< index in State::pairs
  int shape_a = 0, shape_b = 0;  ///< the model's indices
  Pose X_WP;                     ///< of the patch, at the stage's end
  ContactVolume volume;          ///< at the reference
  LocatedForce force;            ///< at the stage's end
  Wrench done_P;         ///< wrench by which the stage moved the bodies, on B at P, in P's axes: `force` up to the solve's tolerance
  double elastic = 0;    ///< ½ k ∫d² dA [J]
  Twist V_P;             ///< of B relative to A at the stage's end, as if hands and belts stood still
  Twist V_led_P;         ///< of B relative to A, by hands and belts alone: mean over the step
  bool touching = true;  ///< within a solve: still overlaps
};

/// Impulse of a patch within a solve at whose end it does not touch: near, parted, or elsewhere on its pair.
struct Brush {
  int pair = 0;   ///< index in State::pairs
  Pose X_WP;      ///< of the patch
  Wrench done_P;  ///< on B at P, in P's axes
  Twist V_led_P;  ///< as in ImplicitContact
};

/// Error that the passes of a stage may leave, as a speed [m/s] and as an energy [J].
struct StageTolerance {
  double speed = 0, energy = 0;  ///< [m/s], [J]
};

/// Share of the tolerance that a frozen patch may be wrong by, or a body may move, without another evaluation.
constexpr double kStays = 0.5;

/// The contacts of one island during one implicit stage.
class StageContacts {
 public:
  /// `problem.contacts` is filled by this, in step with `all()`.
  StageContacts(const Model& model, FrozenProblem& problem);

  /// (in realtime) The step's pairs, the links and shapes as the stage places them, and the world's seams, of which a stage needs
  /// nothing that was there before; all stay the caller's.
  void begin(State& state, const ContactPlaces& places, Seams& seams) noexcept {
    state_ = &state, places_ = places, seams_ = &seams;
  }
  /// (in realtime) The pairs that may touch in the next stages.
  void select(const Island& island) noexcept;
  /// (in realtime) No patch is known. `memory`, `yielding`: by pair, at the base of a stage of length g [s].
  void clear(const FrictionMemory* memory, const Yielding* yielding, double g, double run, double since) noexcept;

  /// (in realtime) Looks at the pairs of the trees that `moved`. `tolerance`: of the last pass, whose largest change of speed
  /// was `changed` [m/s]; 0: there was none. Returns the looks that it took [units].
  double evaluate(const std::vector<char>& moved, const StageTolerance& tolerance, double changed) noexcept;
  /// (in realtime) Whether another evaluation after a change of the velocity by u would find what this one predicts: all
  /// patches stay valid and no gap closes.
  bool hold(const StageTolerance& tolerance, const double* u) const noexcept;
  /// (in realtime) Carries the contacts to a velocity that differs by u from the reference, and leaves those that touch, in
  /// the order of their pairs.
  void finish(const double* u, const stepping::HeldLinks& held) noexcept;

  /// In step with the problem's contacts.
  const LoadedVector<ImplicitContact>& all() const { return contacts_; }
  const LoadedVector<Brush>& brushes() const { return brushes_; }  ///< found by `finish`
  double springEnergy() const noexcept;        ///< of those that touch [J]
  /// (in realtime) Of what hands that lead a link, and belts, do to contacts as they stand at the reference [W]; as in `finish`.
  double supply(const stepping::HeldLinks& held) const noexcept;
  bool touches(int pair) const { return slot_[pair] >= 0 && contacts_[slot_[pair]].touching; }  ///< so found last

 private:
  void evaluatePair(int pair) noexcept;
  bool staysValid(int slot, const StageTolerance& tolerance) const noexcept;
  FrozenContact* nearContact(int pair) noexcept;
  void placeNear(int pair, FrozenContact& contact, const Pose& X_WP) const noexcept;
  Twist beltOf(int pair, const Pose& X_WP) const noexcept;
  bool isLed(const FrozenContact& contact) const noexcept;  ///< by a hand or a belt
  Twist ofHands(int pair, const FrozenContact& contact, const stepping::HeldLinks& held) const noexcept;
  Twist ofHandsAsPlaced(int pair, const FrozenContact& contact) const noexcept;
  template <class TwistOf>
  Twist between(int pair, const FrozenContact& contact, TwistOf&& twistOf) const noexcept;
  PairLaw lawOf(const ActivePair& pair) const noexcept;
  bool lookAtFaces(int pair, const Pose& X_AB, const Vector3& n) noexcept;
  void lookAhead(int pair, const Pose& X_AB, const Vector3& n) noexcept;
  int addSlot() noexcept;
  int addAside() noexcept;
  void keepAside(int pair, const FrozenContact& contact) noexcept;
  void leave(int slot) noexcept;
  void part(int slot) noexcept;
  void order() noexcept;
  int treeOf(int shape) const { return model_.links[model_.shapes[shape].link].articulation; }

  const Model& model_;
  const WorldSettings& settings_;
  FrozenProblem& problem_;
  State* state_ = nullptr;
  ContactPlaces places_;
  Seams* seams_ = nullptr;
  Island island_;
  const FrictionMemory* memory_ = nullptr;
  const Yielding* yielding_ = nullptr;
  double g_ = 0;                     ///< length of the stage [s]
  double run_ = 0;                   ///< how long belts have run since `memory_` [s]
  double since_ = 0;                 ///< Advance::since
  double reach_ = 0;                 ///< gap that may close within the pass: way of the last one [m]
  int aside_ = 0;                    ///< patches that are no pair's own
  FrozenContact before_;             ///< within `evaluatePair`: the contact of the pass before
  LoadedVector<ImplicitContact> contacts_;  ///< parallel to the problem's
  LoadedVector<Brush> brushes_;
  std::vector<int> slot_, near_;     ///< by pair: index in contacts_ of its patch, and of its near contact; or -1
  std::vector<double> gap_;          ///< by pair that does not touch: proven at its last evaluation [m]
  ContactWorkspace workspace_;
};

}  // namespace haptic
