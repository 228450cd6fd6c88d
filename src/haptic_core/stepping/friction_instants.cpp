#include "haptic_core/stepping/friction_instants.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/bracket.h"

namespace haptic::stepping {
namespace {

/// An instant is located when the load is this close to the limit, or the slip this small against its start.
constexpr double kLocated = 1e-8;
constexpr int kMostLocations = 12;
/// Touching pairs of an island in which the instants of friction are located.
constexpr int kFewContacts = 4;

/// Power of two slips (translation and spin) in the metric of the friction layer, per its stiffness.
double product(const FrictionMemory& metric, const FrictionMemory& a, const FrictionMemory& b) {
  return metric.area * a.rate_M.dot(b.rate_M) + metric.torsion * a.spin * b.spin;
}

void slide(FrictionMemory& memory) {
  memory.sliding = 1;
  memory.rate_M = memory.slip_M;
  memory.spin = memory.twist;
}

/// Whether a contact slid, and has come to a stop within the stage's solve.
bool stops(const ImplicitContact& c, Yielding mode) noexcept { return mode == Yielding::kKeepsLimit && c.force.memory.sliding == 0; }

/// How far a contact is beyond what its mode allows: the load over the static limit, or the slip that has turned
/// around, both relative; negative before. Contacts that slide on have none. `start`: of the step.
double violationOf(const ImplicitContact& c, Yielding mode, FrictionMemory start) noexcept {
  if (mode == Yielding::kNever) return c.force.memory.load - 1;
  if (mode != Yielding::kDragged) return -1;
  start.rate_M = c.force.inNewAxes(start.rate_M);
  const double size = product(start, start, start);
  return size > 0 ? -product(start, start, c.force.memory) / size : 0;
}

double violationOf(const ImplicitContact& c, const State& state, const ImplicitStage& stage) noexcept {
  return violationOf(c, stage.base.yielding[c.pair], state.pairs[c.pair].friction);
}

double mostViolation(const State& state, const ImplicitStage& stage) noexcept {
  double most = -1;
  for (const ImplicitContact& c : stage.contacts.all()) most = std::max(most, violationOf(c, state, stage));
  return most;
}

/// Of contacts that stick.
double violationAtStart(const State& state, const ImplicitStage& stage) noexcept {
  double most = -1;
  for (const ImplicitContact& c : stage.contacts.all()) {
    if (stage.base.yielding[c.pair] == Yielding::kNever) most = std::max(most, state.pairs[c.pair].friction.load - 1);
  }
  return most;
}

/// After an event there is no last step that BDF2 could go on from.
void forgetLastStep(const Island& island, State& state) noexcept {
  for (int n = 0; n < island.tree_count; ++n) state.last_step[island.trees[n]] = 0;
}

/// The contacts at their limit slide from now on, those that stopped stick. `violation`: by pair, at the end of the part, `elapsed`
/// as a share of the step.
void changeModes(const Model& model, const ImplicitStage& stage, const std::vector<double>& violation, double least, double elapsed,
                 State& state, std::vector<double>& event) noexcept {
  forgetLastStep(stage.island, state);
  for (const ImplicitContact& c : stage.contacts.all()) {
    FrictionMemory& memory = state.pairs[c.pair].friction;
    const Yielding mode = stage.base.yielding[c.pair];
    if (mode == Yielding::kKeepsLimit || violation[c.pair] < least) continue;
    event[c.pair] = elapsed;
    if (mode == Yielding::kNever) {
      slide(memory);
    } else {
      memory.sliding = 0;
      const PairLaw law = model.law(c.shape_a, c.shape_b, false, false);
      memory.load = law.material.mu_dynamic / law.material.mu_static;
    }
  }
}

/// The contacts that are at their limit as the part begins slide from now on.
void slideAtOnce(const ImplicitStage& stage, double elapsed, State& state, std::vector<double>& event) noexcept {
  for (const ImplicitContact& c : stage.contacts.all()) {
    FrictionMemory& memory = state.pairs[c.pair].friction;
    if (stage.base.yielding[c.pair] != Yielding::kNever || memory.load < 1 - kLocated) continue;
    slide(memory);
    event[c.pair] = elapsed;
  }
  forgetLastStep(stage.island, state);
}

}  // namespace

bool mayJump(const Model& model, const Island& island, const State& state) noexcept {
  int touching = 0;
  bool jumps = false;
  for (int i = 0; i < island.pair_count; ++i) {
    const ActivePair& pair = state.pairs[island.pairs[i]];
    if (pair.friction.touching == 0) continue;
    ++touching;
    const ContactMaterial m = model.law(pair.shapeA(), pair.shapeB(), false, false).material;
    jumps |= m.mu_static > m.mu_dynamic;
  }
  return jumps && touching <= kFewContacts;
}

bool changesMode(const State& state, const ImplicitStage& stage) noexcept {
  return std::any_of(stage.contacts.all().begin(), stage.contacts.all().end(), [&](const ImplicitContact& c) {
    return stops(c, stage.base.yielding[c.pair]) || violationOf(c, state, stage) > 0;
  });
}

UpToInstant stepToInstant(const Model& model, double s, State& state, ImplicitWork& work) noexcept {
  ImplicitStage& stage = work.stage;
  const IslandStep& step = work.step;
  for (const ImplicitContact& c : stage.contacts.all()) {
    if (stops(c, stage.base.yielding[c.pair])) stage.base.yielding[c.pair] = Yielding::kDragged;
  }
  const double low = 0, f_low = violationAtStart(state, stage);
  if (f_low >= -kLocated) {
    slideAtOnce(stage, 1 - step.beyond(0) / work.books.length, state, work.books.event);
    return {0, kNone};
  }
  const int before = step.used(stage);
  Attempt attempt = sdirk2(model, state, step, s, stage, work.schemes, work.books);  // what stops is dragged on
  if (!(attempt.part.length > 0)) return {};
  const int solve = step.used(stage) - before;
  double t = s, f = mostViolation(state, stage);
  const bool turns = f > 0;
  Bracket bracket(low, f_low, s, f);
  for (int i = 0; turns && i < kMostLocations && std::abs(f) > kLocated; ++i) {
    t = bracket.guess();
    if (!step.affords(solve, step.left, stage)) return {};
    attempt = sdirk2(model, state, step, t, stage, work.schemes, work.books);
    if (!(attempt.part.length > 0)) return {};
    f = mostViolation(state, stage);
    bracket.take(t, f);
  }
  if (attempt.excess > 1) return {-1, attempt.excess};
  std::vector<double>& violation = work.schemes.violation;
  for (const ImplicitContact& c : stage.contacts.all()) violation[c.pair] = violationOf(c, state, stage);
  commit(model, attempt.part, t, state, work);
  if (turns) changeModes(model, stage, violation, f - 10 * kLocated, 1 - step.beyond(t) / work.books.length, state, work.books.event);
  return {t, kNone};
}

}  // namespace haptic::stepping
