#include "haptic_core/stepping/led_contacts.h"

#include <algorithm>

#include "haptic_core/geometry/volume/contact_moments.h"
#include "haptic_core/world/contact_evaluation.h"

namespace haptic::stepping {
namespace {

void evaluatePair(const Model& model, int index, double h, State& state, Work& work, StepReport& report) noexcept {
  ActivePair& pair = state.pairs[index];
  work.reported.open(index);
  ContactWork& contacts = work.contacts;
  Placement& placement = work.placement;
  StageTimes& times = report.stages;
  const ContactPlaces places{placement.link.data(), placement.X_WS.data(), work.hands.held_by.data(),
                             work.hands.acting.empty() ? nullptr : work.hands.bound.data(),
                             work.hands.acting.empty() ? nullptr : work.hands.pressed.data()};
  const FrictionMemory before = pair.friction;
  const LedForce last = pair.led;
  const bool touched = before.touching != 0;
  Advance advance;
  advance.time = advance.run = h;
  ContactEvaluation c;
  work.counted.done += model.look(pair.shapeA(), pair.shapeB());
  const bool overlap = evaluateContact(model, contacts.seams, index, pair, places, before, advance, contacts.workspace, c);
  work.clock.end(overlap ? times.volume : times.detection);
  if (!overlap) {
    pair.friction = {};
    if (touched && model.settings.energy_ledger) {
      const Pose X_WP(patchAxes(placement.X_WS[pair.shapeA()].R * before.normal_A), last.p_W);
      bookLed(work.ledgerView(model), h, pair, before, last, X_WP, state);
    }
    pair.led = {};
    pair.buried = false;
    return;
  }
  const int a = pair.shapeA(), b = pair.shapeB();
  if (pair.buried) pair.buried = !(c.volume.depth < model.buriedDepth(a, b, c.volume.A0));
  pair.friction = c.force.memory;
  pair.friction.elastic_energy = elasticEnergy(c.volume, c.law.material.stiffness, contacts.workspace);
  pair.led = {c.X_WP.p, c.force.F_BP_P.rotated(c.X_WP.R), c.force.elastic().rotated(c.X_WP.R)};
  if (model.settings.energy_ledger) bookLed(work.ledgerView(model), h, pair, before, last, c.X_WP, state);
  ContactReport contact = reportOf(model, pair, c.volume, c.X_WP, c.force);
  if (!touched) work.noteImpact(-c.V_AB_P.linear.z(), c.law.reduced_mass, h * model.settings.gravity.norm());
  work.reported.tell(index, contact);
  report.flag(contact, c.force.clipped);
  work.clock.end(times.force);
}

}  // namespace

void evaluateLed(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept {
  const auto moves = [&](int shape) { return work.hands.movesByItself(model.trees[model.treeOf(shape)]); };
  const auto isLed = [&](int i) { return !moves(state.pairs[i].shapeA()) && !moves(state.pairs[i].shapeB()); };
  const std::vector<int>& awake = state.pairs.awake();
  work.clock.end(report.stages.search);
  if (std::none_of(awake.begin(), awake.end(), isLed)) return;
  Seams& seams = work.contacts.seams;
  if (seams.any()) seams.find(state.pairs.data(), awake, work.placement.X_WS.data(), work.contacts.workspace);
  for (const int i : awake) {
    if (isLed(i)) evaluatePair(model, i, h, state, work, report);
  }
}

}  // namespace haptic::stepping
