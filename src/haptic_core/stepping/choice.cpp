#include "haptic_core/stepping/choice.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/world/link_forces.h"
#include "haptic_core/world/stability_number.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {
namespace {

/// Touching pairs up to which a substep is cut into parts, each of which costs all of them again.
constexpr int kMostCutPairs = 8;
/// A patch whose area, volume or lever arm has grown or shrunk by more than these factors is measured again: numbers may be twice too
/// high, and little too low.
constexpr double kGrown = 1.1, kShrunk = 0.5;

bool isImplicit(const State& state, int tree) noexcept { return state.mode[tree] >= TreeMode::kImplicit; }

bool movesByItself(const Model& model, const Work& work, int shape) noexcept {
  return work.hands.movesByItself(model.trees[model.treeOf(shape)]);
}

/// As StabilityMemory keeps it.
double moversOf(const Model& model, const Work& work, const ActivePair& pair) noexcept {
  return (movesByItself(model, work, pair.shapeA()) ? 1 : 0) + (movesByItself(model, work, pair.shapeB()) ? 2 : 0) +
         (pair.friction.sliding != 0 ? 4 : 0);
}

/// Largest distance of a patch from the centre of mass of a link that moves [m].
double leverOf(const Model& model, const Pose& X_WP, const Work& work, const ActivePair& pair) noexcept {
  double longest = 0;
  for (const int shape : {pair.shapeA(), pair.shapeB()}) {
    if (!movesByItself(model, work, shape)) continue;
    longest = std::max(longest, (work.placement.link[model.shapes[shape].link].p_WC() - X_WP.p).norm());
  }
  return longest;
}

/// Whether the shares of a contact are those of another patch.
bool isOutdated(const Model& model, const ContactVolume& volume, const Pose& X_WP, const Work& work, const ActivePair& pair) noexcept {
  const StabilityMemory& known = pair.stability;
  const auto differs = [](double now, double then) { return now > kGrown * then || now < kShrunk * then; };
  return known.movers != moversOf(model, work, pair) || differs(volume.A0, known.area) || differs(volume.volume, known.volume) ||
         differs(leverOf(model, X_WP, work, pair), known.lever);
}

/// Shares of a contact for its two links.
void measureShares(const Model& model, const ContactVolume& volume, const PatchTangent& tangent, const Pose& X_WP,
                   const Work& work, ActivePair& pair) noexcept {
  const int link[2] = {model.shapes[pair.shapeA()].link, model.shapes[pair.shapeB()].link};
  const bool moves[2] = {movesByItself(model, work, pair.shapeA()), movesByItself(model, work, pair.shapeB())};
  const bool both = moves[0] && moves[1];
  double mobility = 0;  // of both along the normal [1/kg]
  for (int s = 0; s < 2; ++s) {
    pair.stability.share[s] = 0;
    if (!moves[s]) continue;
    const ModelLink& l = model.links[link[s]];
    const LinkWork& place = work.placement.link[link[s]];
    const LinkModel& body = model.trees[l.articulation].model->link(l.local);
    const Matrix6 W = ownMobility(body, place.X_WL.R, place.p_WC(), X_WP);
    pair.stability.share[s] = stabilityNumber(tangent, W, both, model.substep());
    mobility += W(5, 5);
  }
  const double h = model.substep(), damper = h * tangent.damping.m0 * mobility;
  pair.stability.swing = h * h * tangent.stiffness.m0 * mobility + 2 * damper / (1 + 0.5 * damper);
  pair.stability.movers = moversOf(model, work, pair);
  pair.stability.area = volume.A0;
  pair.stability.volume = volume.volume;
  pair.stability.lever = leverOf(model, X_WP, work, pair);
}

/// Parts of a substep in which this contact is resolved.
double partsOf(const ContactEvaluation& c, const StabilityMemory& known, double last_rate, double h) noexcept {
  const bool moves = std::max(known.rate, last_rate) * h > kResting * c.volume.depth;
  return moves && known.swing > kRough * kRough ? std::ceil(std::sqrt(std::min(known.swing, kStabilityBound)) / kFine) : 1;
}

/// Share of a force element for one of its links, as if this were free. It counts so that an island becomes implicit where it swings by
/// more than kRough in a step: as a contact that moves, it is stable beyond that and wrong.
double forceNumber(const Model& model, const LinkForce& force, const Vector3& p_W, int link, const Work& work) noexcept {
  const double h = model.substep();
  const ModelLink& l = model.links[link];
  const LinkModel& body = model.trees[l.articulation].model->link(l.local);
  const double turn = body.turn_mobility.trace();  // not below the largest eigenvalue
  const double arm2 = (work.placement.link[link].p_WC() - p_W).squaredNorm();
  const Matrix3 way = h * h * force.way_K + 2 * h * force.way_D, turning = h * h * force.turn_K + 2 * h * force.turn_D;
  const double line = h * h * force.line.stiffness + 2 * h * force.line.damping;
  return kStabilityBound / (kRough * kRough) * ((way.norm() + line) * (body.mobility + arm2 * turn) + turning.norm() * turn);
}

/// All is explicit, and little touches.
bool mayCut(const State& state) noexcept {
  int touching = 0;
  for (int i = 0; i < state.pair_count; ++i) touching += state.pairs[i].friction.touching != 0;
  return touching <= kMostCutPairs && !anyImplicit(state);
}

/// Calls visit(numbers of the state, numbers of the retreat, count) for each row of a tree that an attempt changes.
template <class AState, class ARetreat, class Visit>
void eachKept(const ModelTree& tree, int t, AState& state, ARetreat& retreat, Visit&& visit) noexcept {
  const auto row = [&](auto& of_state, auto& kept, int first, int count) { visit(of_state.data() + first, kept.data() + first, count); };
  const int nv = tree.model->nv();
  row(state.q, retreat.q, tree.q, tree.model->nq());
  row(state.v, retreat.v, tree.v, nv);
  row(state.pull, retreat.pull, tree.v, nv);
  row(state.last_step, retreat.last_step, t, 1);
  if (!retreat.remembers) return;
  row(state.a_end, retreat.a_end, tree.v, nv);
  row(state.a_mean, retreat.a_mean, tree.v, nv);
  row(state.v_mean, retreat.v_mean, tree.v, nv);
}

void addShares(const Model& model, const ActivePair& pair, std::vector<double>& number) noexcept {
  number[model.shapes[pair.shapeA()].link] += pair.stability.share[0];
  number[model.shapes[pair.shapeB()].link] += pair.stability.share[1];
}

}  // namespace

