#include "haptic_core/stepping/implicit_step.h"

#include <algorithm>

#include "haptic_core/stepping/friction_instants.h"
#include "haptic_core/stepping/stage_reference.h"

namespace haptic::stepping {
namespace {

/// The budget: evaluations of a pair in a step, and bounds of those of its island.
constexpr int kPairEvaluations = 128, kLeastEvaluations = 10, kMostEvaluations = 64;
/// Sub-steps are no shorter than a step over this; attempts of a step at them, instants of friction included.
constexpr int kMostParts = 8, kMostAttempts = 24;
/// Halving goes on while the error falls by this factor at least: to a quarter where the motion is resolved.
constexpr double kHelps = 0.4;
/// An island below this speed, over what gravity adds in a step times the accuracy, settles: Euler's costs half, and it damps the rocking
/// that SDIRK2 and Hunt-Crossley leave for seconds. Bodies that fall, swing, slide off or turn back are as slow as that for a few
/// steps, so the order stays 2. Bodies that only stick can but rock. Without the accuracy in it, a cube that comes to rest errs by 2.5 um
/// whatever is asked for (`accuracy.order` .06).
constexpr double kSettles = 33, kSettlesStuck = 167;
/// BDF2 takes up from a step of at least 1/kMostRatio of its own length: it is stable up to 1 + √2 for steps of any sequence.
constexpr double kMostRatio = 2;

/// Pairs up to which an island may be carried: in a heap that a hand goes through most attempts fail that a wrong guess begins, and what
/// changes its speed is rocking, which is to settle.
constexpr int kFewPairs = 4;
/// Share of friction's static limit from which a slow contact is looked at for the instant at which it gives way. At 1 (no limit)
/// `stick_slip` leaves its plateau up to a step late; at 0 whatever sticks is solved twice (a_cube: 1.15 of the instructions).
constexpr double kNearLimit = 0.8;
/// Change of speed in a step, over `slow`, above which carried bodies that stick do not come to rest but go to and fro: .3 g.
constexpr double kTurnsBack = 10;
/// The same above which a body is at the lowest point of a bounce, where nothing is explicit: 2 g.
constexpr double kBounces = 66;

/// Whether the island touches a link that a hand leads or joints move: a platform, a gripper.
bool isCarried(const Model& model, const ImplicitStage& stage, const State& state) noexcept {
  const Island& island = stage.island;
  if (island.pair_count > kFewPairs) return false;
  return std::any_of(island.pairs, island.pairs + island.pair_count, [&](int i) {
    const ActivePair& pair = state.pairs[i];
    const auto led = [&](int shape) { return stage.held.by[model.shapes[shape].link] >= 0; };
    return pair.friction.touching != 0 && (stage.has_joints || led(pair.shapeA()) || led(pair.shapeB()));
  });
}

/// Slow enough to come to rest, see kSettles. `slow`: what gravity adds in a step, or joints that stand make, times the accuracy [m/s].
/// Where instants of friction are located, all that slides or is near its limit keeps its order until they are.
bool settles(const Model& model, const Island& island, const State& state, const IslandStep& step, double speed, double gained,
             double slow) {
  const bool all_implicit = model.settings.attempts == Attempts::kAll;
  bool touches = false, slides = false;
  for (int i = 0; i < island.pair_count; ++i) {
    const FrictionMemory& friction = state.pairs[island.pairs[i]].friction;
    if (friction.touching == 0) continue;
    touches = true;
    slides |= friction.sliding != 0;
    if (step.locates && (!all_implicit || slides || friction.load > kNearLimit)) return false;
  }
  const bool sticks = touches && !slides;
  const bool bounces = all_implicit && touches && island.pair_count <= kFewPairs && gained > kBounces * slow;
  const bool turns_back = sticks && step.carried && gained > kTurnsBack * slow;
  return speed <= (sticks ? kSettlesStuck : kSettles) * slow && !turns_back && !bounces;
}

/// Evaluations of the island's geometry in a step.
int budgetOf(const Island& island, const State& state) {
  int touching = 0;
  for (int i = 0; i < island.pair_count; ++i) touching += state.pairs[island.pairs[i]].friction.touching != 0;
  return std::clamp(kPairEvaluations / std::max(1, touching), kLeastEvaluations, kMostEvaluations);
}

/// What second order came to in a part of a step.
struct Outcome {
  double done = -1;  ///< committed [s]; < 0: nothing was good enough
  Attempt failed;    ///< then: the last one, which the stage may hold
};

/// BDF2 or SDIRK2 over s, or up to where friction changes.
Outcome secondOrder(const Model& model, double s, State& state, ImplicitWork& work) noexcept {
  ImplicitStage& stage = work.stage;
  const IslandStep& step = work.step;
  const double last = lastStep(stage.island, state);
  if (step.order == ImplicitOrder::kSecondMultistep && last > 0 && s <= kMostRatio * last && step.affords(kSmoothPasses, s, stage)) {
    setModes(state, step.locates, stage);
    Attempt attempt = bdf2(model, state, step, s, last, stage, work.schemes);
    const bool solved = attempt.part.length > 0;
    if (!solved || !step.locates || !changesMode(state, stage)) {
      if (solved && attempt.excess <= 1) {
        commit(model, attempt.part, s, state, work);
        return {s, {}};
      }
      attempt.excess *= kErrorSdirk2 / kErrorBdf2;  // that of SDIRK2, foreseen
      if (attempt.excess > 1) return {-1, attempt};
    }
  }
  if (!step.affords(2 * kSmoothPasses, s, stage)) return {};
  setModes(state, step.locates, stage);
  const Attempt attempt = sdirk2(model, state, step, s, stage, work.schemes, work.books);
  if (!(attempt.part.length > 0)) return {};
  if (step.locates && changesMode(state, stage)) {
    const UpToInstant found = stepToInstant(model, s, state, work);
    return {found.done, {{}, found.excess, 0}};
  }
  if (attempt.excess > 1) return {-1, attempt};
  commit(model, attempt.part, s, state, work);
  return {s, {}};
}

/// Goes on by second order while error and budget allow.
void subSteps(const Model& model, State& state, ImplicitWork& work) noexcept {
  IslandStep& step = work.step;
  const ImplicitStage& stage = work.stage;
  double s = step.length, error = kNone;
  int parts = 0;  // that resolve an impact
  for (int n = 0; n < kMostAttempts && step.left > 0; ++n) {
    s = std::min(s, step.left);
    const Outcome outcome = secondOrder(model, s, state, work);
    if (outcome.done >= 0) {
      step.goOn(outcome.done);
      error = kNone;
      continue;
    }
    const Attempt& failed = outcome.failed;
    if (failed.excess < kHelps * error && s > 1.001 * step.length / kMostParts) {
      error = failed.excess;
      s *= 0.5;
      continue;
    }
    const bool jumps = !(failed.part.length > 0);
    if (jumps) parts = std::max(parts, partsOfImpact(model, state, stage, step.length));
    if (jumps && parts > 1 && step.affords(2 * kSmoothPasses, step.left, stage)) {
      error = kNone;
      if (s * parts > step.length) {
        s *= 0.5;
        continue;
      }
      euler(model, s, step.room(stage), {}, state, work);
      step.goOn(s);
      s = step.left;
      continue;
    }
    // Impacts (`kNone`) are implicit Euler's. What halving does not help is the attempt's that errs least.
    if (!(failed.part.length > 0) || !(failed.part.position_error < failed.eulerError())) break;
    commit(model, failed.part, failed.part.length, state, work);
    step.goOn(failed.part.length);
    error = kNone;
  }
}

/// Implicit Euler over the rest of the step. A long part that does not converge is halved, each half on a budget of its own.
void eulerToTheEnd(const Model& model, State& state, ImplicitWork& work) noexcept {
  IslandStep& step = work.step;
  const ImplicitStage& stage = work.stage;
  for (double s = step.left; step.left > 0;) {
    s = stage.isSpent() ? step.left : std::min(s, step.left);
    if (euler(model, s, step.eulerPasses(stage), {false, s >= kWorthHalving && !stage.isSpent()}, state, work)) {
      step.goOn(s);
    } else {
      s *= 0.5;
    }
    if (s < step.length && step.left > 0) step.evaluations_before = stage.evaluations;
  }
}

}  // namespace

void beginIslands(const Model& model, State& state, const std::vector<int>& trees, const HandWork& hands, Seams& seams, double h,
                  ImplicitWork& work) noexcept {
  beginStages(model, state, trees, hands, seams, h, work.stage);
  openBooks(state.pairs.awake(), work.books);
  work.begun = true;
}

double evaluationUnits(const Model& model, const Island& island, const State& state) noexcept {
  constexpr int kNewtonSteps = 2;
  double looks = 0;
  int rows = island.tree_count, unknowns = 0, links = 0;
  for (int i = 0; i < island.pair_count; ++i) {
    const ActivePair& pair = state.pairs[island.pairs[i]];
    looks += model.look(pair.shapeA(), pair.shapeB());
    rows += pair.friction.touching != 0;
  }
  for (int n = 0; n < island.tree_count; ++n) {
    unknowns += model.trees[island.trees[n]].model->nv();
    links += model.trees[island.trees[n]].model->linkCount();
  }
  return units::kLink * links + looks + kNewtonSteps * (units::kRow * rows + units::kProduct * 36 * unknowns);
}

void openIsland(double h, double most, ImplicitWork& work) noexcept {
  work.report = ImplicitReport{};
  work.books.length = h;
  work.books.given = 0;
  work.stage.units = 0;
  work.stage.most_units = most;
}

void advanceIsland(const Model& model, const Island& island, double h, double after, ImplicitOrder order, State& state,
                   ImplicitWork& work) noexcept {
  ImplicitStage& stage = work.stage;
  ImplicitReport& report = work.report;
  IslandStep& step = work.step;
  const int iterations = stage.iterations, evaluations = stage.evaluations, factorisations = stage.factorisations;
  const bool led = !model.forces.empty();  // what hands hold stands at the step's end: the forces before are those of the span's start
  if (led) placeHeld(model, state, h + after, stage.held, stage.places);
  select(model, island, stage);
  if (led) placeHeld(model, state, 0, stage.held, stage.places);
  work.books.forces_before = stage.forces.power;
  step.order = order;
  step.locates = order != ImplicitOrder::kFirst && mayJump(model, island, state);
  step.carried = order != ImplicitOrder::kFirst && isCarried(model, stage, state);
  step.length = step.left = h;
  step.after = after;
  step.budget = budgetOf(island, state);
  step.evaluations_before = stage.evaluations;
  startFromState(model, state, stage);
  const double speed = stage.speed(state.v);
  const double slow = model.settings.accuracy * std::max(h * model.settings.gravity.norm(), kStandingWay / h);
  const bool rests = speed <= restBound(model, state, stage, h);  // then it is asked first whether it stands, and nothing slips
  const double gained = h * stage.speed(state.a_end);
  const bool second_order =
      order != ImplicitOrder::kFirst && !rests && !settles(model, island, state, step, speed, gained, slow);
  const bool jumps_on =
      second_order && lastStep(island, state) < 0 && euler(model, h, step.eulerPasses(stage), {true, h >= kWorthHalving}, state, work);
  if (second_order && !jumps_on) subSteps(model, state, work);
  report.fell_back |= jumps_on || (second_order && step.left > 0);
  if (!jumps_on) eulerToTheEnd(model, state, work);
  report.iterations += stage.iterations - iterations;
  report.evaluations += stage.evaluations - evaluations;
  report.budget_used = std::max(report.budget_used, static_cast<double>(step.used(stage)) / step.budget);
  report.factorisations += stage.factorisations - factorisations;
  report.units = stage.units;
  report.cut = stage.isSpent();
  report.residual = stage.result.error;
  report.wrench_error = stage.result.wrench_error;
}

}  // namespace haptic::stepping
