#include "haptic_core/stepping/island_solve.h"

#include <algorithm>

#include "haptic_core/stepping/flow.h"
#include "haptic_core/stepping/span.h"
#include "haptic_core/stepping/rest.h"
#include "haptic_core/world/link_forces.h"

namespace haptic::stepping {
namespace {

ImplicitOrder orderOf(Attempts attempts) noexcept {
  return attempts == Attempts::kImplicitEuler ? ImplicitOrder::kFirst
         : attempts == Attempts::kSdirk2      ? ImplicitOrder::kSecond
                                              : ImplicitOrder::kSecondMultistep;
}

/// Nothing touches the island, and no hand and no force element pulls at it: its trees go on by themselves.
bool isLeftAlone(const Model& model, const Island& island, const State& state) noexcept {
  if (model.settings.attempts != Attempts::kAll && (island.pair_count > 0 || island.tree_count > 1)) return false;
  for (int i = 0; i < island.pair_count; ++i) {
    const ActivePair& pair = state.pairs[island.pairs[i]];
    if (pair.friction.touching != 0 || pair.buried) return false;
  }
  const auto isOf = [&](int tree) { return std::binary_search(island.trees, island.trees + island.tree_count, tree); };
  for (std::size_t p = 0; p < state.pointers.size(); ++p) {
    const PointerState& pointer = state.pointers[p];
    if (!model.holds(static_cast<int>(p)) && pointer.targeted && isOf(model.links[pointer.link].articulation)) return false;
  }
  return std::all_of(island.trees, island.trees + island.tree_count, [&](int t) {
    return !hasForces(model, t) && (model.settings.attempts == Attempts::kAll || model.isFree(model.trees[t]));
  });
}

/// Whether something of the island overlaps where it stands now.
bool anyTouches(const Model& model, const Island& island, State& state, Work& work) noexcept {
  Placement& placement = work.placement;
  ContactWork& contacts = work.contacts;
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model.trees[island.trees[n]];
    placeTree(tree, state, placement);
    for (int s = tree.shape; s < tree.shape_end; ++s) placement.X_WS[s] = placement.link[model.shapes[s].link].X_WL * model.shapes[s].X_LS;
  }
  const Pose* X_WS = placement.X_WS.data();
  if (contacts.seams.any()) contacts.seams.find(state.pairs.data(), island.pairs, island.pair_count, X_WS, contacts.workspace);
  return std::any_of(island.pairs, island.pairs + island.pair_count, [&](int i) {
    ActivePair& pair = state.pairs[i];
    ContactVolume volume;
    work.counted.done += model.look(pair.shapeA(), pair.shapeB());
    const Pose &X_WA = X_WS[pair.shapeA()], &X_WB = X_WS[pair.shapeB()];
    contacts.seams.locate(i, pair, X_WA, relativePose(X_WA, X_WB), contacts.workspace, volume);
    return volume.status == ContactVolume::Status::kOverlap;
  });
}

/// Contacts of trees that have been put where they are neither begin nor end in this step: friction and pressure are those of the place,
/// and memories of other places are forgotten.
void meet(const Model& model, const Island& island, State& state, Work& work) noexcept {
  const bool put = std::any_of(island.trees, island.trees + island.tree_count, [&](int t) { return state.mode[t] == TreeMode::kPut; });
  if (!put) return;
  const bool any = anyTouches(model, island, state, work);
  const ContactPlaces places{work.placement.link.data(), work.placement.X_WS.data(), work.hands.held_by.data(), work.hands.bound.data(),
                             work.hands.pressed.data()};
  for (int n = 0; n < island.pair_count; ++n) {
    const int i = island.pairs[n];
    ActivePair& pair = state.pairs[i];
    ContactEvaluation found;
    const bool touched = pair.friction.touching != 0;
    if (!any || !evaluateContact(model, work.contacts.seams, i, pair, places, pair.friction, Advance{}, work.contacts.workspace, found)) {
      if (touched) pair.friction = FrictionMemory{}, pair.means = ContactMeans{};
      continue;
    }
    if (touched) continue;
    pair.friction = found.force.memory;
    pair.friction.began = 0;
    pair.friction.elastic_energy = elasticEnergy(found.volume, found.law.material.stiffness, work.contacts.workspace);
  }
}

/// The island's trees go on by themselves, unless that has something touch at the end: then nothing is done.
bool flows(const Model& model, const Island& island, double h, State& state, Work& work, StepReport& report) noexcept {
  if (!isLeftAlone(model, island, state)) return false;
  FlowWork& motion = work.motion;
  const EnergySums energy = state.energy;
  const auto eachTree = [&](auto&& act) {
    for (int n = 0; n < island.tree_count; ++n) act(island.trees[n], model.trees[island.trees[n]]);
  };
  eachTree([&](int, const ModelTree& tree) {
    std::copy_n(state.q.begin() + tree.q, tree.model->nq(), motion.q_start.begin() + tree.q);
    std::copy_n(state.v.begin() + tree.v, tree.model->nv(), motion.v_start.begin() + tree.v);
  });
  eachTree([&](int t, const ModelTree&) { flow(model, t, h, state, work, report); });
  if (island.pair_count > 0 && anyTouches(model, island, state, work)) {
    eachTree([&](int, const ModelTree& tree) {
      std::copy_n(motion.q_start.begin() + tree.q, tree.model->nq(), state.q.begin() + tree.q);
      std::copy_n(motion.v_start.begin() + tree.v, tree.model->nv(), state.v.begin() + tree.v);
    });
    state.energy = energy;
    return false;
  }
  eachTree([&](int t, const ModelTree&) { keepFlow(model, t, h, motion.v_start, state); });
  return true;
}

/// A contact that began: its bodies approached at the speed that its impulse took from them.
void noteImpact(const Model& model, const ContactReport& contact, double h, Work& work) noexcept {
  const LinkWork &A = work.placement.link[contact.link_a], &B = work.placement.link[contact.link_b];
  const double mass = model.law(contact.shape_a, contact.shape_b, false, false).reduced_mass,
               left = (A.twistAt(contact.X_WP.p) - B.twistAt(contact.X_WP.p)).linear.dot(contact.X_WP.R.col(2));
  work.noteImpact(left + h * contact.normal_force / mass, mass, h * model.settings.gravity.norm());
}

/// A contact of the island with its mean wrench on B over the step.
void tellContact(const Model& model, int slot, const Wrench& mean, double h, bool clipped, const State& state, ContactReport& contact,
                 Work& work, StepReport& report) noexcept {
  contact.F_BP_W = mean;
  contact.normal_force = mean.force.dot(contact.X_WP.R.col(2));
  if (state.pairs[slot].friction.began != 0) noteImpact(model, contact, h, work);
  work.reported.tell(slot, contact);
  report.flag(contact, clipped);
}

/// Before another span: trees and their shapes where they are.
void placeAgain(const Model& model, const Island& island, const State& state, Work& work) noexcept {
  StagePlaces& places = work.implicit->stage.places;
  for (int n = 0; n < island.tree_count; ++n) {
    const int t = island.trees[n];
    const ModelTree& tree = model.trees[t];
    placeTree(tree, state, work.placement);
    std::copy_n(state.q.begin() + tree.q, tree.model->nq(), places.q.begin() + tree.q);
    placeInStage(model, t, state.v, places);
  }
}

/// Share of all energy that there was to draw on which dampers and friction of an island may give in a step unsaid [1]: rounding.
/// Larger: `power.given_rel` rises with it; smaller: steps are flagged for rounding.
constexpr double kGiven = 1e-9;

/// The island's report goes into the step's.
void tell(const Model& model, const Island& island, const ImplicitReport& solved, const State& state, Work& work,
          StepReport& report) noexcept {
  if (!solved.stands) work.counted.done += solved.units;
  work.counted.gave_way |= solved.cut && !solved.stands;
  const bool moves = !solved.stands || !standsAlone(model, island, state);
  report.add(solved, moves);
  if (moves) work.wrench_error = std::max(work.wrench_error, solved.wrench_error);
  work.position_error = std::max(work.position_error, solved.position_error);
  const EnergySums& sums = state.energy;
  if (work.implicit->books.given > kGiven * (sums.supply + sums.highest - sums.lowest)) report.flags |= kDissipationGave;
}

}  // namespace

