#include "haptic_core/stepping/implicit_step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "haptic_core/stepping/standing_islands.h"

namespace haptic {
namespace {

constexpr double kGamma = 1 - M_SQRT1_2;  ///< of SDIRK2
constexpr double kNext = (1 - kGamma) / kGamma;

/// Error of position over s² times the change of acceleration: from the last step's end to this one's; between two stages.
constexpr double kErrorBdf2 = 2.0 / 9, kErrorSdirk2 = 0.0404;
/// The budget: evaluations of a pair in a step, and bounds of those of its island; three keep the energy of a step that did not
/// converge, three are implicit Euler's at least.
constexpr int kPairEvaluations = 128, kLeastEvaluations = 10, kMostEvaluations = 64, kKeepingEnergy = 3, kEulerPasses = 3,
              kMostPasses = 7;
/// Sub-steps are no shorter than a step over this; attempts of a step at them, instants of friction included.
constexpr int kMostParts = 8, kMostAttempts = 24;
/// Halving goes on while the error falls by this factor at least: to a quarter where the motion is resolved.
constexpr double kHelps = 0.4;
constexpr double kNone = std::numeric_limits<double>::infinity();  ///< contacts change, or a stage did not converge
/// Passes of a stage of SDIRK2: smooth motion converges in two.
constexpr int kSmoothPasses = 2;
/// Touching pairs of an island in which the instants of friction are located.
constexpr int kFewContacts = 4;
/// An island below this speed, over what gravity adds in a step times the accuracy, settles: Euler's costs half, and it damps the rocking
/// that SDIRK2 and Hunt-Crossley leave for seconds. Bodies that fall, swing, slide off or turn back are as slow as that for a few
/// steps, so the order stays 2. Bodies that only stick can but rock. Without the accuracy in it, a cube that comes to rest errs by 2.5 um
/// whatever is asked for (`accuracy.order` .06).
constexpr double kSettles = 33, kSettlesStuck = 167;
/// A patch that grows or shrinks by more than this factor within an attempt is not smooth: second order there makes energy.
constexpr double kGrowth = 2;
/// Way in a step below which a joint stands (dynamics/joint_solver.cpp) [m]: of second order it would bounce between limit and rounding.
constexpr double kStands = 1e-12;
/// BDF2 takes up from a step of at least 1/kMostRatio of its own length: it is stable up to 1 + √2 for steps of any sequence.
constexpr double kMostRatio = 2;
/// Share of the step below which nothing is left of it.
constexpr double kRest = 1e-9;

bool sticksAtAll(const FrictionMemory& m) { return m.touching != 0 && m.sliding == 0; }

double losses(const EnergySums& sums) { return sums.damping + sums.friction; }

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// Slow enough to come to rest, see kSettles. `slow`: what gravity adds in a step, or joints that stand make, times the accuracy [m/s].
bool settles(const Island& island, const State& state, double speed, double slow) {
  bool touches = false, slides = false;
  for (int i = 0; i < island.pair_count; ++i) {
    const FrictionMemory& friction = state.pairs[island.pairs[i]].friction;
    touches |= friction.touching != 0;
    slides |= friction.touching != 0 && friction.sliding != 0;
  }
  return speed <= (touches && !slides ? kSettlesStuck : kSettles) * slow;
}

/// Whether friction may jump between two limits, in an island small enough to look for the instants.
bool changesLimit(const Model& model, const Island& island, const State& state) {
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

/// Evaluations of the island's geometry in a step.
int budgetOf(const Island& island, const State& state) {
  int touching = 0;
  for (int i = 0; i < island.pair_count; ++i) touching += state.pairs[island.pairs[i]].friction.touching != 0;
  return std::clamp(kPairEvaluations / std::max(1, touching), kLeastEvaluations, kMostEvaluations);
}

}  // namespace

ImplicitStep::ImplicitStep(const Model& model) : model_(model), settings_(model.settings), stage_(model) {
  coupling_work_.resize(model.pointers.size());
  first_power_.resize(model.pointers.size());
  coupling_impulse_.resize(model.pointers.size());
  first_coupling_.resize(model.pointers.size());
  for (auto* wrenches : {&impulse_, &first_, &done_}) wrenches->resize(model.pair_capacity);
  place_.resize(model.pair_capacity);
  hands_power_.resize(model.pair_capacity);
  cache_.resize(model.pair_capacity);
  event_.resize(model.pair_capacity);
  violation_.resize(model.pair_capacity);
  acceleration_.resize(model.nv);
  change_.resize(model.nv);
  kick_.resize(model.nv);
}

void ImplicitStep::begin(State& state, const std::vector<int>& trees, const HandWork& hands, Seams& seams, double h) noexcept {
  state_ = &state;
  stage_.begin(state, trees, hands, seams, h);
  std::fill(event_.begin(), event_.begin() + state.pair_count, 1.0);
  std::fill(impulse_.begin(), impulse_.begin() + state.pair_count, Wrench{});
  std::fill(coupling_work_.begin(), coupling_work_.end(), 0.0);
  std::fill(coupling_impulse_.begin(), coupling_impulse_.end(), Wrench{});
}

const ImplicitReport& ImplicitStep::advance(const Island& island, double h, ImplicitOrder order) noexcept {
  const int iterations = stage_.iterations(), factorisations = stage_.factorisations();
  report_ = ImplicitReport{};
  stage_.select(island);
  length_ = left_ = h;
  order_ = order;
  force_power_before_ = stage_.forcePower();
  evaluations_before_ = stage_.evaluations;
  budget_ = budgetOf(island, *state_);
  locates_ = order != ImplicitOrder::kFirst && changesLimit(model_, island, *state_);
  const double slow = settings_.accuracy * std::max(h * settings_.gravity.norm(), kStands / h);
  setBase();
  const bool rests = stage_.speed(state_->v) <= restBound(h);  // then it is asked first whether it stands, and nothing slips
  const bool second_order =
      order != ImplicitOrder::kFirst && !rests && (locates_ || !settles(island, *state_, stage_.speed(state_->v), slow));
  const auto passes = [this] { return std::max(1, budget_ - kKeepingEnergy - used()); };
  const bool jumps_on = second_order && lastStep() < 0 && euler(h, passes(), true);
  if (second_order && !jumps_on) subSteps();
  report_.fell_back = jumps_on || (second_order && left_ > 0);
  if (!jumps_on && left_ > 0) euler(left_, passes(), false);
  report_.iterations = stage_.iterations() - iterations;
  report_.evaluations = used();
  report_.budget_used = static_cast<double>(used()) / budget_;
  report_.factorisations = stage_.factorisations() - factorisations;
  report_.residual = stage_.error;
  report_.wrench_error = stage_.wrench_error;
  return report_;
}

/// `done` [s] of the step are over.
void ImplicitStep::goOn(double done) noexcept {
  left_ -= done;
  if (left_ <= kRest * length_) left_ = 0;
}

/// Goes on by second order while error and budget allow.
void ImplicitStep::subSteps() noexcept {
  double s = length_, error = kNone;
  for (int attempt = 0; attempt < kMostAttempts && left_ > 0; ++attempt) {
    s = std::min(s, left_);
    const double done = secondOrder(s);
    if (done >= 0) {
      goOn(done);
      error = kNone;
      continue;
    }
    if (error_ < kHelps * error && s > 1.001 * length_ / kMostParts) {
      error = error_;
      s *= 0.5;
      continue;
    }
    // Impacts (`kNone`) are implicit Euler's. What halving does not help is the attempt's that errs least.
    if (!(attempt_.length > 0) || !(attempt_.error < attempt_.euler_error)) break;
    commit(attempt_);
    goOn(attempt_.length);
    error = kNone;
  }
}

/// Whether an attempt of so many evaluations, over and over with steps of length s to the end, leaves implicit Euler its own.
bool ImplicitStep::affords(double evaluations, double s) const noexcept {
  return used() + evaluations * left_ / s <= budget_ - kKeepingEnergy - kEulerPasses;
}

void ImplicitStep::setBase() noexcept {
  const Island& island = stage_.island();
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island.trees[n]];
    std::copy_n(state_->q.begin() + tree.q, tree.model->nq(), stage_.q_base.begin() + tree.q);
    std::copy_n(state_->v.begin() + tree.v, tree.model->nv(), stage_.v_base.begin() + tree.v);
    std::copy_n(state_->v.begin() + tree.v, tree.model->nv(), stage_.v.begin() + tree.v);
  }
  for (int i = 0; i < island.pair_count; ++i) {
    stage_.memory_base[island.pairs[i]] = state_->pairs[island.pairs[i]].friction;
  }
}

