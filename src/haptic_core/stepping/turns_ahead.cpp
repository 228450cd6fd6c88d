#include "haptic_core/stepping/turns_ahead.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <numeric>
#include <utility>

#include "haptic_core/base/fields.h"
#include "haptic_core/stepping/turns.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {
namespace {

/// Pause of a thread that has nothing to solve. Shorter: it takes more of its core for nothing; longer: turns that are due a few
/// ticks later are solved by the step.
constexpr std::chrono::microseconds kLookEvery{50};
/// Turns that are given and not yet taken, and numbers of one. Fewer or smaller: a step solves more of them; more: 0.8 MB each.
constexpr int kTurns = 32;
constexpr std::size_t kMostNumbers = 50000;
constexpr int kMostTrees = 256, kMostContacts = 1024;

/// visit(numbers, count) of all that the island's turn reads or writes of its trees, then visit(pair) of its pairs.
template <class AnyState, class Numbers, class Pair>
void eachPart(const Model& model, const Island& island, AnyState& state, Numbers&& numbers, Pair&& pair) noexcept {
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model.trees[island.trees[n]];
    const auto t = static_cast<std::size_t>(island.trees[n]);
    const int nv = tree.model->nv();
    numbers(state.q.data() + tree.q, tree.model->nq());
    for (auto* values : {&state.v, &state.a_end, &state.a_mean, &state.v_mean}) numbers(values->data() + tree.v, nv);
    numbers(&state.last_step[t], 1);
    numbers(&state.calm[t], 1);
    numbers(&state.mode[t], 1);
  }
  for (int i = 0; i < island.pair_count; ++i) pair(state.pairs[static_cast<std::size_t>(island.pairs[i])]);
}

/// visit(number) of each of them.
template <class AnyState, class Visit>
void eachNumberOf(const Model& model, const Island& island, AnyState& state, Visit&& visit) noexcept {
  const auto numbers = [&](auto* first, int count) { std::for_each(first, first + count, visit); };
  eachPart(model, island, state, numbers, [&](auto& pair) { eachNumber(pair, visit); });
}

/// False: there is no room for all.
bool pack(const Model& model, const Island& island, const State& state, std::vector<double>& out) noexcept {
  out.clear();
  bool fits = true;
  eachNumberOf(model, island, state, [&](const auto& number) {
    fits &= out.size() < out.capacity();
    if (fits) out.push_back(asDouble(number));
  });
  return fits;
}

void unpack(const Model& model, const Island& island, const std::vector<double>& numbers, State& state) noexcept {
  const double* next = numbers.data();
  eachNumberOf(model, island, state, [&](auto& number) { setFromDouble(number, *next++); });
}

/// To the last bit.
bool equals(const Model& model, const Island& island, const State& state, const std::vector<double>& numbers) noexcept {
  const double *next = numbers.data(), *end = next + numbers.size();
  bool same = true;
  eachNumberOf(model, island, state, [&](const auto& number) {
    const double now = asDouble(number);
    same = same && next != end && std::memcmp(&now, next, sizeof now) == 0;
    ++next;
  });
  return same && next == end;
}

}  // namespace

void Turn::putInto(const Model& model, const Island& island, State& state) const noexcept { unpack(model, island, after, state); }

/// A world in which one island at a time has its turn: nobody pulls or holds anything in it.
struct TurnsAhead::Far {
  Far(const Model& model_now, const State& state_now) : model(model_now), work(model), state(state_now) {
    for (PointerState& pointer : state.pointers) pointer.targeted = false;
    state.wrench_count = state.pair_count = 0;
    std::fill(state.turn.begin(), state.turn.end(), 0);
    refreshHands(model, state, work.hands);
    std::fill(work.hands.held_by.begin(), work.hands.held_by.end(), -1);
    for (ImplicitCoupling& coupling : work.implicit->stage.forces.couplings) coupling.link = -1;
    placeAll(model, state, work.placement);
    report.contacts.reserve(model.pair_capacity);
    pairs.reserve(static_cast<std::size_t>(model.pair_capacity));
  }

  Model model;
  Work work;
  State state;
  Report report;
  std::vector<int> pairs;  ///< of the island: all there are
};

TurnsAhead::TurnsAhead(const Model& model, const State& state)
    : turns_(kTurns), turn_of_(model.trees.size(), -1), model_(model), far_(std::make_unique<Far>(model, state)) {
  const std::size_t most = std::min(kMostNumbers, state.packedCapacity());
  for (Turn& turn : turns_) {
    turn.trees.reserve(kMostTrees);
    turn.before.reserve(most);
    turn.after.reserve(most);
    turn.contacts.reserve(std::min(kMostContacts, model.pair_capacity));
  }
  thread_ = std::thread([this] { run(); });
}

TurnsAhead::~TurnsAhead() {
  stop_ = true;
  thread_.join();
}

void TurnsAhead::give(const Island& island, const State& state) noexcept {
  const int tree = island.trees[0];
  release(tree);
  if (island.pair_count == 0 || island.tree_count > kMostTrees) return;  // what flies costs less than handing it over
  const auto isFree = [](const Turn& turn) { return turn.stage.load(std::memory_order_acquire) == Turn::Stage::kFree; };
  const auto free = std::find_if(turns_.begin(), turns_.end(), isFree);
  if (free == turns_.end() || !pack(model_, island, state, free->before)) return;
  free->as_of = state.as_of[tree];
  free->due.store(state.turn[tree], std::memory_order_relaxed);
  free->trees.assign(island.trees, island.trees + island.tree_count);
  free->pairs = island.pair_count;
  turn_of_[tree] = static_cast<int>(free - turns_.begin());
  free->stage.store(Turn::Stage::kGiven, std::memory_order_release);
}

