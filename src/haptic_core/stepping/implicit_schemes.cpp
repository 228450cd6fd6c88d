#include "haptic_core/stepping/implicit_schemes.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/stepping/stage_energy.h"
#include "haptic_core/stepping/stage_passes.h"
#include "haptic_core/stepping/rest.h"

namespace haptic::stepping {
namespace {

constexpr double kNext = (1 - kGamma) / kGamma;
/// Passes of a stage of second order in which instants of friction are located.
constexpr int kMostPasses = 7;
/// A patch that grows or shrinks by more than this factor within an attempt is not smooth: second order there makes energy.
constexpr double kGrowth = 2;
/// A contact that begins or ends at more than kImpact times the speed that gravity gives in a step is an impact. It is cut out in parts of
/// kPartOfSwing radians of its contact's swing, where it swings by no more than kResolved in the step and no more than kMostResolved pairs
/// touch, each of which costs a part again: a bounce then keeps its speed to 5 % in place of 43 %, with parts twice as long to 14 %.
constexpr double kImpact = 6, kResolved = 2, kPartOfSwing = 0.05;
constexpr int kMostResolved = 8;
/// Share of the step below which nothing is left of it.
constexpr double kRest = 1e-9;

/// Whether bodies that meet at that speed part again at one that matters: the damper within the spring, c, leaves no more than 1/c.
bool givesBack(const PairLaw& law, double speed) noexcept {
  const PressureKind& kind = kindOf(law.pressure);
  return kind.damper == PressureKind::Damper::kBesideSpring || kind.damping(law.material) * speed < 1;
}

bool sticksAtAll(const FrictionMemory& m) { return m.touching != 0 && m.sliding == 0; }

double losses(const EnergySums& sums) { return sums.damping + sums.friction; }

/// q ⊕ t v of the island.
void moveOn(const Model& model, const Island& island, const std::vector<double>& v, double t, std::vector<double>& q) noexcept {
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model.trees[island.trees[n]];
    integratePositions(*tree.model, q.data() + tree.q, v.data() + tree.v, t);
  }
}

/// Whether the contacts of the last evaluation are those of the step's start, and their patches about as large: an edge
/// that becomes a face is an impact.
bool sameContacts(const State& state, const ImplicitStage& stage) noexcept {
  const Island& island = stage.island;
  int next = 0;
  for (int i = 0; i < island.pair_count; ++i) {
    const bool now = next < stage.contacts.all().size() && stage.contacts.all()[next].pair == island.pairs[i];
    const ActivePair& before = state.pairs[island.pairs[i]];
    if (now != (before.friction.touching != 0)) return false;
    if (!now) continue;
    const double area = stage.contacts.all()[next++].volume.A0;
    if (area > kGrowth * before.friction.area || before.friction.area > kGrowth * area) return false;
  }
  return true;
}

/// Whether the island touches something or a force element holds it, and is at rest before and after.
bool staysAtRest(const Model& model, const State& state, const ImplicitStage& stage, double h) noexcept {
  const double most = restBound(model, state, stage, h);
  if ((stage.contacts.all().empty() && !stage.forces.any) || stage.has_joints) return false;
  if (stage.speed(stage.v) > most || stage.speed(stage.base.v) > most || !sameContacts(state, stage)) return false;
  const auto runs = [](const ImplicitContact& c) { return c.force.on_belt; };  // under what stands it works on
  if (std::any_of(stage.contacts.all().begin(), stage.contacts.all().end(), runs)) return false;
  const Island& island = stage.island;
  return std::all_of(island.pairs, island.pairs + island.pair_count,
                     [&](int i) { return state.pairs[i].friction.began == 0 && !state.pairs[i].buried; });
}

/// The state stays as it is, at rest. The supply of hands that press it from both sides is in its springs at its next motion.
void stand(const Model& model, double h, State& state, ImplicitWork& work) noexcept {
  const ImplicitStage& stage = work.stage;
  ImplicitReport& report = work.report;
  const Island& island = stage.island;
  ++report.parts;
  report.rests = report.stands = true;
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model.trees[island.trees[n]];
    double* v = state.v.data() + tree.v;
    report.stands &= std::all_of(v, v + tree.model->nv(), [](double x) { return x == 0 && !std::signbit(x); });
    for (double* x : {v, &state.a_end[tree.v], &state.a_mean[tree.v], &state.v_mean[tree.v]}) std::fill_n(x, tree.model->nv(), 0.0);
    state.last_step[island.trees[n]] = h;
    state.calm[island.trees[n]] = kCalmSteps;
  }
  if (!report.stands) report.position_error += h * stage.speed(stage.base.v);  // of the motion that is left out, once
  for (int i = 0; i < island.pair_count; ++i) state.pairs[island.pairs[i]].cache = work.schemes.cache[island.pairs[i]];
  bookStanding(model, stage, h, state, work.books);
}