ChoiceWork::ChoiceWork(const Model& model) : number(model.links.size()) {
  retreat.q.resize(model.nq);
  retreat.v.resize(model.nv);
  for (auto* x : {&retreat.pull, &retreat.a_end, &retreat.a_mean, &retreat.v_mean}) x->resize(model.nv);
  retreat.last_step.resize(model.trees.size());
  retreat.mode.resize(model.trees.size());
  retreat.wrench.resize(model.pointers.size());
}

bool anyImplicit(const State& state) noexcept {
  return std::any_of(state.mode.begin(), state.mode.end(), [](TreeMode mode) { return mode >= TreeMode::kImplicit; });
}

double longestPart(const Model& model, const State& state) noexcept {
  double parts = 1;
  if (model.explicit_steps && model.implicit_steps && mayCut(state)) {
    for (int i = 0; i < state.pair_count; ++i) parts = std::max(parts, state.pairs[i].stability.parts);
  }
  return parts > 1 ? model.substep() / parts : std::numeric_limits<double>::infinity();
}

void keepForRetreat(const ModelTree& tree, int t, const State& state, Retreat& retreat) noexcept {
  eachKept(tree, t, state, retreat, [](const double* of_state, double* kept, int count) { std::copy_n(of_state, count, kept); });
}

void keepForRetreat(const Model& model, const Visits& visits, const State& state, const HandWork& hands, const StepReport& report,
                    Retreat& retreat) noexcept {
  retreat.remembers = anyImplicit(state);
  for (const int t : visits.trees) keepForRetreat(model.trees[t], t, state, retreat);
  retreat.wrench = hands.wrench;
  retreat.energy = state.energy;
  retreat.pair_count = state.pair_count;
  retreat.flags = report.flags;
}

void takeBack(const Model& model, State& state, Work& work, StepReport& report) noexcept {
  const Retreat& retreat = work.choice.retreat;
  for (const int t : work.visits.trees) {
    eachKept(model.trees[t], t, state, retreat,
             [](double* of_state, const double* kept, int count) { std::copy_n(kept, count, of_state); });
  }
  state.energy = retreat.energy;
  work.choice.position_error = 0;
  std::swap(work.search.previous, state.pairs);  // the search has swapped them once
  state.pair_count = retreat.pair_count;
  report.flags = retreat.flags;
  report.impact = 0;
  placeTrees(model, work.visits.trees, state, work.placement);
}

bool modesMeet(const Model& model, const State& state, const Work& work) noexcept {
  for (int i = 0; i < state.pair_count; ++i) {
    const int a = model.treeOf(state.pairs[i].shapeA()), b = model.treeOf(state.pairs[i].shapeB());
    if (isImplicit(state, a) != isImplicit(state, b) && work.hands.movesByItself(model.trees[a]) &&
        work.hands.movesByItself(model.trees[b])) {
      return true;
    }
  }
  return !model.forces.empty() && forcesJoinModes(model, state, work.visits, work.hands);
}