/// Implicit Euler over the last h of the step. `if_jumps`: contacts jumped in the last step, and in a heap they mostly go on to; where
/// the first evaluation finds those of the start none the less, nothing is done, and the answer is no: second order is worth a try.
bool ImplicitStep::euler(double h, int passes, bool if_jumps) noexcept {
  const Island& island = stage_.island();
  setBase();
  for (int i = 0; i < island.pair_count; ++i) {
    stage_.yielding[island.pairs[i]] = Yielding::kKeepsLimit;
    cache_[island.pairs[i]] = state_->pairs[island.pairs[i]].cache;
  }
  bool smooth = false;
  stage_.run = h;
  const bool converged = stage_.solve(h, 0, passes, [&] { return !(smooth = if_jumps && sameContacts()); });
  if (smooth) return false;
  report_.converged = converged;
  if (report_.converged && h == length_ && staysAtRest(h)) {
    stand(h);
    return true;
  }
  const double lost = report_.converged ? 0 : stage_.keepEnergy(h);
  const double booked = losses(state_->energy), supplied = state_->energy.external + sum(coupling_work_);
  if (stage_.hasJoints()) {
    stage_.joints().startAccount();
    stage_.joints().account(stage_.v_base.data(), stage_.v.data(), h);  // force × mean velocity: the change of energy
  }
  accelerations(h);
  commit(h, h, Mean::kOfEnd, !report_.converged || !sameContacts() ? -h : errs(kErrorBdf2, h) ? 0 : h);
  if (report_.converged) return true;
  // Forces out of balance are not what slowed the bodies: of their power no more is a loss than was lost.
  const double available = std::max(0.0, lost + state_->energy.external + sum(coupling_work_) - supplied);
  state_->energy.damping -= std::max(0.0, losses(state_->energy) - booked - available);
  return true;
}

