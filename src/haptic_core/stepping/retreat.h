/// The way back from a step that did not converge: its state before, and its undoing.
#pragma once
#include <vector>

#include "haptic_core/world/hands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/visits.h"

namespace haptic {
struct Work;
}

namespace haptic::stepping {

/// The state before a step; the pairs before it are those of the last search.
struct Retreat {
  std::vector<double> q, v, pull, a_end, a_mean, v_mean, last_step;  ///< of the state, see State
  std::vector<TreeMode> mode;      ///< of the state
  std::vector<Wrench> wrench;      ///< on the hands
  EnergySums energy;               ///< of the ledger
  int pair_count = 0;              ///< of the state
  unsigned flags = 0;              ///< of the report

  explicit Retreat(const Model& model);  ///< set-up: room for all trees
};

/// (in realtime) Before a step.
void keepForRetreat(const Model& model, const Visits& visits, const State& state, const HandWork& hands, const StepReport& report,
                    Retreat& retreat) noexcept;
/// (in realtime) The same of a tree that wakes within a step, before anything moves it.
void keepForRetreat(const ModelTree& tree, int index, const State& state, Retreat& retreat) noexcept;
/// (in realtime) Undoes a step; everything is placed again.
void takeBack(const Model& model, State& state, Work& work, StepReport& report) noexcept;

}  // namespace haptic::stepping