void makeImplicit(const Model& model, bool by_numbers, State& state, Work& work) noexcept {
  work.islands.find(state, work.visits.trees, work.hands.held_by, false);
  for (int i = 0; i < work.islands.count(); ++i) {
    const Island island = work.islands[i];
    bool implicit = false;
    for (int n = 0; n < island.tree_count; ++n) {
      const ModelTree& tree = model.trees[island.trees[n]];
      implicit |= isImplicit(state, island.trees[n]);
      for (int l = 0; by_numbers && l < tree.model->linkCount(); ++l) {
        implicit |= work.choice.number[tree.link + l] > kEnterImplicit * kStabilityBound;
      }
    }
    for (int n = 0; implicit && n < island.tree_count; ++n) state.mode[island.trees[n]] = TreeMode::kImplicit;
  }
}

void giveUpExplicit(const Model& model, State& state, const Work& work) noexcept {
  if (!model.implicit_steps) return;
  for (const ModelTree* tree : work.hands.movers) state.mode[model.indexOf(*tree)] = TreeMode::kImplicit;
}

bool anyTooStiff(const Model& model, const Visits& visits, ChoiceWork& choice, StepReport& report) noexcept {
  double most = 0;
  for (const int t : visits.trees) {
    const ModelTree& tree = model.trees[t];
    for (int l = tree.link; l < tree.link + tree.model->linkCount(); ++l) {
      double& number = choice.number[l];
      if (choice.cuts) number /= choice.parts;  // that of a damper; that of a spring falls like its square
      most = std::max(most, number);
    }
  }
  report.stability = most / kStabilityBound;
  return report.stability > kEnterImplicit;
}

void countCouplings(const Model& model, const State& state, Work& work) noexcept {
  std::fill(work.choice.number.begin(), work.choice.number.end(), 0.0);
  work.choice.parts = 1;
  work.choice.cuts = mayCut(state);
  for (const int i : work.hands.acting) {
    const PointerState& pointer = state.pointers[i];
    if (!pointer.targeted || isImplicit(state, model.links[pointer.link].articulation)) continue;
    work.choice.number[pointer.link] = couplingNumber(model, state, work, pointer.link);
  }
  if (model.forces.empty()) return;
  countForces(model, {work.visits.trees.data(), static_cast<int>(work.visits.trees.size())}, false, state, work);
}

void countForces(const Model& model, const TreeRange& trees, bool implicit, const State& state, Work& work) noexcept {
  const auto moves = [&](int tree) { return isImplicit(state, tree) == implicit && work.hands.movesByItself(model.trees[tree]); };
  eachForce(model, trees, moves, [&](int, const ModelForce& force) {
    const LinkForce now = forceNow(model, force, work.placement.link.data());
    const bool moves_a = force.tree_a >= 0 && moves(force.tree_a), moves_b = force.tree_b >= 0 && moves(force.tree_b);
    const double both = moves_a && moves_b ? 2 : 1;
    if (moves_a) work.choice.number[force.link_a] += both * forceNumber(model, now, now.p_WA, force.link_a, work);
    if (moves_b) work.choice.number[force.link_b] += both * forceNumber(model, now, now.p_WB, force.link_b, work);
  });
}

double couplingNumber(const Model& model, const State& state, const Work& work, int link) noexcept {
  const double h = model.substep();
  double sum = 0;
  for (std::size_t p = 0; p < state.pointers.size(); ++p) {
    if (model.holds(static_cast<int>(p)) || state.pointers[p].link != link || !state.pointers[p].targeted) continue;
    const PointerCoupling& c = work.hands.coupling[p];
    const ModelLink& l = model.links[link];
    const LinkWork& place = work.placement.link[link];
    const LinkModel& body = model.trees[l.articulation].model->link(l.local);
    const double turn = body.turn_mobility.trace();  // not below the largest eigenvalue
    const double arm2 = (place.p_WC() - place.X_WL.p).squaredNorm();  // the spring is at L's origin
    sum += (h * h * c.stiffness + 2 * h * c.damping) * (body.mobility + arm2 * turn) +
           (h * h * c.rotational_stiffness + 2 * h * c.rotational_damping) * turn;
  }
  return sum;
}

void noteStability(const Model& model, const ContactEvaluation& c, Work& work, ActivePair& pair) noexcept {
  addStability(model, c.volume, c.force.tangent, c.X_WP, work, pair);
  const double last_rate = pair.stability.rate;
  pair.stability.rate = std::abs(c.V_AB_P.linear.z());
  pair.stability.parts = partsOf(c, pair.stability, last_rate, model.substep());
  if (!(pair.stability.parts > 1)) return;
  work.choice.parts = std::max(work.choice.parts, pair.stability.parts);
  if (work.choice.cuts) return;
  for (const int shape : {pair.shapeA(), pair.shapeB()}) {
    if (movesByItself(model, work, shape)) work.choice.number[model.shapes[shape].link] += kStabilityBound;
  }
}

void addStability(const Model& model, const ContactVolume& volume, const PatchTangent& tangent, const Pose& X_WP, Work& work,
                  ActivePair& pair) noexcept {
  if (isOutdated(model, volume, X_WP, work, pair)) measureShares(model, volume, tangent, X_WP, work, pair);
  addShares(model, pair, work.choice.number);
}

}  // namespace haptic::stepping