/// Speed below which the island is at rest [m/s].
double ImplicitStep::restBound(double h) const noexcept {
  const bool calm = stepping::isCalm(stage_.island(), *state_) && stepping::standsAlone(model_, stage_.island(), *state_);
  return std::max(stepping::kOfRounding * stage_.finest(h), calm ? stepping::restingSpeed(settings_, h) : 0.0);
}

/// Whether the island touches something or a force element holds it, and is at rest before and after.
bool ImplicitStep::staysAtRest(double h) const noexcept {
  const double most = restBound(h);
  if ((stage_.contacts().empty() && !stage_.hasForces()) || stage_.hasJoints()) return false;
  if (stage_.speed(stage_.v) > most || stage_.speed(stage_.v_base) > most || !sameContacts()) return false;
  const auto runs = [](const ImplicitContact& c) { return !c.force.belt.isZero(0); };  // under what stands it works on
  if (std::any_of(stage_.contacts().begin(), stage_.contacts().end(), runs)) return false;
  const Island& island = stage_.island();
  return std::all_of(island.pairs, island.pairs + island.pair_count, [this](int i) {
    return state_->pairs[i].friction.began == 0 && !state_->pairs[i].buried;
  });
}

/// The state stays as it is, at rest. The supply of hands that press it from both sides is in its springs at its next motion.
void ImplicitStep::stand(double h) noexcept {
  const Island& island = stage_.island();
  ++report_.parts;
  if (settings_.energy_ledger) state_->energy.external += h * stage_.handsPower();
  report_.rests = report_.stands = true;
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island.trees[n]];
    double* v = state_->v.data() + tree.v;
    report_.stands &= std::all_of(v, v + tree.model->nv(), [](double x) { return x == 0 && !std::signbit(x); });
    for (double* x : {v, &state_->a_end[tree.v], &state_->a_mean[tree.v], &state_->v_mean[tree.v]}) std::fill_n(x, tree.model->nv(), 0.0);
    state_->last_step[island.trees[n]] = h;
    state_->calm[island.trees[n]] = stepping::kCalmSteps;
  }
  if (!report_.stands) report_.position_error += h * stage_.speed(stage_.v_base);  // of the motion that is left out, once
  gatherDone();
  for (int i = 0; i < island.pair_count; ++i) {
    const int pair = island.pairs[i];
    impulse_[pair] = done_[pair] * h;
    state_->pairs[pair].cache = cache_[pair];
  }
  pushHands(h, 0, false);
}