/// Acceleration over a solve of length g less that at the end of the last step.
void changeSinceLastStep(const Model& model, const State& state, const ImplicitStage& stage, double g,
                         std::vector<double>& change) noexcept {
  eachVelocity(model, stage.island, [&](int i) { change[i] = (stage.v[i] - stage.base.v[i]) / g - state.a_end[i]; });
}

/// Largest change of speed of a tree since the state [m/s].
double speedGained(const Model& model, const State& state, const ImplicitStage& stage, std::vector<double>& gained) noexcept {
  eachVelocity(model, stage.island, [&](int i) { gained[i] = stage.v[i] - state.v[i]; });
  return stage.speed(gained);
}

/// Of a solve over s in a step of length h whose error of position is `share` s² |work.change|.
Attempt judge(const Model& model, const State& state, const ImplicitStage& stage, double h, const SolvedPart& part, double share,
              SchemeWork& work) noexcept {
  const double s = part.length, gained = speedGained(model, state, stage, work.gained);
  const double may = model.settings.accuracy * (gained * h / s + h * model.settings.gravity.norm());
  const double error = share * s * stage.speed(work.change);  // as a speed
  Attempt attempt{part, error > 0 ? error / may : 0, gained};
  attempt.part.position_error = s * error;
  return attempt;
}

/// A stage at whose end contacts are as at the start of the step. False: they are not, or those of the guess are not. In a carried island
/// the guess decides nothing: it misses a stiff contact, which is 1e-7 m deep, and implicit Euler took most steps.
bool solveSmooth(const Model& model, State& state, const IslandStep& step, double g, double left,
                 ImplicitStage& stage) noexcept {
  const int room = step.room(stage);
  if (room < 1) return false;
  const int passes = step.locates ? std::min(kMostPasses, room) : kSmoothPasses;
  const auto goesOn = [&] { return !stage.result.limited && (step.carried || sameContacts(state, stage)); };
  if (!solveStage(model, state, g, left, passes, stage, goesOn) || stage.result.limited || !sameContacts(state, stage)) return false;
  return !stage.has_joints || stage.joints.isSmooth(state.v.data());
}

/// Where friction of a contact starts in SDIRK2's second stage. `start`: of the step.
FrictionMemory secondStart(const ImplicitContact& c, const FrictionMemory& start) noexcept {
  const FrictionMemory &s0 = start, &s1 = c.force.memory;
  FrictionMemory base = s1;
  const Vector3 slip_M = c.force.inNewAxes(s0.slip_M);
  base.slip_M = slip_M + kNext * (s1.slip_M - slip_M);
  base.twist = s0.twist + kNext * (s1.twist - s0.twist);
  // Poses say how far the bodies are by the second stage; what yielded goes on from the first.
  const Vector3 more = (1 - kNext) * c.force.yielded;
  base.anchor.slip_A += c.volume.X_AP.R.leftCols<2>() * more.head<2>();
  base.anchor.twist += more[2];
  // Area that has left may not seem to come again: the slip would fall by the error of the first stage's area.
  base.area = std::max(s0.area, s0.area + kNext * (s1.area - s0.area));
  base.torsion = std::max(s0.torsion, s0.torsion + kNext * (s1.torsion - s0.torsion));
  base.rate_M = c.force.inNewAxes(s0.rate_M);
  base.spin = s0.spin;
  base.sliding = s0.sliding;
  return base;
}