const Turn* TurnsAhead::take(const Island& island, bool goes_on, double most, const State& state) noexcept {
  for (int n = 1; n < island.tree_count; ++n) release(island.trees[n]);  // of islands that have become one
  int& slot = turn_of_[island.trees[0]];
  if (slot < 0) return nullptr;
  Turn& turn = turns_[slot];
  const bool same = goes_on && turn.stage.load(std::memory_order_acquire) == Turn::Stage::kSolved && turn.due == state.step &&
                    turn.as_of == state.as_of[island.trees[0]] && turn.units < most && turn.pairs == island.pair_count &&
                    std::equal(turn.trees.begin(), turn.trees.end(), island.trees, island.trees + island.tree_count) &&
                    equals(model_, island, state, turn.before);
  if (same) {
    ++taken_;
    slot = -1;
    turn.stage.store(Turn::Stage::kFree, std::memory_order_relaxed);  // this thread reads it before it gives anything
    return &turn;
  }
  ++missed_;
  release(island.trees[0]);
  return nullptr;
}

/// The slot is free at once, or once the thread has done with it.
void TurnsAhead::release(int tree) noexcept {
  const int slot = std::exchange(turn_of_[tree], -1);
  if (slot < 0) return;
  Turn& turn = turns_[slot];
  Turn::Stage stage = Turn::Stage::kGiven;
  if (turn.stage.compare_exchange_strong(stage, Turn::Stage::kFree, std::memory_order_acq_rel)) return;
  stage = Turn::Stage::kSolving;
  if (turn.stage.compare_exchange_strong(stage, Turn::Stage::kLeft, std::memory_order_acq_rel)) return;
  turn.stage.store(Turn::Stage::kFree, std::memory_order_relaxed);
}

void TurnsAhead::forget() noexcept {
  for (std::size_t t = 0; t < turn_of_.size(); ++t) release(static_cast<int>(t));
}

void TurnsAhead::tune(const WorldTuning& tuning) {
  const std::lock_guard<std::mutex> lock(solving_);
  far_->model.tune(tuning);
}

void TurnsAhead::finish() const {
  const auto busy = [](const Turn& turn) {
    const Turn::Stage stage = turn.stage.load(std::memory_order_acquire);
    return stage == Turn::Stage::kGiven || stage == Turn::Stage::kSolving || stage == Turn::Stage::kLeft;
  };
  while (std::any_of(turns_.begin(), turns_.end(), busy)) std::this_thread::sleep_for(kLookEvery);
}

void TurnsAhead::run() noexcept {
  while (!stop_) {
    std::unique_lock<std::mutex> lock(solving_);
    Turn* turn = next();
    if (turn) solve(*turn);
    lock.unlock();
    if (!turn) std::this_thread::sleep_for(kLookEvery);
  }
}

/// The turn that is due first, which is this thread's now; null: there is none.
Turn* TurnsAhead::next() noexcept {
  Turn* first = nullptr;
  for (Turn& turn : turns_) {
    if (turn.stage.load(std::memory_order_acquire) == Turn::Stage::kGiven && (!first || turn.due < first->due)) first = &turn;
  }
  Turn::Stage given = Turn::Stage::kGiven;
  return first && first->stage.compare_exchange_strong(given, Turn::Stage::kSolving, std::memory_order_acq_rel) ? first : nullptr;
}

void TurnsAhead::solve(Turn& turn) noexcept {
  const Model& model = far_->model;
  State& state = far_->state;
  Work& work = far_->work;
  Report& report = far_->report;
  state.step = turn.due;
  state.pair_count = turn.pairs;
  const std::uint64_t late = turn.due - turn.as_of;
  for (const int t : turn.trees) state.as_of[t] = turn.as_of, state.turn[t] = turn.due;
  std::vector<int>& pairs = far_->pairs;
  pairs.resize(static_cast<std::size_t>(turn.pairs));
  std::iota(pairs.begin(), pairs.end(), 0);
  const Island given{turn.trees.data(), static_cast<int>(turn.trees.size()), pairs.data(), turn.pairs};
  unpack(model, given, turn.before, state);
  for (const int t : turn.trees) placeTree(model.trees[t], state, work.placement);
  work.counted.begin(0);
  work.position_error = 0;
  report.step = StepReport{};
  report.contacts.clear();
  state.energy = EnergySums{};
  const double before = work.counted.done, seconds = static_cast<double>(late) * model.settings.step;
  beginIslands(model, state, turn.trees, work.hands, work.contacts.seams, seconds, *work.implicit);
  takeTurn(model, given, seconds, true, work.counted.left(), state, work, report);
  pack(model, given, state, turn.after);
  turn.waits = state.turn[turn.trees.front()] != 0;
  for (const int t : turn.trees) state.turn[t] = 0;
  turn.contacts.clear();
  for (const ContactReport& contact : report.contacts) turn.contacts.push_back(contact);
  turn.report = report.step;
  turn.energy = state.energy;
  turn.units = work.counted.done - before;
  turn.position_error = work.position_error;
  Turn::Stage solving = Turn::Stage::kSolving;
  if (!turn.stage.compare_exchange_strong(solving, Turn::Stage::kSolved, std::memory_order_acq_rel)) {
    turn.stage.store(Turn::Stage::kFree, std::memory_order_release);
  }
}

}  // namespace haptic::stepping
