#include "haptic_core/stepping/step_books.h"

#include <algorithm>
#include <numeric>

namespace haptic::stepping {
namespace {

/// A wrench or twist at P in P's axes, about W's origin in W's axes, and back. Means are taken about one point: the patch moves within a
/// step, and one place's moment is none of the other's.
template <class Screw>
Screw aboutOrigin(const Screw& of_P, const Pose& X_WP) noexcept {
  return of_P.rotated(X_WP.R).shifted(-X_WP.p);
}
template <class Screw>
Screw inPatch(const Screw& of_W, const Pose& X_WP) noexcept {
  return of_W.shifted(X_WP.p).rotated(X_WP.R.transpose());
}

/// Takes the wrenches of the island's couplings over the part to their hands.
void bookCouplings(const Model& model, const ImplicitStage& stage, const SolvedPart& part, State& state, StepBooks& books) noexcept {
  const Island& island = stage.island;
  const StageWrenches &first = books.first, &last = books.last;
  const double w = part.before(), h = part.length;
  for (std::size_t p = 0; p < stage.forces.couplings.size(); ++p) {
    const int link = stage.forces.couplings[p].link;
    const int tree = link >= 0 ? model.links[link].articulation : -1;
    if (tree < 0 || !std::binary_search(island.trees, island.trees + island.tree_count, tree)) continue;
    PointerState& pointer = state.pointers[p];
    const bool stages = part.mean == Mean::kOfStages;
    pointer.pull_W = (stages ? first.coupling[p] : pointer.pull_W) * w + last.coupling[p] * (1 - w);
    pointer.pulled_W = (stages ? first.V_coupled[p] : pointer.pulled_W) * w + last.V_coupled[p] * (1 - w);
    books.coupling_impulse[p] += pointer.pull_W * h;
    books.coupling_work[p] += h * power(pointer.pull_W, pointer.pulled_W);
  }
}

/// Work of the force elements: by the mean of their powers at both ends, or of both stages.
void bookForces(const ImplicitStage& stage, const SolvedPart& part, State& state, StepBooks& books) noexcept {
  if (!stage.forces.any) return;
  const bool stages = part.mean == Mean::kOfStages;
  const double w = stages ? part.before() : part.mean == Mean::kOfSteps ? 0.5 : 0, h = part.length;
  const ForcePower &now = books.last.forces, &before = stages ? books.first.forces : books.forces_before;
  state.energy.damping += h * (w * before.taken + (1 - w) * now.taken);
  state.energy.external += h * (w * before.supplied + (1 - w) * now.supplied);
  books.forces_before = now;
}

/// Impulses and energies of the pairs, and their friction at the part's end. Work is the mean wrench times the way of this part.
void bookPairs(const WorldSettings& settings, const ImplicitStage& stage, const SolvedPart& part, bool first_part, State& state,
               StepBooks& books) noexcept {
  const Island& island = stage.island;
  const double w = part.before(), h = part.length;
  int next = 0;
  for (int n = 0; n < island.pair_count; ++n) {
    const int i = island.pairs[n];
    ActivePair& pair = state.pairs[i];
    FrictionMemory& memory = pair.friction;
    const FrictionMemory before = memory;
    const bool now = next < stage.contacts.all().size() && stage.contacts.all()[next].pair == i;
    const bool pressed = now || !books.last.pair[i].done.vector().isZero(0) || part.mean == Mean::kOfStages;
    const ContactMeans& earlier = part.mean == Mean::kOfStages ? books.first.pair[i] : pair.means;
    pair.means = pressed ? books.last.pair[i].mixed(1 - w, earlier) : ContactMeans{};
    const ContactMeans& means = pair.means;
    books.impulse[i] += means.done * h;
    memory = FrictionMemory{};
    if (now) {
      memory = stage.contacts.all()[next].force.memory;
      memory.elastic_energy = stage.contacts.all()[next++].elastic;
    }
    // What begins in a part of a step has its impact up to the end of the next step, even if it parts before.
    memory.began = std::max(memory.began, !first_part ? before.began : before.began == 1 ? kStillBegins : 0.0);
    const Twist& V_led = books.V_led[i];
    if (settings.energy_ledger) state.energy.external -= h * power(means.done, V_led);
    const Pose& X_WP = books.place[i];
    const ContactPower work = contactPower(inPatch(means.F, X_WP), inPatch(means.elastic, X_WP), inPatch(means.V + V_led, X_WP)) * h;
    const double beyond = work.elastic + before.elastic_energy - memory.elastic_energy;
    state.energy.bookPressure(work.damping, beyond, before, memory, pair.buried);
    const double friction = work.friction + before.energy - memory.energy;
    (memory.sliding != 0 ? state.energy.friction : state.energy.damping) += now || before.touching != 0 ? friction : 0;
    books.given -= std::min(0.0, work.damping) + std::min(0.0, friction);
  }
}

}  // namespace

StageWrenches::StageWrenches(const Model& model)
    : pair(model.pair_capacity), coupling(model.pointers.size()), V_coupled(model.pointers.size()) {}

StepBooks::StepBooks(const Model& model)
    : impulse(model.pair_capacity), place(model.pair_capacity), V_led(model.pair_capacity), event(model.pair_capacity),
      coupling_impulse(model.pointers.size()), coupling_work(model.pointers.size()), first(model), last(model) {}

void openBooks(const std::vector<int>& pairs, StepBooks& books) noexcept {
  for (const int i : pairs) books.event[i] = 1, books.impulse[i] = Wrench{};
  std::fill(books.coupling_work.begin(), books.coupling_work.end(), 0.0);
  std::fill(books.coupling_impulse.begin(), books.coupling_impulse.end(), Wrench{});
}

void gather(const ImplicitStage& stage, StageWrenches& found, StepBooks& books) noexcept {
  const Island& island = stage.island;
  for (int i = 0; i < island.pair_count; ++i) found.pair[island.pairs[i]] = ContactMeans{};
  const auto add = [&](const auto& pressed) {  // the patch that comes last is the pair's place
    books.place[pressed.pair] = pressed.X_WP;
    found.pair[pressed.pair].done += aboutOrigin(pressed.done_P, pressed.X_WP);
    books.V_led[pressed.pair] = aboutOrigin(pressed.V_led_P, pressed.X_WP);
  };
  for (const Brush& b : stage.contacts.brushes()) add(b);
  for (const ImplicitContact& c : stage.contacts.all()) {
    add(c);
    ContactMeans& means = found.pair[c.pair];
    means.F = aboutOrigin(c.force.F_BP_P, c.X_WP);
    means.elastic = aboutOrigin(c.force.elastic(), c.X_WP);
    means.V = aboutOrigin(c.V_P, c.X_WP);
  }
  for (std::size_t p = 0; p < stage.forces.couplings.size(); ++p) {
    found.coupling[p] = stage.forces.couplings[p].F_W;
    found.V_coupled[p] = stage.forces.couplings[p].V_WP;
  }
  found.forces = stage.forces.power;
}

void bookPart(const Model& model, const ImplicitStage& stage, const SolvedPart& part, bool first_part, State& state,
              StepBooks& books) noexcept {
  gather(stage, books.last, books);
  if (model.settings.energy_ledger) bookForces(stage, part, state, books);
  bookPairs(model.settings, stage, part, first_part, state, books);
  bookCouplings(model, stage, part, state, books);
}

void bookStanding(const Model& model, const ImplicitStage& stage, double h, State& state, StepBooks& books) noexcept {
  gather(stage, books.last, books);
  const Island& island = stage.island;
  for (int n = 0; n < island.pair_count; ++n) {
    const int i = island.pairs[n];
    ContactMeans& means = state.pairs[i].means;
    means = books.last.pair[i];
    means.V = Twist{};
    books.impulse[i] = means.done * h;
    if (model.settings.energy_ledger) state.energy.external -= h * power(means.done, books.V_led[i]);
  }
  bookCouplings(model, stage, {h, h, Mean::kOfEnd, 0}, state, books);
}

double sumOf(const std::vector<double>& values) noexcept { return std::accumulate(values.begin(), values.end(), 0.0); }

}  // namespace haptic::stepping
