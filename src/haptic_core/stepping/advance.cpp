#include "haptic_core/stepping/advance.h"

#include <limits>

#include "haptic_core/stepping/explicit_contacts.h"
#include "haptic_core/stepping/explicit_step.h"
#include "haptic_core/stepping/implicit_islands.h"

namespace haptic::stepping {
namespace {

/// All that hands lead at the part's end: there pairs are found, and contacts in which nothing moves by itself.
void lead(const Model& model, const StepPart& part, State& state, Work& work, Report& report) noexcept {
  moveHeld(model, part, state, work.hands, work.placement);
  placeTrees(model, work.visits.trees, state, work.placement);
  work.clock.end(report.step.stages.motion);
  lookForPairs(model, part.h, state, work, report.step);
  evaluateContacts(model, {part.h, true}, state, work, report);
  if (!model.settings.energy_ledger) return;
  bookVerlet(work.ledgerView(model), part.h, work.motion.v_half, work.motion.v_ahead, work.contacts.booked, state);
}

/// False: some island did not converge.
bool solve(const Model& model, const StepPart& part, State& state, Work& work, Report& report) noexcept {
  constexpr unsigned kFailed = kNotConverged | kJointsNotConverged;
  const unsigned before = report.step.flags & kFailed;
  report.step.flags &= ~kFailed;
  stepImplicitIslands(model, part, state, work, report);
  const bool converged = (report.step.flags & kFailed) == 0;
  report.step.flags |= before;
  return converged;
}

/// Islands each in their way, and where one does not converge and the step is long, all of them in halves.
void advanceIslands(const Model& model, StepPart& part, State& state, Work& work, Report& report) noexcept {
  keepForRetreat(model, work.visits, state, work.hands, report.step, work.retreat);
  lead(model, part, state, work, report);
  double longest = std::numeric_limits<double>::infinity();
  while (true) {
    const int islands = report.step.implicit_islands;
    const bool converged = solve(model, part, state, work, report);
    part.longest = longest;
    if (converged || part.h < kWorthHalving || work.counted.spent()) return;
    longest = 0.5 * part.h;
    takeBack(model, state, work, report.step);
    work.standing.forget();
    work.asleep.wakeAll(model, state, work, nullptr);
    report.step.implicit_islands = islands;
    ++report.step.redone;
    part = shortened(model, part, longest);
    lead(model, part, state, work, report);
  }
}

}  // namespace

void advance(const Model& model, StepPart& part, State& state, Work& work, Report& report) noexcept {
  if (model.allFlows()) return flowAll(model, part, state, work, report);
  work.position_error = 0;
  if (model.explicit_steps) {
    velocityVerlet(model, part, state, work, report);
  } else {
    advanceIslands(model, part, state, work, report);
  }
  report.step.position_error += work.position_error;
  report.step.pairs = state.pair_count;
  report.step.contacts = report.contacts.size();
}

}  // namespace haptic::stepping