/// Takes the wrenches of the island's couplings over h to their hands. `w`: weight of their power in the first stage, or at the start.
void ImplicitStep::pushHands(double h, double w, bool two_stages) noexcept {
  const Island& island = stage_.island();
  for (std::size_t p = 0; p < stage_.couplings.size(); ++p) {
    const int link = stage_.couplings[p].link;
    const int tree = link >= 0 ? model_.links[link].articulation : -1;
    if (tree < 0 || !std::binary_search(island.trees, island.trees + island.tree_count, tree)) continue;
    const Wrench& F_W = stage_.couplings[p].F_W;
    double& power = state_->pointers[p].power;
    coupling_impulse_[p] += (two_stages ? first_coupling_[p] * w + F_W * (1 - w) : F_W) * h;
    coupling_work_[p] += h * (w * (two_stages ? first_power_[p] : power) + (1 - w) * stage_.couplings[p].power);
    power = stage_.couplings[p].power;
  }
}

/// BDF2 or SDIRK2 over s, or up to where friction changes; the time that was done, < 0 where neither is good enough.
double ImplicitStep::secondOrder(double s) noexcept {
  const double last = lastStep();
  attempt_ = {};
  if (order_ == ImplicitOrder::kSecondMultistep && last > 0 && s <= kMostRatio * last && affords(kSmoothPasses, s)) {
    const Smooth found = bdf2(s, last);
    if (found == Smooth::kYes) return s;
    error_ *= kErrorSdirk2 / kErrorBdf2;  // that of SDIRK2, foreseen
    if (found == Smooth::kNo && error_ > 1) return -1;
    attempt_ = {};
  }
  error_ = kNone;
  if (!affords(2 * kSmoothPasses, s)) return -1;
  setModes();
  if (!sdirk2(s, left_ - s)) return -1;
  bool changes = false;
  for (const ImplicitContact& c : stage_.contacts()) {
    if (!locates_) break;
    Yielding& mode = stage_.yielding[c.pair];
    const bool stops = mode == Yielding::kKeepsLimit && c.force.memory.sliding == 0;
    if (stops) mode = Yielding::kDragged;
    changes |= stops || violation(c) > 0;
  }
  if (changes) return locate(s);
  if (keepSdirk2(s)) return s;
  attempt_ = attemptOf(kGamma * s, s, Mean::kOfStages);
  return -1;
}

/// Commits what `sdirk2` solved over s, unless it errs too much.
bool ImplicitStep::keepSdirk2(double s) noexcept {
  if (errs(kErrorSdirk2, s)) return false;
  commit(kGamma * s, s, Mean::kOfStages, s);
  return true;
}

/// BDF2 over s; nothing is committed where the error is too large, or friction changes in it.
ImplicitStep::Smooth ImplicitStep::bdf2(double s, double last) noexcept {
  const Island& island = stage_.island();
  const double w = s / last, g = (1 + w) / (1 + 2 * w) * s, rest = s - g;
  setModes();
  setBase();
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island.trees[n]];
    integratePositions(*tree.model, stage_.q_base.data() + tree.q, state_->v_mean.data() + tree.v, rest);
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) {
      stage_.v_base[i] += rest * state_->a_mean[i];
      stage_.v[i] = stage_.v_base[i] + g * state_->a_end[i];
    }
  }
  error_ = kNone;
  stage_.run = s;
  if (!solveSmooth(g, left_ - s)) return Smooth::kNo;
  for (const ImplicitContact& c : stage_.contacts()) {
    if (!locates_) break;
    const bool stops = stage_.yielding[c.pair] == Yielding::kKeepsLimit && c.force.memory.sliding == 0;
    if (stops || violation(c) > 0) return Smooth::kFrictionChanges;
  }
  accelerations(g);
  const bool errs_too_much = errs(kErrorBdf2, s);
  attempt_ = attemptOf(g, s, Mean::kOfEnds);
  if (errs_too_much) return Smooth::kNo;
  commit(attempt_);
  return Smooth::kYes;
}

