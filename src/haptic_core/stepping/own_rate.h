/// Own rates: islands that no hand touches, or can reach before their next turn, are stepped by WorldSettings::far_step.
///
/// Such an island waits. Between two turns no stage visits it: it is left out like one at rest (activity.h), where it was at
/// its last turn, its boxes as wide as it may come until the next one. At its turn it comes to the present in one implicit step over the
/// time that it is late, whose error is bounded as that of any step. What comes near its boxes, and whoever acts on one of its bodies,
/// brings it to the present before; then it is stepped by h, until nothing is near at a common turn, every far_step.
///
/// Only free bodies wait, and only alone (`standsAlone`), with no wrench on them, and too slow to pass through one another or what
/// never moves. Turns are spread over the steps by their number of bodies. Where a step has a budget (world/counted_work.h), turns take
/// half of the budget at most: others wait a step more, and so on, up to a second far_step. The turns follow from State::turn and
/// State::as_of, by counts of steps: they are saved, restored and replayed, and a world that is looked at goes on as if it had not been.
///
/// Errors: those of far_step, or of two, where nothing near is touched; and at most that late is what reaches the near islands.
#pragma once
#include <cstdint>
#include <vector>

#include "haptic_core/world/islands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/placement.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/visits.h"

namespace haptic::stepping {

/// (in realtime) The tree's turn has come, and it is late.
inline bool isDue(const State& state, int tree) noexcept { return state.turn[tree] != 0 && state.turn[tree] <= state.step; }

/// (in realtime) At the step about to be taken every island that is far may begin to wait.
inline bool isCommonTurn(const Model& model, const State& state) noexcept {
  return model.turn_steps > 1 && state.step % static_cast<std::uint64_t>(model.turn_steps) == 0;
}

/// (in realtime) All trees of the island are of one age, and have their turn in one step.
bool isOfOneTurn(const Island& island, const State& state) noexcept;

/// (in realtime) All trees of the island wait for the same turn, which is still to come, and nothing else that moves is near.
bool waits(const Model& model, const Island& island, const State& state) noexcept;

/// (in realtime) The island is alone, of free bodies, and slow enough to be left for a turn.
bool mayWait(const Model& model, const Island& island, const State& state, const Placement& placement) noexcept;

/// (in realtime) The island is as it is after `as_of` steps, and has its next turn at the start of step `turn`.
void wait(const Island& island, std::uint64_t as_of, std::uint64_t turn, State& state) noexcept;

/// (in realtime) First turn of an island that begins to wait after this step: where least is to be done among those that are possible.
std::uint64_t firstTurn(const Model& model, const State& state, std::vector<int>& load) noexcept;

/// (in realtime) Longest time that an island that waits is behind [s].
double lagOf(const Model& model, const State& state) noexcept;

/// (in realtime) Time for which a search has to foresee the motion of an implicit tree, in a step of length h [s].
double foreseen(const Model& model, const State& state, int tree, double h) noexcept;

/// Scratch of own rates.
struct RateWork {
  std::vector<char> alone;  ///< by tree: its island has come to its turn with nothing near
  std::vector<int> load;    ///< by turn within a far_step: trees that have it

  explicit RateWork(const Model& model) : alone(model.trees.size()), load(static_cast<std::size_t>(model.turn_steps)) {}  ///< set-up
};

}  // namespace haptic::stepping
