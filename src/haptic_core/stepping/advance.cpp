#include "haptic_core/stepping/advance.h"

#include <algorithm>
#include <limits>

#include "haptic_core/stepping/choice.h"
#include "haptic_core/stepping/explicit_step.h"
#include "haptic_core/stepping/implicit_islands.h"
#include "haptic_core/stepping/standing_islands.h"

namespace haptic::stepping {
namespace {

/// Explicit attempts until one counts: each that does not makes a tree implicit or asks for more parts.
void explicitPart(const Model& model, StepPart& part, State& state, Work& work, Report& report) noexcept {
  int attempts = static_cast<int>(model.trees.size()) + kMostParts;
  work.choice.decided = false;
  while (!velocityVerlet(model, part, state, work, report)) {
    takeBack(model, state, work, report.step);
    ++report.step.redone;
    const bool spent = work.counted.spent();
    if (spent) giveUpExplicit(model, state, work);
    work.choice.decided = --attempts == 0 || spent;
    if (!anyImplicit(state)) part = shortened(model, part, model.substep() / work.choice.parts);
  }
}

/// False: some island did not converge.
bool implicitPart(const Model& model, const StepPart& part, State& state, Work& work, Report& report) noexcept {
  constexpr unsigned kFailed = kNotConverged | kJointsNotConverged;
  const unsigned before = report.step.flags & kFailed;
  report.step.flags &= ~kFailed;
  stepImplicitIslands(model, part, state, work, report);
  const bool converged = (report.step.flags & kFailed) == 0;
  report.step.flags |= before;
  return converged;
}

}  // namespace

void advance(const Model& model, StepPart& part, State& state, Work& work, Report& report) noexcept {
  if (model.allFlows()) return flowAll(model, part, state, work, report);
  prime(model, part, state, work, report);
  work.choice.position_error = 0;
  Retreat& retreat = work.choice.retreat;
  if (model.implicit_steps) keepForRetreat(model, work.visits, state, work.hands, report.step, retreat);
  explicitPart(model, part, state, work, report);
  double longest = std::numeric_limits<double>::infinity();  // parts of explicit steps are not for implicit ones
  while (anyImplicit(state)) {
    const int islands = report.step.implicit_islands;
    std::copy(state.mode.begin(), state.mode.end(), retreat.mode.begin());  // an island of the attempt may have become explicit
    const bool converged = implicitPart(model, part, state, work, report);
    part.longest = longest;
    if (converged || part.h < kWorthHalving || work.counted.spent()) break;
    longest = 0.5 * part.h;
    takeBack(model, state, work, report.step);
    std::copy(retreat.mode.begin(), retreat.mode.end(), state.mode.begin());
    work.hands.wrench = retreat.wrench;
    work.standing.forget();
    work.asleep.wakeAll(model, state, work, nullptr);
    report.step.implicit_islands = islands;
    ++report.step.redone;
    part = shortened(model, part, longest);
    explicitPart(model, part, state, work, report);
  }
  const bool may_settle = model.implicit_steps && part.h == model.settings.step;
  if (may_settle) settleExplicit(model, part.h, work.visits, work.placement, work.islands, work.hands, state);
  if (may_settle && isTurnNext(model, state)) settleFar(model, work.visits, work.placement, work.islands, work.hands.held_by, state);
  report.step.position_error += work.choice.position_error;
  report.step.pairs = state.pair_count;
  report.step.contacts = report.contacts.size();
}

}  // namespace haptic::stepping
