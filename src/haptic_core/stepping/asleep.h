/// Islands that sleep: they stand (standing_islands.h), or wait for their turn (own_rate.h), and no stage of a step visits them until
/// something that moves comes near.
///
/// An island whose step was left out is laid aside: its trees, shapes and boxes leave the lists that a step visits
/// (world/visits.h), its pairs and reported contacts are kept here, its boxes in a tree, against which the boxes of awake
/// islands are tested. So the cost of a step follows the awake islands, and the logarithm of the sleeping ones. To lay an island aside and
/// to take it back costs as much as its pairs and the awake islands.
///
/// This is bookkeeping alone: an island that is taken back stands as if it had never been laid aside, so it may be taken back at any
/// time, and is when boxes touch, a hand has a target, or a caller takes the whole state. A step
/// computes the same, bit for bit. Worlds of few pairs, which are tested one by one, lay nothing aside, nor do those with sensors.
#pragma once
#include <cstdint>
#include <vector>

#include "haptic_core/geometry/search/box_slots.h"
#include "haptic_core/geometry/volume/loaded_vector.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/visits.h"

namespace haptic {
struct Work;
}

namespace haptic::stepping {

/// Memory of the sleeping islands.
class Asleep {
 public:
  explicit Asleep(const Model& model);  ///< set-up: room for all

  bool holds(int tree) const { return sleeper_[static_cast<std::size_t>(tree)].island >= 0; }  ///< the tree's island sleeps
  int islands() const { return static_cast<int>(islands_.size()); }  ///< that sleep
  int trees() const { return trees_; }                               ///< in them
  int waiting() const { return waiting_; }                           ///< of these, that wait for a turn (own_rate.h)
  int pairs() const { return pair_count_; }                          ///< of them
  const LoadedVector<ContactReport>& contacts() const { return contacts_; }  ///< of them, as last reported
  unsigned flags() const { return flags_; }  ///< that these give the report of a step
  /// (in realtime) visit(shape) for those that sleep and whose box overlaps `box`.
  template <class Visit>
  void eachOverlap(const Model& model, const ConvexShape::Box& box, Visit&& visit) const noexcept {
    if (!islands_.empty()) boxes_.eachOverlap(box, [&](int slot) { visit(model.moving_shapes[static_cast<std::size_t>(slot)]); });
  }
  /// (in realtime) State::hash of the whole state, of which this has the pairs of what sleeps.
  std::uint64_t hash(const State& state) noexcept;
  unsigned changes() const { return changes_; }  ///< counts up when an island is laid aside or taken back

  /// (in realtime) The island's step was left out, or it waits: it may be laid aside at the end of the step.
  void note(const Island& island) noexcept;
  /// (in realtime) At the end of a step: lays the noted islands aside, unless the world has stopped; the report counts all that sleep.
  void close(const Model& model, State& state, Work& work, Report& report) noexcept;

  /// (in realtime) Before pairs are looked for, after the awake boxes are placed: takes back islands that they touch, and places
  /// theirs, widened for a step of length h [s].
  void wakeNear(const Model& model, double h, State& state, Work& work) noexcept;
  /// (in realtime) At the start of a step: takes back what hands with a target pull at.
  void wakeActed(const Model& model, State& state, Work& work) noexcept;
  /// (in realtime) At the start of a step: takes back the islands that have their turn.
  void wakeDue(const Model& model, State& state, Work& work) noexcept;
  /// (in realtime) Takes all back. `report`: between two steps the last one's; null within a step.
  void wakeAll(const Model& model, State& state, Work& work, Report* report) noexcept;

  bool on = false;  ///< islands are laid aside in this world

 private:
  /// Of a tree: the island that it sleeps in, by its lowest tree, and the next tree of that; −1: none.
  struct Sleeper {
    int island = -1, next = -1;
  };
  /// By its lowest tree.
  struct SleepingIsland {
    int trees = 0, pairs = 0, first_pair = -1;
    int first_contact = 0, contacts = 0;
    bool wakes = false, waits = false;
  };
  void fall(const Model& model, State& state, Work& work, Report& report) noexcept;
  void placeWaiting(const Model& model, int tree, const State& state, Work& work) noexcept;
  void leaveReport(Work& work, LoadedVector<ContactReport>& contacts) noexcept;
  void mark(int tree) noexcept;
  void wakeMarked(const Model& model, State& state, Work& work, LoadedVector<ContactReport>& contacts, bool within) noexcept;
  void takePairs(State& state) noexcept;
  void takeContacts(Work& work, LoadedVector<ContactReport>& contacts, bool within) noexcept;
  void visit(const Model& model, Work& work) noexcept;

  std::vector<int> first_shape_, first_slot_;  ///< by tree, with the end of the last
  std::vector<Sleeper> sleeper_;                              ///< by tree
  std::vector<SleepingIsland> island_;                        ///< by tree
  std::vector<int> islands_;                                  ///< that sleep, in the order of their contacts
  std::vector<int> tired_;                                    ///< noted: trees of each island, its size in front
  std::vector<int> woken_, merged_;                           ///< trees, slots of pairs: scratch
  std::vector<int> order_;                                    ///< slots of all their pairs by key, of `order_changes_`
  BoxSlots boxes_;                                            ///< of the model's moving shapes that sleep
  std::vector<ActivePair> pair_;                              ///< slots of their pairs
  std::vector<int> next_pair_;                                ///< by slot: of the same island, or the next free one
  int free_pair_ = -1, pair_count_ = 0, trees_ = 0, waiting_ = 0, marked_ = 0;
  unsigned changes_ = 0, order_changes_ = ~0u, flags_ = 0;
  LoadedVector<ContactReport> contacts_;
};

/// (in realtime) Places the shapes that are visited, and finds the pairs whose boxes overlap: of a step of length h [s], see
/// `placeShapes`. What sleeps and comes near wakes before.
void lookForPairs(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept;

}  // namespace haptic::stepping