/// Keeps the means of the part, from which BDF2 goes on. `first_acceleration`: of SDIRK2's first stage.
void remember(const Model& model, const ImplicitStage& stage, const SolvedPart& part, double taken_up,
              const std::vector<double>& first_acceleration, State& state) noexcept {
  const Island& island = stage.island;
  const double g = part.g, h = part.length, share = g / h;  // of the step at the velocity of its end
  eachVelocity(model, island, [&](int i) {
    double before = state.v_mean[i];  // velocity at which the rest went
    if (part.mean == Mean::kOfStages) before = stage.base.v[i] + (2 * g - h) * first_acceleration[i];
    state.a_end[i] = (stage.v[i] - stage.base.v[i]) / g;
    state.a_mean[i] = (stage.v[i] - state.v[i]) / h;
    state.v_mean[i] = part.mean == Mean::kOfEnd ? stage.v[i] : share * stage.v[i] + (1 - share) * before;
  });
  for (int n = 0; n < island.tree_count; ++n) state.last_step[island.trees[n]] = taken_up;
}

}  // namespace

SchemeWork::SchemeWork(const Model& model)
    : acceleration(model.nv), change(model.nv), gained(model.nv), violation(model.pair_capacity), cache(model.pair_capacity) {}

int IslandStep::eulerPasses(const ImplicitStage& stage) const noexcept { return std::max(1, budget - kKeepingEnergy - used(stage)); }

bool IslandStep::affords(double evaluations, double s, const ImplicitStage& stage) const noexcept {
  return used(stage) + evaluations * left / s <= budget - kKeepingEnergy - kEulerPasses;
}

void IslandStep::goOn(double done) noexcept {
  left -= done;
  if (left <= kRest * length) left = 0;
}

void startFromState(const Model& model, const State& state, ImplicitStage& stage) noexcept {
  const Island& island = stage.island;
  stage.base.since = 0;
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model.trees[island.trees[n]];
    std::copy_n(state.q.begin() + tree.q, tree.model->nq(), stage.base.q.begin() + tree.q);
    std::copy_n(state.v.begin() + tree.v, tree.model->nv(), stage.base.v.begin() + tree.v);
    std::copy_n(state.v.begin() + tree.v, tree.model->nv(), stage.v.begin() + tree.v);
  }
  for (int i = 0; i < island.pair_count; ++i) {
    stage.base.memory[island.pairs[i]] = state.pairs[island.pairs[i]].friction;
  }
}

double restBound(const Model& model, const State& state, const ImplicitStage& stage, double h) noexcept {
  const bool calm = isCalm(stage.island, state) && standsAlone(model, stage.island, state);
  return std::max(kOfRounding * finest(model, stage, h), calm ? restingSpeed(model.settings, h) : 0.0);
}

double lastStep(const Island& island, const State& state) noexcept {
  const double first = state.last_step[island.trees[0]];
  double least = first;
  bool same = true;
  for (int n = 1; n < island.tree_count; ++n) {
    const double last = state.last_step[island.trees[n]];
    same &= last == first;
    least = std::min(least, last);
  }
  return same || least < 0 ? least : 0;
}

void setModes(const State& state, bool locates, ImplicitStage& stage) noexcept {
  const Island& island = stage.island;
  for (int i = 0; i < island.pair_count; ++i) {
    const FrictionMemory& memory = state.pairs[island.pairs[i]].friction;
    stage.base.yielding[island.pairs[i]] = locates && sticksAtAll(memory) ? Yielding::kNever : Yielding::kKeepsLimit;
  }
}