const ImplicitReport* solveIsland(const Model& model, const Island& island, double h, double most, State& state, Work& work,
                                  StepReport& report) noexcept {
  ImplicitWork& implicit = *work.implicit;
  meet(model, island, state, work);
  openIsland(h, most, implicit);
  bool solves = false;
  int spans = 0;
  for (double left = h; left > 0;) {
    if (left < h) placeAgain(model, island, state, work);
    const bool last = ++spans == kMostSpans || work.counted.spent();
    double span = safeSpan(model, island, left, h, state, work);
    if (last && span < left) {
      report.flags |= kTooFast;
      span = left;
    }
    const double after = span < left ? left - span : 0;
    if (!flows(model, island, span, state, work, report)) {
      solves = true;
      if (!implicit.begun) beginIslands(model, state, work.visits.trees, work.hands, work.contacts.seams, h, implicit);
      advanceIsland(model, island, span, after, orderOf(model.settings.attempts), state, implicit);
    } else if (solves) {
      implicit.stage.contacts.select(island);  // nothing touches
    }
    left = after;
  }
  if (!solves) return nullptr;
  for (int n = 0; n < island.tree_count; ++n) state.mode[island.trees[n]] = TreeMode::kImplicit;
  tell(model, island, implicit.report, state, work, report);
  return &implicit.report;
}

void bookRest(const Model& model, const Island& island, const Placement& placement, EnergySums& energy) noexcept {
  double kinetic = 0;
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model.trees[island.trees[n]];
    kinetic += kineticEnergy(*tree.model, placement.link.data() + tree.link);
  }
  energy.damping += kinetic;
  energy.stilled += kinetic;
}

void takeContacts(const Model& model, const Island& island, const ImplicitReport* solved, double h, State& state, Work& work,
                  StepReport& report) noexcept {
  for (int i = 0; i < island.pair_count; ++i) work.reported.open(island.pairs[i]);
  if (!solved) return;
  for (const ImplicitContact& c : work.implicit->stage.contacts.all()) {
    ActivePair& pair = state.pairs[c.pair];
    ContactReport contact = reportOf(model, pair, c.volume, c.X_WP, c.force);
    contact.sticking = pair.friction.sliding == 0;
    contact.event = work.implicit->books.event[c.pair];
    tellContact(model, c.pair, meanWrench(work.implicit->books, c), h, c.force.clipped, state, contact, work, report);
    if (pair.buried) pair.buried = !(c.volume.depth < model.buriedDepth(c.shape_a, c.shape_b, c.volume.A0));
  }
  eachParted(work.implicit->stage, work.implicit->books, [&](int index, const Pose& X_WP, const Wrench& mean) {
    ContactReport contact = reportOf(model, state.pairs[index], ContactVolume{}, X_WP, LocatedForce{});
    tellContact(model, index, mean, h, false, state, contact, work, report);
  });
}

}  // namespace haptic::stepping