/// That the stage holds, as `errs` has judged it. Implicit Euler errs by s/2 |Δv|.
ImplicitStep::Attempt ImplicitStep::attemptOf(double g, double s, Mean mean) noexcept {
  return {g, s, mean, position_error_, 0.5 * s * speedGained()};
}

void ImplicitStep::commit(const Attempt& attempt) noexcept {
  if (stage_.hasJoints() && attempt.mean == Mean::kOfEnds) {
    stage_.joints().startAccount();
    stage_.joints().account(state_->v.data(), stage_.v.data(), attempt.length);
  }
  commit(attempt.g, attempt.length, attempt.mean, attempt.length);
}

void ImplicitStep::setModes() noexcept {
  const Island& island = stage_.island();
  for (int i = 0; i < island.pair_count; ++i) {
    const FrictionMemory& memory = state_->pairs[island.pairs[i]].friction;
    stage_.yielding[island.pairs[i]] = locates_ && sticksAtAll(memory) ? Yielding::kNever : Yielding::kKeepsLimit;
  }
}

/// Of the island; 0: there is none, or trees differ; negative: something jumped in it.
double ImplicitStep::lastStep() const noexcept {
  const Island& island = stage_.island();
  const double first = state_->last_step[island.trees[0]];
  double least = first;
  bool same = true;
  for (int n = 1; n < island.tree_count; ++n) {
    const double last = state_->last_step[island.trees[n]];
    same &= last == first;
    least = std::min(least, last);
  }
  return same || least < 0 ? least : 0;
}

/// Into `change_`: acceleration over a solve of length g less that at the end of the last step.
void ImplicitStep::accelerations(double g) noexcept {
  const Island& island = stage_.island();
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island.trees[n]];
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) {
      change_[i] = (stage_.v[i] - stage_.v_base[i]) / g - state_->a_end[i];
    }
  }
}

/// Largest change of speed of a tree since the state [m/s].
double ImplicitStep::speedGained() noexcept {
  const Island& island = stage_.island();
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island.trees[n]];
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) kick_[i] = stage_.v[i] - state_->v[i];
  }
  return stage_.speed(kick_);
}

/// Whether `share` s² |change_|, the error of position over s, is more than it may be. Leaves the ratio of the two in `error_`.
bool ImplicitStep::errs(double share, double s) noexcept {
  const double may = settings_.accuracy * (speedGained() * length_ / s + length_ * settings_.gravity.norm());
  const double error = share * s * stage_.speed(change_);
  error_ = error > 0 ? error / may : 0;
  position_error_ = s * error;
  return error > may;
}

/// `taken_up`: as `State::last_step`.
void ImplicitStep::remember(double g, double h, Mean mean, double taken_up) noexcept {
  const Island& island = stage_.island();
  const double share = g / h;  // of the step at the velocity of its end
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island.trees[n]];
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) {
      double before = state_->v_mean[i];  // velocity at which the rest went
      if (mean == Mean::kOfStages) before = stage_.v_base[i] + (2 * g - h) * acceleration_[i];
      state_->a_end[i] = (stage_.v[i] - stage_.v_base[i]) / g;
      state_->a_mean[i] = (stage_.v[i] - state_->v[i]) / h;
      state_->v_mean[i] = mean == Mean::kOfEnd ? stage_.v[i] : share * stage_.v[i] + (1 - share) * before;
    }
    state_->last_step[island.trees[n]] = taken_up;
  }
}