int partsOfImpact(const Model& model, const State& state, const ImplicitStage& stage, double h) noexcept {
  if (model.settings.attempts != Attempts::kAll) return 0;
  const Island& island = stage.island;
  const LoadedVector<ImplicitContact>& contacts = stage.contacts.all();
  double approach = 0;
  for (const FrozenContact& c : stage.problem.contacts) {
    approach = std::max(approach, std::abs(stage.problem.twistOf(c, state.v.data())[5]));
  }
  const double slow = kImpact * h * model.settings.gravity.norm();
  double swing2 = 0;
  int touching = 0, next = 0;
  bool any = false;
  for (int i = 0; i < island.pair_count; ++i) {
    const ActivePair& pair = state.pairs[island.pairs[i]];
    const bool before = pair.friction.touching != 0, now = next < contacts.size() && contacts[next].pair == island.pairs[i];
    const double area_before = before ? pair.friction.area : 0, area = now ? contacts[next++].volume.A0 : 0;
    if (!before && !now) continue;
    if (++touching > kMostResolved) return 0;
    const auto led = [&](int shape) { return stage.held.by[model.shapes[shape].link] >= 0; };
    const PairLaw law = model.law(pair.shapeA(), pair.shapeB(), led(pair.shapeA()), led(pair.shapeB()));
    swing2 = std::max(swing2, h * h * law.material.stiffness * std::max(area_before, area) / law.reduced_mass);
    const bool jumps = area_before > kGrowth * area || area > kGrowth * area_before;
    const double leaves = before ? std::sqrt(2 * pair.friction.elastic_energy / law.reduced_mass) : 0;  // what its spring throws back
    const double fast = std::max(approach, leaves);
    any |= jumps && fast > slow && givesBack(law, fast);
  }
  return any && swing2 <= kResolved * kResolved ? static_cast<int>(std::ceil(std::sqrt(swing2) / kPartOfSwing)) : 0;
}

bool euler(const Model& model, double h, int passes, Unless unless, State& state, ImplicitWork& work) noexcept {
  ImplicitStage& stage = work.stage;
  const Island& island = stage.island;
  startFromState(model, state, stage);
  for (int i = 0; i < island.pair_count; ++i) {
    stage.base.yielding[island.pairs[i]] = Yielding::kKeepsLimit;
    work.schemes.cache[island.pairs[i]] = state.pairs[island.pairs[i]].cache;
  }
  bool smooth = false;
  stage.base.run = h;
  const bool converged = solveStage(model, state, h, work.step.beyond(h), passes, stage, [&] {
    return !(smooth = unless.smooth && (sameContacts(state, stage) || partsOfImpact(model, state, stage, h) > 1));
  });
  if (smooth || (unless.fails && !converged)) return false;
  work.report.converged &= converged;
  if (converged && h == work.books.length && staysAtRest(model, state, stage, h)) {
    stand(model, h, state, work);
    return true;
  }
  const double lost = converged ? 0 : keepEnergy(model, state, h, stage);
  const double booked = losses(state.energy), supplied = state.energy.external + sumOf(work.books.coupling_work);
  changeSinceLastStep(model, state, stage, h, work.schemes.change);
  SolvedPart part{h, h, Mean::kOfEnd, 0};
  const Attempt as_bdf2 = judge(model, state, stage, work.step.length, part, kErrorBdf2, work.schemes);
  // Its error is that of a speed that was not there yet; the rest of a solve that did not converge counts in full.
  part.position_error = h * (0.5 * as_bdf2.gained + (converged ? 0 : stage.result.error));
  commit(model, part, !converged || !sameContacts(state, stage) ? -h : as_bdf2.excess > 1 ? 0 : h, state, work);
  if (converged) return true;
  // Forces out of balance are not what slowed the bodies: of their power no more is a loss than was lost.
  const double available = std::max(0.0, lost + state.energy.external + sumOf(work.books.coupling_work) - supplied);
  state.energy.damping -= std::max(0.0, losses(state.energy) - booked - available);
  return true;
}

