#include "haptic_core/world/hands.h"

#include <algorithm>
#include <string>

#include "haptic_core/base/error.h"
#include "haptic_core/world/contact_reports.h"
#include "haptic_core/world/link_forces.h"
#include "haptic_core/world/put.h"

namespace haptic {

HandWork::HandWork(const Model& model)
    : held_by(model.links.size(), -1),
      own_coupling(model.pointers.size()),
      bound(static_cast<std::size_t>(model.leads())),
      pressed(model.links.size(), 0.0),
      coupling(model.pointers.size()),
      goal(static_cast<std::size_t>(model.leads())),
      moved(static_cast<std::size_t>(model.leads())),
      force_error(model.pointers.size()),
      wrench(model.pointers.size()),
      proxy(model) {
  movers.reserve(model.trees.size());
  acting.reserve(model.pointers.size());
  leading.reserve(static_cast<std::size_t>(model.leads()));
}

int ledLink(const Model& model, const State& state, int lead) noexcept {
  const int pointers = static_cast<int>(model.pointers.size());
  return lead < pointers ? state.pointers[lead].link : model.motions[lead - pointers].link;
}

void refreshHands(const Model& model, const State& state, HandWork& hands) noexcept {
  std::fill(hands.held_by.begin(), hands.held_by.end(), -1);
  std::fill(hands.pressed.begin(), hands.pressed.end(), 0.0);
  for (std::size_t i = 0; i < state.pointers.size(); ++i) {
    const int pointer = static_cast<int>(i), link = state.pointers[i].link;
    if (link < 0) continue;
    hands.own_coupling[i] = resolved(model.tuning.coupling[i], model.loadOf(link), model.settings.step,
                                     link != model.pointerHome(pointer));
    hands.coupling[i] = hands.own_coupling[i];
    if (model.holds(pointer)) hands.held_by[link] = pointer;
  }
  for (int lead = static_cast<int>(model.pointers.size()); lead < model.leads(); ++lead) hands.held_by[ledLink(model, state, lead)] = lead;
  hands.movers.clear();
  hands.moving_mass = 0;
  for (const ModelTree& tree : model.trees) {
    if (!hands.movesByItself(tree)) continue;
    hands.movers.push_back(&tree);
    for (int l = 0; l < tree.model->linkCount(); ++l) hands.moving_mass += model.links[tree.link + l].mass;
  }
}

bool canGrab(const Model& model, const HandWork& hands, int pointer, int link) noexcept {
  if (!model.holds(pointer)) return model.links[link].moves;
  const int other = hands.held_by[link];
  return model.trees[model.links[link].articulation].model->isFreeBody() && (other < 0 || other == pointer);
}

void checkGrab(const Model& model, const HandWork& hands, int pointer, int link) {
  if (pointer < 0 || pointer >= static_cast<int>(model.pointers.size()) || link < 0 ||
      link >= static_cast<int>(model.links.size())) {
    throw SetupError("grab", "no pointer " + std::to_string(pointer) + " or no link " + std::to_string(link),
                     "name a pointer and a link of the scene");
  }
  if (canGrab(model, hands, pointer, link)) return;
  const int other = hands.held_by[link], pointers = static_cast<int>(model.pointers.size());
  if (other >= pointers) {
    throw SetupError("grab", "link " + model.links[link].name + " is led along " + model.motions[other - pointers].name,
                     "hold what a motion does not lead");
  }
  if (other >= 0) {
    throw SetupError("grab", "link " + model.links[link].name + " is held by the hand of " + model.pointers[other].device,
                     "let it go there first");
  }
  throw SetupError("grab", "link " + model.links[link].name + " hangs on joints or is fixed",
                   "hold free bodies, or use the virtual coupling");
}

void grab(const Model& model, const Placement& placement, int pointer, int link, State& state, HandWork& hands) noexcept {
  PointerState& hand = state.pointers[pointer];
  const Pose X_WP = placement.link[link].X_WL * model.pointerFrame(pointer, link);
  hand.link = link;
  hand.p_WP = X_WP.p;
  hand.q_WP = Quaternion(X_WP.R);
  hand.targeted = false;
  refreshHands(model, state, hands);
}

void findActing(const Model& model, State& state, HandWork& hands) noexcept {
  hands.acting.clear();
  hands.leading.clear();
  for (int i = 0; i < static_cast<int>(state.pointers.size()); ++i) {
    PointerState& pointer = state.pointers[i];
    const bool acts = pointer.targeted || model.holds(i);
    (acts ? hands.wrench[i] : pointer.F_W) = Wrench{};
    if (acts) hands.acting.push_back(i);
    if (model.holds(i) && pointer.targeted) hands.leading.push_back(i);
  }
  for (int lead = static_cast<int>(model.pointers.size()); lead < model.leads(); ++lead) hands.leading.push_back(lead);
}

void aim(PointerState& pointer, const Pose& X_WP, const Twist& V_WP) noexcept {
  if (!X_WP.p.allFinite() || !X_WP.R.allFinite() || !V_WP.angular.allFinite() || !V_WP.linear.allFinite()) return;
  pointer.p_WP = X_WP.p;
  pointer.q_WP = Quaternion(X_WP.R);
  pointer.V_WP = V_WP;
  if (!pointer.targeted) pointer.pull_W = Wrench{}, pointer.pulled_W = Twist{};  // of an earlier pull, perhaps on another link
  pointer.targeted = true;
}

namespace {

HeldGoal goalAt(const Model& model, int lead, double time, const State& state) noexcept {
  const std::size_t motion = static_cast<std::size_t>(lead) - model.pointers.size();
  const MotionPoint point = motionAt(model.motions[motion], state.motions[motion], time);
  HeldGoal goal;
  goal.p_WL = point.p_WL;
  goal.q_WL = point.q_WL;
  goal.V_WL = point.V_WL;
  return goal;
}

void moveLed(const Model& model, int link, const HeldGoal& goal, Twist& moved, State& state, Placement& placement) noexcept {
  const Vector3 p_before = placement.link[link].X_WL.p;
  const ModelTree& tree = model.trees[model.links[link].articulation];
  double* q = state.q.data() + tree.q;
  double* v = state.v.data() + tree.v;
  const Quaternion from(q[3], q[4], q[5], q[6]);
  const Vector3 turn = vectorFromRotation(goal.q_WL * from.conjugate());
  const Quaternion to = (rotationFromVector(turn) * from).normalized();
  moved = {turn, goal.p_WL - p_before};
  putFree(tree.model->link(0).p_LO, goal.p_WL, to, goal.V_WL, q, v);
  state.last_step[model.links[link].articulation] = 0;  // once let go it begins anew
  placeTree(tree, state, placement);
}

}  // namespace

void aimMotions(const Model& model, double h, const State& state, HandWork& hands) noexcept {
  for (int lead = static_cast<int>(model.pointers.size()); lead < model.leads(); ++lead) {
    hands.goal[lead] = goalAt(model, lead, state.time + h, state);
  }
}

void moveHeld(const Model& model, State& state, HandWork& hands, Placement& placement) noexcept {
  for (const int i : hands.acting) hands.moved[i] = {};
  for (const int lead : hands.leading) moveLed(model, ledLink(model, state, lead), hands.goal[lead], hands.moved[lead], state, placement);
}

CouplingMatrices matricesOf(const PointerCoupling& c, const Matrix3& R_WP, const Matrix3& R_WT) noexcept {
  const Matrix3& R = c.axes == PointerCoupling::Axes::kLink ? R_WP : R_WT;
  return {c.stiffness * c.along_stiffness.in(R), c.damping * c.along_damping.in(R), c.rotational_stiffness * c.about_stiffness.in(R),
          c.rotational_damping * c.about_damping.in(R)};
}

Wrench couplingForce(const PointerCoupling& c, const Pose& X_LP, const HeldGoal& T, const LinkWork& link) noexcept {
  const Pose X_WP = link.X_WL * X_LP;
  const Matrix3 R_WT = T.q_WL.toRotationMatrix();
  const Vector3 p_TP = R_WT * X_LP.p;
  const Twist V = link.twistAt(X_WP.p), V_WT = T.V_WL.shifted(p_TP);
  const Vector3 turn = vectorFromRotation(T.q_WL * Quaternion(link.X_WL.R).conjugate());
  const CouplingMatrices m = matricesOf(c, X_WP.R, R_WT * X_LP.R);
  return {m.rotational_stiffness * turn + m.rotational_damping * (V_WT.angular - V.angular),
          m.stiffness * (T.p_WL + p_TP - X_WP.p) + m.damping * (V_WT.linear - V.linear)};
}

void collectHeld(const Model& model, const ContactReports& contacts, const Placement& placement, State& state, HandWork& hands) noexcept {
  const int pointers = static_cast<int>(model.pointers.size());
  const bool any = model.leads() > pointers || std::any_of(hands.acting.begin(), hands.acting.end(), [&](int i) { return model.holds(i); });
  if (!any) return;
  const auto give = [&](int link, const Wrench& F_W, const Vector3& p_W) {
    const int lead = link >= 0 ? hands.held_by[link] : -1;
    if (lead < 0) return;
    const Pose& X_WL = placement.link[link].X_WL;
    const Wrench F_WL = F_W.shifted(X_WL.p - p_W);
    if (!model.settings.energy_ledger) state.energy.external -= power(F_WL, hands.moved[lead]);
    if (lead < pointers) hands.wrench[lead] += F_WL.shifted(X_WL.R * model.pointerFrame(lead, link).p);
  };
  for (const int slot : state.pairs.awake()) {
    if (!contacts.touches(slot)) continue;
    const ContactReport& contact = contacts[slot];
    give(contact.link_a, -contact.F_BP_W, contact.X_WP.p);
    give(contact.link_b, contact.F_BP_W, contact.X_WP.p);
  }
  for (const ModelForce& force : model.forces) {
    const auto moves = [&](int tree) { return tree >= 0 && hands.movesByItself(model.trees[tree]); };
    if (!moves(force.tree_a) && !moves(force.tree_b)) continue;
    const LinkForce now = forceNow(model, force, placement.link.data());
    give(force.link_a, -now.onB(), now.p_WA);
    give(force.link_b, now.onB(), now.p_WB);
  }
}

void tellHands(bool stopped, double wrench_error, HandWork& hands, State& state) noexcept {
  for (const int i : hands.acting) {
    PointerState& pointer = state.pointers[i];
    const Vector3 before = pointer.F_W.force;
    pointer.F_W = stopped ? Wrench{} : hands.wrench[i];
    // The mean of a force that goes from one value to another, taken at one of its ends; and the wrench that a solve left out of balance.
    hands.force_error[i] = 0.5 * (pointer.F_W.force - before).norm() + wrench_error;
  }
}

}  // namespace haptic