/// Solves both stages, their change of acceleration in `change_`; false: contacts change, or one does not converge.
bool ImplicitStep::sdirk2(double h, double left) noexcept {
  const Island& island = stage_.island();
  const double g = kGamma * h, rest = (1 - kGamma) * h;
  setBase();
  stage_.run = g;
  if (!solveSmooth(g, left + rest)) return false;
  if (stage_.hasJoints()) {
    stage_.joints().startAccount();
    stage_.joints().account(stage_.v.data(), stage_.v.data(), rest);
  }
  for (const ImplicitContact& c : stage_.contacts()) {
    const FrictionMemory &s0 = state_->pairs[c.pair].friction, &s1 = c.force.memory;
    FrictionMemory& base = stage_.memory_base[c.pair];
    base = s1;
    const Vector3 slip_M = c.force.inNewAxes(s0.slip_M);
    base.slip_M = slip_M + kNext * (s1.slip_M - slip_M);
    base.twist = s0.twist + kNext * (s1.twist - s0.twist);
    // Poses say how far the bodies are by the second stage; what yielded goes on from the first.
    const Vector3 more = (1 - kNext) * c.force.yielded;
    base.anchor.slip_A += c.volume.X_AP.R.leftCols<2>() * more.head<2>();
    base.anchor.twist += more[2];
    base.area = std::max(0.0, s0.area + kNext * (s1.area - s0.area));
    base.torsion = std::max(0.0, s0.torsion + kNext * (s1.torsion - s0.torsion));
    base.rate_M = c.force.inNewAxes(s0.rate_M);
    base.spin = s0.spin;
    base.sliding = s0.sliding;
  }
  first_hands_power_ = stage_.handsPower();
  first_force_power_ = stage_.forcePower();
  gatherDone();
  for (int i = 0; i < island.pair_count; ++i) first_[island.pairs[i]] = done_[island.pairs[i]];
  for (std::size_t i = 0; i < stage_.couplings.size(); ++i) {
    first_power_[i] = stage_.couplings[i].power;
    first_coupling_[i] = stage_.couplings[i].F_W;
  }
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island.trees[n]];
    integratePositions(*tree.model, stage_.q_base.data() + tree.q, stage_.v.data() + tree.v, rest);
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) {
      acceleration_[i] = (stage_.v[i] - stage_.v_base[i]) / g;
      stage_.v_base[i] += rest * acceleration_[i];
      stage_.v[i] = stage_.v_base[i] + g * acceleration_[i];
    }
  }
  stage_.run = rest;
  if (!solveSmooth(g, left)) return false;
  if (stage_.hasJoints()) stage_.joints().account(stage_.v.data(), stage_.v.data(), g);
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island.trees[n]];
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) {
      change_[i] = (stage_.v[i] - stage_.v_base[i]) / g - acceleration_[i];
    }
  }
  return true;
}

/// A stage whose contacts stay as they were at the start of the step. False as soon as they do not.
bool ImplicitStep::solveSmooth(double g, double left) noexcept {
  const int room = budget_ - kKeepingEnergy - kEulerPasses - used();
  if (room < 1) return false;
  const int passes = locates_ ? std::min(kMostPasses, room) : kSmoothPasses;
  return stage_.solve(g, left, passes, [this] { return !stage_.limited && sameContacts(); }) && !stage_.limited && sameContacts() &&
         (!stage_.hasJoints() || stage_.joints().isSmooth(state_->v.data()));
}

/// Whether the contacts of the last evaluation are those of the step's start, and their patches about as large: an edge
/// that becomes a face is an impact.
bool ImplicitStep::sameContacts() const noexcept {
  const Island& island = stage_.island();
  int next = 0;
  for (int i = 0; i < island.pair_count; ++i) {
    const bool now = next < stage_.contacts().size() && stage_.contacts()[next].pair == island.pairs[i];
    const ActivePair& before = state_->pairs[island.pairs[i]];
    if (now != (before.friction.touching != 0)) return false;
    if (!now) continue;
    const double area = stage_.contacts()[next++].volume.A0;
    if (area > kGrowth * before.friction.area || before.friction.area > kGrowth * area) return false;
  }
  return true;
}

/// Impulse of the last stage on each pair's B. Patches of the same pair add up.
void ImplicitStep::gatherDone() noexcept {
  const Island& island = stage_.island();
  for (int i = 0; i < island.pair_count; ++i) {
    done_[island.pairs[i]] = Wrench{};
    hands_power_[island.pairs[i]] = 0;
  }
  const auto add = [this](const auto& pressed) {
    done_[pressed.pair] += pressed.done_P.rotated(pressed.X_WP.R).shifted(-pressed.X_WP.p);
    hands_power_[pressed.pair] += pressed.hands_power;
    place_[pressed.pair] = pressed.X_WP;
  };
  for (const ImplicitContact& c : stage_.contacts()) add(c);
  for (const Brush& b : stage_.brushes()) add(b);
}

