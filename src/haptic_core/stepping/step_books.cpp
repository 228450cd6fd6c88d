#include "haptic_core/stepping/step_books.h"

#include <algorithm>
#include <numeric>

namespace haptic::stepping {
namespace {

/// Of the first of the two instants.
double weightBefore(Mean mean) { return mean == Mean::kOfStages ? 1 - kGamma : mean == Mean::kOfEnds ? 0.5 : 0; }

/// Takes the wrenches of the island's couplings over the part to their hands.
void bookCouplings(const Model& model, const ImplicitStage& stage, const SolvedPart& part, State& state, StepBooks& books) noexcept {
  const Island& island = stage.island;
  const StageWrenches &first = books.first, &last = books.last;
  const bool two_stages = part.mean == Mean::kOfStages;
  const double w = weightBefore(part.mean), h = part.length;
  for (std::size_t p = 0; p < stage.forces.couplings.size(); ++p) {
    const int link = stage.forces.couplings[p].link;
    const int tree = link >= 0 ? model.links[link].articulation : -1;
    if (tree < 0 || !std::binary_search(island.trees, island.trees + island.tree_count, tree)) continue;
    double& power = state.pointers[p].power;
    books.coupling_impulse[p] += (two_stages ? first.coupling[p] * w + last.coupling[p] * (1 - w) : last.coupling[p]) * h;
    books.coupling_work[p] += h * (w * (two_stages ? first.coupling_power[p] : power) + (1 - w) * last.coupling_power[p]);
    power = last.coupling_power[p];
  }
}

/// Work of hands that lead a link, and of the force elements.
void bookSupply(const WorldSettings& settings, const ImplicitStage& stage, const SolvedPart& part, State& state,
                StepBooks& books) noexcept {
  const Island& island = stage.island;
  const bool two_stages = part.mean == Mean::kOfStages;
  const double w = weightBefore(part.mean), h = part.length;
  double hands_before = two_stages ? books.first.all_hands_power : 0;
  for (int i = 0; i < island.pair_count; ++i) {
    ActivePair& pair = state.pairs[island.pairs[i]];
    if (!two_stages) hands_before += pair.hands_power;
    pair.hands_power = books.last.hands_power[island.pairs[i]];
  }
  if (!settings.energy_ledger) return;
  state.energy.external += h * (w * hands_before + (1 - w) * books.last.all_hands_power);
  if (!stage.forces.any) return;
  const ForcePower &now = books.last.forces, &before = two_stages ? books.first.forces : books.forces_before;
  state.energy.damping += h * (w * before.taken + (1 - w) * now.taken);
  state.energy.external += h * (w * before.supplied + (1 - w) * now.supplied);
  books.forces_before = now;
}

/// Impulses and energies of the pairs, and their friction at the part's end.
void bookPairs(const ImplicitStage& stage, const SolvedPart& part, bool first_part, State& state, StepBooks& books) noexcept {
  const Island& island = stage.island;
  const bool two_stages = part.mean == Mean::kOfStages;
  const double w = weightBefore(part.mean), h = part.length;
  int next = 0;
  for (int i = 0; i < island.pair_count; ++i) {
    ActivePair& pair = state.pairs[island.pairs[i]];
    FrictionMemory& memory = pair.friction;
    const FrictionMemory before = memory;
    // Power before is that of the first stage, or of the start: the base has either.
    const FrictionMemory& first = stage.base.memory[island.pairs[i]];
    const bool now = next < stage.contacts.all().size() && stage.contacts.all()[next].pair == island.pairs[i];
    const Wrench& done = books.last.pair[island.pairs[i]];
    books.impulse[island.pairs[i]] += (two_stages ? books.first.pair[island.pairs[i]] * w + done * (1 - w) : done) * h;
    memory = FrictionMemory{};
    if (now) {
      const ImplicitContact& c = stage.contacts.all()[next];
      memory = c.force.memory;
      memory.elastic_energy = stage.contacts.all()[next++].elastic;
    }
    // What begins in a part of a step has its impact up to the end of the next step, even if it parts before.
    memory.began = std::max(memory.began, !first_part ? before.began : before.began == 1 ? kStillBegins : 0.0);
    const auto work = [&](double p1, double p2) { return h * (w * p1 + (1 - w) * p2); };
    const double beyond = work(first.power.elastic, memory.power.elastic) + before.elastic_energy - memory.elastic_energy;
    state.energy.bookPressure(work(first.power.damping, memory.power.damping), beyond, before, memory, pair.buried);
    const double friction = work(first.power.friction, memory.power.friction) + before.energy - memory.energy;
    (memory.sliding != 0 ? state.energy.friction : state.energy.damping) += now || before.touching != 0 ? friction : 0;
  }
}

}  // namespace

StageWrenches::StageWrenches(const Model& model)
    : pair(model.pair_capacity), hands_power(model.pair_capacity), coupling(model.pointers.size()), coupling_power(model.pointers.size()) {}

StepBooks::StepBooks(const Model& model)
    : impulse(model.pair_capacity), place(model.pair_capacity), event(model.pair_capacity), coupling_impulse(model.pointers.size()),
      coupling_work(model.pointers.size()), first(model), last(model) {}

void openBooks(int pairs, StepBooks& books) noexcept {
  std::fill(books.event.begin(), books.event.begin() + pairs, 1.0);
  std::fill(books.impulse.begin(), books.impulse.begin() + pairs, Wrench{});
  std::fill(books.coupling_work.begin(), books.coupling_work.end(), 0.0);
  std::fill(books.coupling_impulse.begin(), books.coupling_impulse.end(), Wrench{});
}

void gather(const ImplicitStage& stage, StageWrenches& found, std::vector<Pose>& place) noexcept {
  const Island& island = stage.island;
  for (int i = 0; i < island.pair_count; ++i) {
    found.pair[island.pairs[i]] = Wrench{};
    found.hands_power[island.pairs[i]] = 0;
  }
  const auto add = [&](const auto& pressed) {
    found.pair[pressed.pair] += pressed.done_P.rotated(pressed.X_WP.R).shifted(-pressed.X_WP.p);
    found.hands_power[pressed.pair] += pressed.hands_power;
    place[pressed.pair] = pressed.X_WP;
  };
  for (const ImplicitContact& c : stage.contacts.all()) add(c);
  for (const Brush& b : stage.contacts.brushes()) add(b);
  for (std::size_t p = 0; p < stage.forces.couplings.size(); ++p) {
    found.coupling[p] = stage.forces.couplings[p].F_W;
    found.coupling_power[p] = stage.forces.couplings[p].power;
  }
  found.all_hands_power = stage.contacts.handsPower();
  found.forces = stage.forces.power;
}

void bookPart(const Model& model, const ImplicitStage& stage, const SolvedPart& part, bool first_part, State& state,
              StepBooks& books) noexcept {
  gather(stage, books.last, books.place);
  bookSupply(model.settings, stage, part, state, books);
  bookPairs(stage, part, first_part, state, books);
  bookCouplings(model, stage, part, state, books);
}

void bookStanding(const Model& model, const ImplicitStage& stage, double h, State& state, StepBooks& books) noexcept {
  if (model.settings.energy_ledger) state.energy.external += h * stage.contacts.handsPower();
  gather(stage, books.last, books.place);
  const Island& island = stage.island;
  for (int i = 0; i < island.pair_count; ++i) books.impulse[island.pairs[i]] = books.last.pair[island.pairs[i]] * h;
  bookCouplings(model, stage, {h, h, Mean::kOfEnd, 0}, state, books);
}

double sumOf(const std::vector<double>& values) noexcept { return std::accumulate(values.begin(), values.end(), 0.0); }

}  // namespace haptic::stepping
