#include "haptic_core/stepping/explicit_contacts.h"

#include <algorithm>
#include <limits>

#include "haptic_core/stepping/settled_damper.h"

namespace haptic::stepping {
namespace {

/// What a hand holds is stepped by nobody, whatever the mode of its tree.
bool isImplicit(const Model& model, const State& state, const HandWork& hands, int shape) noexcept {
  const int tree = model.treeOf(shape);
  return state.mode[tree] == TreeMode::kImplicit && hands.movesByItself(model.trees[tree]);
}

/// An impulse on B, and its opposite on A, at a point of W; taken into account at the end of the step.
void addKick(int link_a, int link_b, const Wrench& J_W, const Vector3& p_W, const Placement& placement,
             ContactWork& contacts) noexcept {
  if (!contacts.has_kick) std::fill(contacts.kick.begin(), contacts.kick.end(), Wrench{});
  contacts.has_kick = true;
  contacts.kick[link_b] += J_W.shifted(placement.link[link_b].p_WO - p_W);
  contacts.kick[link_a] += -J_W.shifted(placement.link[link_a].p_WO - p_W);
}

/// The bodies parted inside the step, τ after its start, while the force fell like (τ - t)ⁿ: its impulse was
/// F τ/(n + 1), where the trapezoidal rule has taken F h/2.
void release(const Model& model, const ActivePair& pair, const Advance& advance, State& state, Work& work) noexcept {
  const bool second_order = advance.second_order;
  const double h = second_order ? advance.time : 0, tau = second_order ? std::min(pair.release.leave, h) : 0;
  const double order = second_order ? pair.release.order : 1;
  if (model.settings.energy_ledger) bookRelease(pair.friction, h, tau, order, state.energy);
  if (!second_order) return;
  addKick(model.shapes[pair.shapeA()].link, model.shapes[pair.shapeB()].link,
          pair.release.F_BP_W * (tau / (order + 1) - h / 2), pair.release.p_WP, work.placement, work.contacts);
}

/// Contacts that share the mass of each link, as the last evaluation left them; what stands still has none to share.
void countContacts(const Model& model, const State& state, std::vector<int>& on_link) noexcept {
  std::fill(on_link.begin(), on_link.end(), 0);
  for (int i = 0; i < state.pair_count; ++i) {
    const ActivePair& pair = state.pairs[i];
    if (pair.friction.touching == 0) continue;
    for (const int shape : {pair.shapeA(), pair.shapeB()}) {
      const int link = model.shapes[shape].link;
      if (model.links[link].moves) ++on_link[link];
    }
  }
}

void evaluatePair(const Model& model, int index, const Advance& advance, State& state, Work& work, Report& report) noexcept {
  ActivePair& pair = state.pairs[index];
  ContactWork& contacts = work.contacts;
  Placement& placement = work.placement;
  StageTimes& times = report.step.stages;
  ContactEvaluation c;
  const ContactPlaces places{placement.link.data(), placement.X_WS.data(), work.hands.held_by.data()};
  const bool overlap = locateContact(model, contacts.seams, index, pair, places, contacts.workspace, c);
  work.clock.end(overlap ? times.volume : times.detection);
  if (!overlap) {
    if (pair.friction.touching != 0) release(model, pair, advance, state, work);
    pair.friction = {};
    pair.stability = {};
    pair.buried = false;
    return;
  }
  const int a = pair.shapeA(), b = pair.shapeB(), link_a = model.shapes[a].link, link_b = model.shapes[b].link;
  if (pair.buried) pair.buried = !(c.volume.depth < model.buriedDepth(a, b, c.volume.A0));
  settleForce(model, pair, advance, work, c, report.step.flags);
  const Wrench F_BP_W = c.force.F_BP_P.rotated(c.X_WP.R);
  placement.link[link_b].addWrench(F_BP_W, c.X_WP.p);
  placement.link[link_a].addWrench(-F_BP_W, c.X_WP.p);
  if (c.force.has_impulse) addKick(link_a, link_b, c.force.impulse_P.rotated(c.X_WP.R), c.X_WP.p, placement, contacts);
  FrictionMemory memory = c.force.memory;
  if (model.settings.energy_ledger) {
    const double elastic = elasticEnergy(model, c.volume, c.law.material.stiffness, contacts.workspace);
    noteContact(index, c, pair.friction, elastic, memory, contacts.booked, report.step.energy);
  }
  pair.friction = memory;
  if (model.settings.integrator == Integrator::kAutomatic) noteStability(model, c, state, work, pair);
  if (advance.second_order) pair.release = releaseOf(c.volume, c.V_AB_P, c.X_WP.p, F_BP_W);
  if (memory.began != 0) {
    report.addImpact(-c.V_AB_P.linear.z(), c.law.reduced_mass, advance.time * model.settings.gravity.norm());
  }
  report.addContact(reportOf(model, pair, c.volume, c.X_WP, c.force), c.force.clipped);
  work.clock.end(times.force);
}

}  // namespace

ReleaseMemory releaseOf(const ContactVolume& volume, const Twist& V_AB_P, const Vector3& p_WP, const Wrench& F_BP_W) noexcept {
  ReleaseMemory release;
  release.p_WP = p_WP;
  release.F_BP_W = F_BP_W;
  release.leave = V_AB_P.linear.z() > 0 ? volume.depth / V_AB_P.linear.z() : std::numeric_limits<double>::infinity();
  release.order = std::clamp(volume.A0 * volume.depth / volume.volume, 1.0, 3.0);
  return release;
}

void evaluateContacts(const Model& model, const Advance& advance, State& state, Work& work, Report& report) noexcept {
  const bool chooses = model.settings.integrator == Integrator::kAutomatic;
  ContactWork& contacts = work.contacts;
  report.contacts.clear();
  report.step.energy.elastic = report.step.energy.tangential = 0;
  contacts.booked.clear();
  contacts.has_kick = false;
  work.clock.end(report.step.stages.search);
  countContacts(model, state, contacts.on_link);
  if (contacts.seams.any()) {
    contacts.seams.find(state.pairs.data(), nullptr, state.pair_count, work.placement.X_WS.data(), contacts.workspace);
  }
  if (chooses) countCouplings(model, state, work);
  for (int i = 0; i < state.pair_count; ++i) {
    const ActivePair& pair = state.pairs[i];
    if (work.implicit && (isImplicit(model, state, work.hands, pair.shapeA()) ||
                          isImplicit(model, state, work.hands, pair.shapeB()))) {
      continue;
    }
    evaluatePair(model, i, advance, state, work, report);
  }
  report.step.pairs = state.pair_count;
  report.step.contacts = report.contacts.size();
}

}  // namespace haptic::stepping