Attempt bdf2(const Model& model, State& state, const IslandStep& step, double s, double last, ImplicitStage& stage,
             SchemeWork& work) noexcept {
  const double w = s / last, g = (1 + w) / (1 + 2 * w) * s, rest = s - g;
  startFromState(model, state, stage);
  moveOn(model, stage.island, state.v_mean, rest, stage.base.q);
  eachVelocity(model, stage.island, [&](int i) {
    stage.base.v[i] += rest * state.a_mean[i];
    stage.v[i] = stage.base.v[i] + g * state.a_end[i];
  });
  stage.base.run = stage.base.since = s;
  if (!solveSmooth(model, state, step, g, step.beyond(s), stage)) return {};
  changeSinceLastStep(model, state, stage, g, work.change);
  return judge(model, state, stage, step.length, {g, s, Mean::kOfSteps, 0}, kErrorBdf2, work);
}

Attempt sdirk2(const Model& model, State& state, const IslandStep& step, double s, ImplicitStage& stage, SchemeWork& work,
               StepBooks& books) noexcept {
  const Island& island = stage.island;
  const double g = kGamma * s, rest = (1 - kGamma) * s, left = step.beyond(s);
  std::vector<double>& first = work.acceleration;
  startFromState(model, state, stage);
  stage.base.run = g;
  if (!solveSmooth(model, state, step, g, left + rest, stage)) return {};
  if (stage.has_joints) {
    stage.joints.startAccount();
    stage.joints.account(nullptr, stage.v.data(), stage.v.data(), rest);
  }
  for (const ImplicitContact& c : stage.contacts.all()) stage.base.memory[c.pair] = secondStart(c, state.pairs[c.pair].friction);
  gather(stage, books.first, books);
  moveOn(model, island, stage.v, rest, stage.base.q);
  eachVelocity(model, island, [&](int i) {
    first[i] = (stage.v[i] - stage.base.v[i]) / g;
    stage.base.v[i] += rest * first[i];
    stage.v[i] = stage.base.v[i] + g * first[i];
  });
  stage.base.run = rest;
  if (!solveSmooth(model, state, step, g, left, stage)) return {};
  if (stage.has_joints) stage.joints.account(nullptr, stage.v.data(), stage.v.data(), g);
  eachVelocity(model, island, [&](int i) { work.change[i] = (stage.v[i] - stage.base.v[i]) / g - first[i]; });
  return judge(model, state, stage, step.length, {g, s, Mean::kOfStages, 0}, kErrorSdirk2, work);
}

void commit(const Model& model, const SolvedPart& part, double taken_up, State& state, ImplicitWork& work) noexcept {
  ImplicitStage& stage = work.stage;
  const Island& island = stage.island;
  const bool first_part = work.report.parts++ == 0;
  work.report.position_error += part.position_error;
  if (stage.has_joints) {
    if (part.mean != Mean::kOfStages) {  // force × mean velocity: the change of energy
      stage.joints.startAccount();
      stage.joints.account(part.mean == Mean::kOfSteps ? state.q.data() : nullptr, state.v.data(), stage.v.data(), part.length);
    }
    stage.joints.closeAccount(state);
    work.report.joints_converged &= stage.joints.converged();
  }
  remember(model, stage, part, taken_up, work.schemes.acceleration, state);
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model.trees[island.trees[n]];
    std::copy_n(stage.base.q.begin() + tree.q, tree.model->nq(), state.q.begin() + tree.q);
    std::copy_n(stage.v.begin() + tree.v, tree.model->nv(), state.v.begin() + tree.v);
  }
  moveOn(model, island, stage.v, part.g, state.q);
  bookPart(model, stage, part, first_part, state, work.books);
}

}  // namespace haptic::stepping
