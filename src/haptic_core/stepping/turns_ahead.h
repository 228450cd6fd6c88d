/// Turns of far islands (turns.h) that a second thread solves before their steps come.
///
/// All that a turn depends on is known when its island begins to wait: then `give` hands it over, and at the turn's step `take` has the
/// result, if the thread has come to it and the island has come to its turn with the same numbers, bit for bit. Else the step
/// solves the turn itself, and finds the same. So states, reports and hashes do not depend on the thread, or on whether there is one.
///
/// The thread has a model, a state and scratch of its own, and copies an island's numbers in and out. Neither side waits for the other in
/// a step: a turn goes from hand to hand by one atomic word, and the thread looks for the next one every kLookEvery.
#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "haptic_core/geometry/volume/loaded_vector.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"

namespace haptic {
struct Work;
}

namespace haptic::stepping {

/// One turn: an island as it begins to wait, and as it is after its turn.
struct Turn {
  /// Whose it is: the step's until it is given, and again once it is solved, taken back or left.
  enum class Stage { kFree, kGiven, kSolving, kLeft, kSolved };
  std::atomic<Stage> stage{Stage::kFree};  ///< the word by which it goes from hand to hand
  std::atomic<std::uint64_t> due{0};    ///< step at whose start the turn is
  std::uint64_t as_of = 0;              ///< steps after which the island is as in `before`
  std::vector<int> trees;               ///< of the island
  int pairs = 0;                        ///< of the island
  std::vector<double> before, after;    ///< numbers of trees and pairs, in that order
  LoadedVector<ContactReport> contacts; ///< after it, where the island waits again
  StepReport report;                    ///< of the solve alone
  EnergySums energy;                    ///< of the solve alone
  double units = 0;                     ///< counted work
  double position_error = 0;            ///< of the solve [m]
  bool waits = false;                   ///< the island may wait again

  /// (in realtime) The island's numbers after the turn go into the state.
  void putInto(const Model& model, const Island& island, State& state) const noexcept;
};

/// The second thread, and the turns that it has been given.
class TurnsAhead {
 public:
  /// Set-up, beside a state between two steps: copies the model, and starts the thread.
  TurnsAhead(const Model& model, const State& state);
  ~TurnsAhead();

  /// (in realtime) The island has begun to wait; nothing happens where all slots are taken or it is larger than a slot.
  void give(const Island& island, const State& state) noexcept;
  /// (in realtime) At the island's turn: what the thread has found, until the next `give`; null: nothing of use. `goes_on`, `most`: see
  /// `takeTurn`. What it was given of these trees is done with.
  const Turn* take(const Island& island, bool goes_on, double most, const State& state) noexcept;
  /// (in realtime) State or model become others: nothing that was given counts.
  void forget() noexcept;
  /// Between two steps, after `forget`: waits until no turn is being solved.
  void tune(const WorldTuning& tuning);

  std::uint64_t taken() const { return taken_; }  ///< turns that the thread has spared steps
  std::uint64_t missed() const { return missed_; }  ///< turns that were given, and that steps have solved none the less
  /// Between two steps: waits until all that was given is solved.
  void finish() const;

 private:
  struct Far;

  void run() noexcept;
  Turn* next() noexcept;
  void solve(Turn& turn) noexcept;
  void release(int tree) noexcept;

  std::vector<Turn> turns_;
  std::vector<int> turn_of_;        ///< by tree, the lowest of an island: its slot; −1: none
  std::uint64_t taken_ = 0, missed_ = 0;
  const Model& model_;              ///< the world's
  std::unique_ptr<Far> far_;        ///< the thread's own world
  std::mutex solving_;              ///< while a turn is solved; no step takes it
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace haptic::stepping