/// Puts the solution into the state: v, q = q_b ⊕ g v, friction; and the work done over h into the ledger's sums. (The
/// last Newton step was not evaluated: forces and friction are those of the evaluation before it.)
void ImplicitStep::commit(double g, double h, Mean mean, double taken_up) noexcept {
  const Island& island = stage_.island();
  const bool two_stages = mean == Mean::kOfStages;
  const bool first_part = report_.parts++ == 0;
  // Implicit Euler's error is that of a speed that was not there yet; the rest of a solve that did not converge counts in full.
  report_.position_error += mean == Mean::kOfEnd ? h * (0.5 * speedGained() + (report_.converged ? 0 : stage_.error)) : position_error_;
  remember(g, h, mean, taken_up);
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island.trees[n]];
    std::copy_n(stage_.q_base.begin() + tree.q, tree.model->nq(), state_->q.begin() + tree.q);
    integratePositions(*tree.model, state_->q.data() + tree.q, stage_.v.data() + tree.v, g);
    std::copy_n(stage_.v.begin() + tree.v, tree.model->nv(), state_->v.begin() + tree.v);
  }
  if (stage_.hasJoints()) {
    stage_.joints().closeAccount(*state_);
    report_.joints_converged &= stage_.joints().converged();
  }
  // Power is that of the end, and with this weight of the first stage, or of the start: memory_base holds either.
  const double w = two_stages ? 1 - kGamma : mean == Mean::kOfEnds ? 0.5 : 0;
  gatherDone();
  double hands_before = two_stages ? first_hands_power_ : 0;
  for (int i = 0; i < island.pair_count; ++i) {
    ActivePair& pair = state_->pairs[island.pairs[i]];
    if (!two_stages) hands_before += pair.hands_power;
    pair.hands_power = hands_power_[island.pairs[i]];
  }
  if (settings_.energy_ledger) state_->energy.external += h * (w * hands_before + (1 - w) * stage_.handsPower());
  if (settings_.energy_ledger && stage_.hasForces()) {
    const ForcePower &now = stage_.forcePower(), &before = two_stages ? first_force_power_ : force_power_before_;
    state_->energy.damping += h * (w * before.taken + (1 - w) * now.taken);
    state_->energy.external += h * (w * before.supplied + (1 - w) * now.supplied);
    force_power_before_ = now;
  }
  int next = 0;
  for (int i = 0; i < island.pair_count; ++i) {
    ActivePair& pair = state_->pairs[island.pairs[i]];
    FrictionMemory& memory = pair.friction;
    const FrictionMemory before = memory;
    const FrictionMemory& first = stage_.memory_base[island.pairs[i]];
    const bool now = next < stage_.contacts().size() && stage_.contacts()[next].pair == island.pairs[i];
    const Wrench& done = done_[island.pairs[i]];
    impulse_[island.pairs[i]] += (two_stages ? first_[island.pairs[i]] * w + done * (1 - w) : done) * h;
    memory = FrictionMemory{};
    if (now) {
      const ImplicitContact& c = stage_.contacts()[next];
      memory = c.force.memory;
      memory.elastic_energy = stage_.contacts()[next++].elastic;
    }
    // What begins in a part of a step has its impact up to the end of the next step, even if it parts before.
    memory.began = std::max(memory.began, !first_part ? before.began : before.began == 1 ? kStillBegins : 0.0);
    const auto work = [&](double p1, double p2) { return h * (w * p1 + (1 - w) * p2); };
    const double beyond = work(first.power.elastic, memory.power.elastic) + before.elastic_energy - memory.elastic_energy;
    state_->energy.bookPressure(work(first.power.damping, memory.power.damping), beyond, before, memory, pair.buried);
    const double friction = work(first.power.friction, memory.power.friction) + before.energy - memory.energy;
    (memory.sliding != 0 ? state_->energy.friction : state_->energy.damping) += now || before.touching != 0 ? friction : 0;
  }
  pushHands(h, w, two_stages);
}

}  // namespace haptic
