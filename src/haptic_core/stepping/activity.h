/// Which islands a step visits. One at rest (rest.h), or one that waits for its turn (own_rate.h), is left out from the end of the step
/// that found it so until something that moves comes near, a hand pulls at it, its turn comes, or a caller changes the world.
///
/// Its trees, shapes and boxes leave the lists that a step visits (world/visits.h), its pairs go from one list of the state to the other
/// (world/pair_store.h), and its boxes into a tree, against which the boxes of moving bodies are tested. So the cost of a step follows
/// what moves, and the logarithm of what rests. To leave an island out and to wake it costs as much as its pairs, and a look at each pair
/// of the list that it leaves.
///
/// All of this follows from steps that were taken; none is state: save, restore, hash and replay know nothing of it, and an island that
/// is visited although it rests is found as it was, bit for bit. It wakes without a jump of any wrench, for the step that wakes it starts
/// from the velocities and forces of those that were left out.
#pragma once
#include <vector>

#include "haptic_core/geometry/search/box_slots.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/visits.h"

namespace haptic {
struct CarryOver;
struct Work;
}  // namespace haptic

namespace haptic::stepping {

/// Memory of what rests and waits.
class Activity {
 public:
  explicit Activity(const Model& model);  ///< set-up: room for all

  int trees() const { return trees_; }           ///< that are left out
  int waiting() const { return waiting_; }       ///< trees that wait for a turn
  bool idle() const { return idle_; }            ///< nothing would change, until somebody changes something
  unsigned changes() const { return changes_; }  ///< counts up where the lists of a step become others

  /// (in realtime) The island stands, or waits where its turn is set: no step visits it after this one.
  void leave(const Island& island, const State& state, Visits& visits) noexcept;
  /// (in realtime) At the end of a step: those islands leave, unless the world has stopped; the report counts all that were left out.
  void close(const Model& model, State& state, Work& work, StepReport& report) noexcept;

  /// (in realtime) Before pairs are looked for, after the boxes of what moves are placed: wakes what they touch, and places it, as of a
  /// step of length h [s].
  void wakeNear(const Model& model, double h, State& state, Work& work) noexcept;
  /// (in realtime) At the start of a step: wakes what hands with a target pull at, and the islands whose turn has come.
  void wakeForStep(const Model& model, State& state, Work& work) noexcept;
  /// (in realtime) Wakes all that rests and waits; `waiting_only`: all that waits.
  void wakeAll(const Model& model, bool waiting_only, State& state, Work& work) noexcept;
  /// (in realtime) A hand has a target: the next step is taken.
  void stir() noexcept { idle_ = false; }

  /// (in realtime) Of a world whose bodies become others, which all move yet: what rested there rests here, but for islands that lost a
  /// body or a contact.
  void carryOver(const Activity& from, const CarryOver& map, const Work& old_work, const Model& model, State& state,
                 Work& work) noexcept;

 private:
  /// An island that leaves at the end of the step: its trees in `leaving_trees_`.
  struct Leaving {
    int first, count;
  };
  void lay(const Model& model, const Leaving& island, const State& state, Work& work) noexcept;
  void mark(int tree) noexcept;
  void wakeMarked(const Model& model, State& state, Work& work) noexcept;
  void changed(const Model& model, const State& state, Work& work) noexcept;

  bool on_ = false;                            ///< islands are left out in this world
  std::vector<int> first_shape_, first_slot_;  ///< by tree, with the end of the last
  std::vector<int> island_, next_;             ///< by tree that is left out: the lowest tree of its island; the next one, −1: none
  std::vector<char> wakes_;                    ///< by lowest tree
  std::vector<int> islands_;                   ///< that are left out, by their lowest tree
  std::vector<Leaving> leaving_;
  std::vector<int> leaving_trees_;
  std::vector<int> woken_, merged_;            ///< scratch: trees; things of theirs
  BoxSlots boxes_;                             ///< of the model's moving shapes that are left out
  int trees_ = 0, waiting_ = 0, marked_ = 0;   ///< trees that are left out, that wait; islands that are to wake
  unsigned changes_ = 0, flags_ = 0;           ///< flags: that these give the report of a step
  bool idle_ = false;
};

/// (in realtime) Places the shapes that are visited, and finds the pairs whose boxes overlap: of a step of length h [s], see
/// `placeShapes`. What rests and comes near wakes before.
void lookForPairs(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept;

}  // namespace haptic::stepping
