#include "haptic_core/stepping/explicit_contacts.h"

#include <algorithm>
#include <limits>

#include "haptic_core/geometry/volume/contact_moments.h"
#include "haptic_core/stepping/settled_damper.h"

namespace haptic::stepping {
namespace {

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
void release(const Model& model, int index, const Advance& advance, State& state, Work& work, Report& report) noexcept {
  const ActivePair& pair = state.pairs[index];
  const double h = advance.second_order ? advance.time : 0;
  if (model.settings.energy_ledger && !(h > 0)) bookRelease(pair.friction, state.energy);
  if (!advance.second_order) return;
  const double tau = std::min(pair.release.leave, h), order = pair.release.order, correction = tau / (order + 1) - h / 2;
  ContactReport ended;
  ended.shape_a = pair.shapeA();
  ended.shape_b = pair.shapeB();
  ended.link_a = model.shapes[ended.shape_a].link;
  ended.link_b = model.shapes[ended.shape_b].link;
  addKick(ended.link_a, ended.link_b, pair.release.F_BP_W * correction, pair.release.X_WP.p, work.placement, work.contacts);
  if (!(h > 0)) return;
  if (model.settings.energy_ledger) noteRelease(index, pair, correction, work.contacts.booked);
  ended.X_WP = Pose(patchAxes(work.placement.X_WS[ended.shape_a].R * pair.friction.normal_A), pair.release.X_WP.p);
  ended.F_BP_W = pair.release.F_BP_W * (tau / (order + 1) / h);
  ended.normal_force = ended.F_BP_W.force.dot(ended.X_WP.R.col(2));
  ended.event = tau / h;
  report.addContact(ended, false);
}

/// Velocity Verlet takes half of its impulse from the force before and half from the force after, and adds what events change:
/// the wrench that does the same over the whole step.
void reportMean(const ReleaseMemory& before, bool touched, const LocatedForce& force, double h, ContactReport& contact) noexcept {
  Wrench mean = contact.F_BP_W * 0.5;
  if (touched) mean += before.F_BP_W.shifted(contact.X_WP.p - before.X_WP.p) * 0.5;
  if (force.has_impulse) mean += force.impulse_P.rotated(contact.X_WP.R) * (1 / h);
  contact.F_BP_W = mean;
  contact.normal_force = mean.force.dot(contact.X_WP.R.col(2));
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
  const ContactPlaces places{placement.link.data(), placement.X_WS.data(), work.hands.held_by.data(),
                             work.hands.acting.empty() ? nullptr : work.hands.bound.data(),
                             work.hands.acting.empty() ? nullptr : work.hands.pressed.data()};
  work.counted.done += model.look(pair.shapeA(), pair.shapeB());
  const bool overlap = locateContact(model, contacts.seams, index, pair, places, contacts.workspace, c);
  work.clock.end(overlap ? times.volume : times.detection);
  if (!overlap) {
    if (pair.friction.touching != 0) release(model, index, advance, state, work, report);
    pair.friction = {};
    pair.buried = false;
    return;
  }
  const int a = pair.shapeA(), b = pair.shapeB(), link_a = model.shapes[a].link, link_b = model.shapes[b].link;
  if (pair.buried) pair.buried = !(c.volume.depth < model.buriedDepth(a, b, c.volume.A0));
  Advance on = advance;
  on.belt = c.belt;
  on.run = advance.time;
  settleForce(model, pair, on, work, c, report.step.flags);
  const Wrench F_BP_W = c.force.F_BP_P.rotated(c.X_WP.R);
  placement.link[link_b].addWrench(F_BP_W, c.X_WP.p);
  placement.link[link_a].addWrench(-F_BP_W, c.X_WP.p);
  if (c.force.has_impulse) addKick(link_a, link_b, c.force.impulse_P.rotated(c.X_WP.R), c.X_WP.p, placement, contacts);
  FrictionMemory memory = c.force.memory;
  const bool touched = pair.friction.touching != 0;
  memory.elastic_energy = elasticEnergy(model, c.volume, c.law.material.stiffness, contacts.workspace);  // implicit steps start from it
  if (model.settings.energy_ledger) noteContact(index, pair, c, contacts.booked);
  pair.friction = memory;
  ContactReport contact = reportOf(model, pair, c.volume, c.X_WP, c.force);
  if (advance.second_order) {
    if (advance.time > 0) reportMean(pair.release, touched, c.force, advance.time, contact);
    pair.release = releaseOf(c.volume, c.V_AB_P, c.X_WP, c.force);
  }
  if (memory.began != 0) {
    report.addImpact(-c.V_AB_P.linear.z(), c.law.reduced_mass, advance.time * model.settings.gravity.norm());
  }
  report.addContact(contact, c.force.clipped);
  work.clock.end(times.force);
}

}  // namespace

ReleaseMemory releaseOf(const ContactVolume& volume, const Twist& V_AB_P, const Pose& X_WP, const LocatedForce& force) noexcept {
  ReleaseMemory release;
  release.X_WP = X_WP;
  release.F_BP_W = force.F_BP_P.rotated(X_WP.R);
  release.elastic_W = force.elastic().rotated(X_WP.R);
  release.leave = V_AB_P.linear.z() > 0 ? volume.depth / V_AB_P.linear.z() : std::numeric_limits<double>::infinity();
  release.order = std::clamp(volume.A0 * volume.depth / volume.volume, 1.0, 3.0);
  return release;
}

void evaluateContacts(const Model& model, const Advance& advance, State& state, Work& work, Report& report) noexcept {
  ContactWork& contacts = work.contacts;
  report.contacts.clear();
  contacts.booked.clear();
  contacts.has_kick = false;
  work.clock.end(report.step.stages.search);
  const auto isSolved = [&](const ActivePair& pair) {  // by an implicit island
    const auto moves = [&](int shape) { return work.hands.movesByItself(model.trees[model.treeOf(shape)]); };
    return work.implicit && (moves(pair.shapeA()) || moves(pair.shapeB()));
  };
  if (!std::all_of(state.pairs.begin(), state.pairs.begin() + state.pair_count, isSolved)) {
    countContacts(model, state, contacts.on_link);
    if (contacts.seams.any()) {
      contacts.seams.find(state.pairs.data(), nullptr, state.pair_count, work.placement.X_WS.data(), contacts.workspace);
    }
    for (int i = 0; i < state.pair_count; ++i) {
      if (!isSolved(state.pairs[i])) evaluatePair(model, i, advance, state, work, report);
    }
  }
  report.step.pairs = state.pair_count;
  report.step.contacts = report.contacts.size();
}

}  // namespace haptic::stepping
