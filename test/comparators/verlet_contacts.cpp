#include <algorithm>
#include <limits>

#include "haptic_core/geometry/volume/contact_moments.h"
#include "settled_damper.h"
#include "verlet_memory.h"

namespace haptic::comparators {
namespace {

/// An impulse on B, and its opposite on A, at a point of W; taken into account at the end of the step.
void addKick(int link_a, int link_b, const Wrench& J_W, const Vector3& p_W, const Placement& placement,
             VerletContacts& contacts) noexcept {
  if (!contacts.has_kick) std::fill(contacts.kick.begin(), contacts.kick.end(), Wrench{});
  contacts.has_kick = true;
  contacts.kick[link_b] += J_W.shifted(placement.link[link_b].p_WO - p_W);
  contacts.kick[link_a] += -J_W.shifted(placement.link[link_a].p_WO - p_W);
}

/// Keeps a contact until its work is booked, when the velocities at the end are known.
void noteContact(int index, const ActivePair& pair, const ContactEvaluation& c, const LocatedEvent& event,
                 VerletContacts& contacts) noexcept {
  BookedContact contact;
  contact.pair = index;
  contact.X_WP = c.X_WP;
  contact.F_BP_P = c.force.F_BP_P;
  contact.elastic_P = c.force.elastic();
  contact.J_BP_P = event.impulse_P;
  contact.elastic_impulse_P = event.elastic_P;
  contact.sticking = c.force.sticking;
  contact.before = pair.friction;
  contact.last = contacts.memory[index];
  contacts.booked.push_back(contact);
}

/// A contact that parted inside the step: its last force times `time` corrects the kick [s].
void noteRelease(int index, const ActivePair& pair, double time, VerletContacts& contacts) noexcept {
  const ReleaseMemory& last = contacts.memory[index].release;
  const Matrix3 R_PW = last.X_WP.R.transpose();
  BookedContact contact;
  contact.pair = index;
  contact.X_WP = last.X_WP;
  contact.J_BP_P = last.F_BP_W.rotated(R_PW) * time;
  contact.elastic_impulse_P = last.elastic_W.rotated(R_PW) * time;
  contact.sticking = pair.friction.sliding == 0;
  contact.parted = true;
  contact.before = pair.friction;
  contact.last = contacts.memory[index];
  contacts.booked.push_back(contact);
}

/// The energy of a contact that parted, where no kick is to be corrected.
void bookRelease(const FrictionMemory& last, EnergySums& sums) noexcept {
  (last.sliding != 0 ? sums.friction : sums.damping) += last.energy;
  sums.bookTurning(last.elastic_energy, last, FrictionMemory{});
}

/// The bodies parted inside the step, τ after its start, while the force fell like (τ - t)ⁿ: its impulse was
/// F τ/(n + 1), where the trapezoidal rule has taken F h/2.
void release(const Model& model, int index, const Advance& advance, State& state, Work& work, VerletContacts& contacts) noexcept {
  const ActivePair& pair = state.pairs[index];
  const ReleaseMemory& last = contacts.memory[index].release;
  const double h = advance.time;
  if (model.settings.energy_ledger && !(h > 0)) bookRelease(pair.friction, state.energy);
  const double tau = std::min(last.leave, h), order = last.order, correction = tau / (order + 1) - h / 2;
  ContactReport ended;
  ended.shape_a = pair.shapeA();
  ended.shape_b = pair.shapeB();
  ended.link_a = model.shapes[ended.shape_a].link;
  ended.link_b = model.shapes[ended.shape_b].link;
  addKick(ended.link_a, ended.link_b, last.F_BP_W * correction, last.X_WP.p, work.placement, contacts);
  if (!(h > 0)) return;
  if (model.settings.energy_ledger) noteRelease(index, pair, correction, contacts);
  ended.X_WP = Pose(patchAxes(work.placement.X_WS[ended.shape_a].R * pair.friction.normal_A), last.X_WP.p);
  ended.F_BP_W = last.F_BP_W * (tau / (order + 1) / h);
  ended.normal_force = ended.F_BP_W.force.dot(ended.X_WP.R.col(2));
  ended.event = tau / h;
  work.reported.tell(index, ended);
}

/// Velocity Verlet takes half of its impulse from the force before and half from the force after, and adds what events change:
/// the wrench that does the same over the whole step.
void reportMean(const ReleaseMemory& before, bool touched, const LocatedEvent& event, double h, ContactReport& contact) noexcept {
  Wrench mean = contact.F_BP_W * 0.5;
  if (touched) mean += before.F_BP_W.shifted(contact.X_WP.p - before.X_WP.p) * 0.5;
  if (event.has_impulse) mean += event.impulse_P.rotated(contact.X_WP.R) * (1 / h);
  contact.F_BP_W = mean;
  contact.normal_force = mean.force.dot(contact.X_WP.R.col(2));
  contact.event = event.at;
}

/// Contacts that share the mass of each link, as the last evaluation left them; what stands still has none to share.
void countContacts(const Model& model, const State& state, std::vector<int>& on_link) noexcept {
  std::fill(on_link.begin(), on_link.end(), 0);
  for (const int i : state.pairs.awake()) {
    const ActivePair& pair = state.pairs[i];
    if (pair.friction.touching == 0) continue;
    for (const int shape : {pair.shapeA(), pair.shapeB()}) {
      const int link = model.shapes[shape].link;
      if (model.links[link].moves) ++on_link[link];
    }
  }
}

ReleaseMemory releaseOf(const ContactVolume& volume, const Twist& V_AB_P, const Pose& X_WP, const LocatedForce& force) noexcept {
  ReleaseMemory release;
  release.X_WP = X_WP;
  release.F_BP_W = force.F_BP_P.rotated(X_WP.R);
  release.elastic_W = force.elastic().rotated(X_WP.R);
  release.leave = V_AB_P.linear.z() > 0 ? volume.depth / V_AB_P.linear.z() : std::numeric_limits<double>::infinity();
  release.order = std::clamp(volume.A0 * volume.depth / volume.volume, 1.0, 3.0);
  return release;
}

void evaluatePair(const Model& model, ContactModel contact_model, int index, const Advance& advance, State& state, Work& work,
                  VerletContacts& contacts, StepReport& report) noexcept {
  ActivePair& pair = state.pairs[index];
  work.reported.open(index);
  ContactWorkspace& workspace = work.contacts.workspace;
  Placement& placement = work.placement;
  StageTimes& times = report.stages;
  ContactEvaluation c;
  const ContactPlaces places{placement.link.data(), placement.X_WS.data(), work.hands.held_by.data(),
                             work.hands.acting.empty() ? nullptr : work.hands.bound.data(),
                             work.hands.acting.empty() ? nullptr : work.hands.pressed.data()};
  work.counted.done += model.look(pair.shapeA(), pair.shapeB());
  const bool overlap = findVolume(model, work.contacts.seams, index, pair, places.X_WS, workspace, c);
  if (overlap && contact_model) contact_model(*model.shapes[pair.shapeA()].shape, *model.shapes[pair.shapeB()].shape, workspace, c.volume);
  if (overlap) placeContact(model, pair, places, c);
  work.clock.end(overlap ? times.volume : times.detection);
  if (!overlap) {
    if (pair.friction.touching != 0) release(model, index, advance, state, work, contacts);
    pair.friction = {};
    pair.buried = false;
    return;
  }
  const int a = pair.shapeA(), b = pair.shapeB(), link_a = model.shapes[a].link, link_b = model.shapes[b].link;
  if (pair.buried) pair.buried = !(c.volume.depth < model.buriedDepth(a, b, c.volume.A0));
  Advance on = advance;
  on.belts = c.belts;
  on.run = advance.time;
  LocatedEvent event;
  settleForce(model, pair, contacts.memory[index].release, contacts.on_link, on, work, c, event);
  const Wrench F_BP_W = c.force.F_BP_P.rotated(c.X_WP.R);
  placement.link[link_b].addWrench(F_BP_W, c.X_WP.p);
  placement.link[link_a].addWrench(-F_BP_W, c.X_WP.p);
  if (event.has_impulse) addKick(link_a, link_b, event.impulse_P.rotated(c.X_WP.R), c.X_WP.p, placement, contacts);
  FrictionMemory memory = c.force.memory;
  const bool touched = pair.friction.touching != 0;
  memory.elastic_energy = contact_model ? 0.5 * c.law.material.stiffness * c.volume.volume * c.volume.depth
                                        : elasticEnergy(c.volume, c.law.material.stiffness, workspace);
  if (model.settings.energy_ledger) noteContact(index, pair, c, event, contacts);
  pair.friction = memory;
  ContactReport contact = reportOf(model, pair, c.volume, c.X_WP, c.force);
  ReleaseMemory& release = contacts.memory[index].release;
  if (advance.time > 0) reportMean(release, touched, event, advance.time, contact);
  release = releaseOf(c.volume, c.V_AB_P, c.X_WP, c.force);
  if (memory.began != 0) {
    work.noteImpact(-c.V_AB_P.linear.z(), c.law.reduced_mass, advance.time * model.settings.gravity.norm());
  }
  work.reported.tell(index, contact);
  report.flag(contact, c.force.clipped);
  work.clock.end(times.force);
}

/// The memory of each pair of the state: of the last evaluation, or none.
void remember(const State& state, VerletContacts& contacts) noexcept {
  ++contacts.evaluations;
  for (const int i : state.pairs.awake()) {
    PairMemory& memory = contacts.memory[i];
    if (memory.key != state.pairs[i].key || memory.evaluation + 1 != contacts.evaluations) memory = PairMemory{};
    memory.key = state.pairs[i].key;
    memory.evaluation = contacts.evaluations;
  }
}

}  // namespace

VerletContacts::VerletContacts(const Model& model) : on_link(model.links.size()), kick(model.links.size()) {
  memory.resize(model.pair_capacity), booked.reserve(model.pair_capacity);
}

void evaluateContacts(const Model& model, ContactModel contact_model, const Advance& advance, State& state, Work& work,
                      VerletContacts& contacts, StepReport& report) noexcept {
  contacts.booked.clear();
  contacts.has_kick = false;
  remember(state, contacts);
  work.clock.end(report.stages.search);
  countContacts(model, state, contacts.on_link);
  Seams& seams = work.contacts.seams;
  if (seams.any()) seams.find(state.pairs.data(), state.pairs.awake(), work.placement.X_WS.data(), work.contacts.workspace);
  for (const int i : state.pairs.awake()) evaluatePair(model, contact_model, i, advance, state, work, contacts, report);
}

}  // namespace haptic::comparators
