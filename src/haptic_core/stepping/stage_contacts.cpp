#include "haptic_core/stepping/stage_contacts.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/volume/contact_moments.h"
#include "haptic_core/world/counted_work.h"

namespace haptic {

StageContacts::StageContacts(const Model& model, FrozenProblem& problem)
    : model_(model), settings_(model.settings), problem_(problem) {
  slot_.resize(model.pair_capacity);
  near_.resize(model.pair_capacity);
  gap_.resize(model.pair_capacity);
  contacts_.reserve(problem.contacts.capacity());
  brushes_.reserve(problem.contacts.capacity());
  model.reserve(workspace_);
}

void StageContacts::select(const Island& island) noexcept {
  island_ = island;
  contacts_.clear();
}

void StageContacts::clear(const FrictionMemory* memory, const Yielding* yielding, double g, double run,
                          double since) noexcept {
  memory_ = memory;
  yielding_ = yielding;
  g_ = g;
  run_ = run;
  since_ = since;
  reach_ = 0;
  aside_ = 0;
  contacts_.clear();
  problem_.contacts.clear();
  for (int i = 0; i < island_.pair_count; ++i) slot_[island_.pairs[i]] = near_[island_.pairs[i]] = -1;
}

double StageContacts::springEnergy() const noexcept {
  double sum = 0;
  for (const ImplicitContact& c : contacts_) sum += c.touching ? c.elastic + c.force.memory.energy : 0.0;
  return sum;
}

double StageContacts::evaluate(const std::vector<char>& moved, const StageTolerance& tolerance, double changed) noexcept {
  double looks = 0;
  reach_ = g_ * changed;
  if (seams_->any()) {
    seams_->find(state_->pairs.data(), island_.pairs, island_.pair_count, places_.X_WS, workspace_);
    looks += units::kSeams * island_.pair_count;
  }
  const int aside = contacts_.size();
  for (int i = 0; i < island_.pair_count; ++i) {
    const ActivePair& pair = state_->pairs[island_.pairs[i]];
    if (!moved[treeOf(pair.shapeA())] && !moved[treeOf(pair.shapeB())]) continue;
    const int slot = slot_[island_.pairs[i]];
    if (slot >= 0 && contacts_[slot].touching && staysValid(slot, tolerance)) {
      problem_.contacts[slot].V_reference = problem_.contacts[slot].V;
    } else {
      looks += model_.shapes[pair.shapeA()].look + model_.shapes[pair.shapeB()].look;
      evaluatePair(island_.pairs[i]);
    }
  }
  for (int i = 0; i < aside; ++i) {
    const FrozenContact& c = problem_.contacts[i];
    if (contacts_[i].touching || slot_[contacts_[i].pair] == i || near_[contacts_[i].pair] == i) continue;
    if (moved[model_.links[c.link_a].articulation] || moved[model_.links[c.link_b].articulation]) part(i);
  }
  return looks;
}

bool StageContacts::hold(const StageTolerance& tolerance, const double* u) const noexcept {
  for (int i = 0; i < island_.pair_count; ++i) {
    const int index = island_.pairs[i], slot = slot_[index];
    if (slot >= 0) {
      if (!contacts_[slot].touching || !staysValid(slot, tolerance)) return false;
      continue;
    }
    const ActivePair& pair = state_->pairs[index];
    double closing = 0;
    for (const int shape : {pair.shapeA(), pair.shapeB()}) {
      if (problem_.nodeOf(model_.shapes[shape].link) >= 0) closing += problem_.speedOf(treeOf(shape), u);
    }
    if (gap_[index] < M_SQRT2 * g_ * closing) return false;
  }
  return true;
}

/// True if a patch still answers as a new one would: the error of its frozen geometry, of second order in the way
/// along n and of first order in the turn of n, is small against the tolerance, as a speed and as an energy.
bool StageContacts::staysValid(int slot, const StageTolerance& tolerance) const noexcept {
  const FrozenContact& c = problem_.contacts[slot];
  const ImplicitContact& contact = contacts_[slot];
  const double mass = std::min(problem_.massOf(c.link_a), problem_.massOf(c.link_b));
  const Vector6 change = c.V - c.V_frozen;
  const double depth = contact.volume.volume / std::max(contact.volume.A0, contact.volume.volume / contact.volume.depth);
  const double turn = g_ * (change.head<3>().norm() + change.segment<2>(3).norm() / c.patch.extent());
  const double missed = c.patch.missedDepth(change, depth);
  return missed / g_ + c.force.normal * g_ / mass * turn <= kStays * tolerance.speed &&
         c.patch.stiffness() * missed * missed <= kStays * tolerance.energy;
}

/// Leaves a contact and its frozen patch behind, or parts those that an earlier pass left.
void StageContacts::evaluatePair(int index) noexcept {
  ActivePair& pair = state_->pairs[index];
  const int shape_a = pair.shapeA(), shape_b = pair.shapeB();
  const Pose X_AB = relativePose(places_.X_WS[shape_a], places_.X_WS[shape_b]);
  const auto separating = [&]() -> Vector3 { return places_.X_WS[shape_a].R.transpose() * pair.cache.direction; };  // in A's axes
  Advance advance;
  advance.time = g_;
  advance.yielding = yielding_[index];
  advance.run = run_;
  advance.since = since_;
  advance.mean_rate = settings_.attempts == Attempts::kImplicitEuler;  // SDIRK2's rates, its stand-in's too, are the end's
  ContactEvaluation found;
  int& slot = slot_[index];
  if (!evaluateContact(model_, *seams_, index, pair, places_, memory_[index], advance, workspace_, found)) {
    gap_[index] = -found.volume.depth;
    if (reach_ > 0 && lookAtFaces(index, X_AB, separating())) {
      if (slot >= 0) leave(slot);
      return;
    }
    if (slot >= 0) part(slot);
    if (reach_ > 0) lookAhead(index, X_AB, separating());
    return;
  }
  const bool known = slot >= 0;
  if (!known) slot = addSlot();
  ImplicitContact& contact = contacts_[slot];
  FrozenContact& frozen = problem_.contacts[slot];
  contact.pair = index;
  contact.shape_a = shape_a;
  contact.shape_b = shape_b;
  contact.volume = found.volume;
  contact.touching = true;
  contact.X_WP = found.X_WP;
  contact.force = found.force;
  const double k = found.law.material.stiffness;
  contact.elastic = elasticEnergy(found.volume, k, workspace_);
  if (known) before_ = frozen;
  frozen.link_a = model_.shapes[shape_a].link;
  frozen.link_b = model_.shapes[shape_b].link;
  frozen.X_WP = contact.X_WP;
  frozen.V_reference = frozen.V_frozen = found.V_AB_P.vector();
  frozen.ends_here = false;
  frozen.F_done << found.force.F_BP_P.torque, found.force.F_BP_P.force;
  const double squares = 2 * contact.elastic / k;  // ∫d² dA [m⁴]
  frozen.patch.freeze(found.volume, squares, contact.force, found.law, frozen.V_reference, g_);
  if (!(reach_ > 0)) return;
  const ConvexShape &A = *model_.shapes[shape_a].shape, &B = *model_.shapes[shape_b].shape;
  FaceOverlay faces;
  if (faces.find(A, B, X_AB, found.volume.X_AP) && frozen.patch.spread(faces, frozen.V_reference)) {
    if (near_[index] >= 0) leave(near_[index]);
    return;
  }
  if (known && before_.patch.isElsewhere(frozen.patch)) keepAside(index, before_);
  if (found.volume.depth < reach_) lookAhead(index, X_AB, found.volume.normal());
}

/// Room for a contact in both lists. A pair's own always has it.
int StageContacts::addSlot() noexcept {
  const int slot = contacts_.size();
  contacts_.resize(slot + 1);
  problem_.contacts.resize(slot + 1);
  return slot;
}

/// Room for a patch beside those of the pairs that touch; -1: there is none.
int StageContacts::addAside() noexcept {
  if (aside_ == static_cast<int>(contacts_.capacity()) - model_.pair_capacity) return -1;
  ++aside_;
  return addSlot();
}

/// A patch that stands at X_WP moves as the links do there, and the belts on them.
void StageContacts::placeNear(int pair, FrozenContact& c, const Pose& X_WP) const noexcept {
  c.X_WP = X_WP;
  const Twist V_W = places_.link[c.link_b].twistAt(X_WP.p) - places_.link[c.link_a].twistAt(X_WP.p);
  c.V_reference = (V_W.rotated(X_WP.R.transpose()) + beltOf(pair, X_WP)).vector();
}

Twist StageContacts::beltOf(int pair, const Pose& X_WP) const noexcept {
  return beltTwist(model_, state_->pairs[pair].shapeA(), state_->pairs[pair].shapeB(), places_.link, X_WP);
}

PairLaw StageContacts::lawOf(const ActivePair& pair) const noexcept {
  return haptic::lawOf(model_, places_, pair.shapeA(), pair.shapeB());
}

/// The contact of a pair that is near, not touching, made or reused; null where there is no room.
FrozenContact* StageContacts::nearContact(int index) noexcept {
  int& slot = near_[index];
  if (slot < 0) slot = addAside();
  if (slot < 0) return nullptr;
  const ActivePair& pair = state_->pairs[index];
  contacts_[slot].pair = index;
  contacts_[slot].touching = false;
  FrozenContact& c = problem_.contacts[slot];
  c.link_a = model_.shapes[pair.shapeA()].link;
  c.link_b = model_.shapes[pair.shapeB()].link;
  c.F_done.setZero();
  return &c;
}

/// Puts two faces that look at one another across a gap into the problem. False: there are none.
bool StageContacts::lookAtFaces(int index, const Pose& X_AB, const Vector3& n) noexcept {
  const ActivePair& pair = state_->pairs[index];
  const int shape_a = pair.shapeA(), shape_b = pair.shapeB();
  if (!(n.squaredNorm() > 0)) return false;
  Pose X_AP(patchAxes(n), X_AB.p);
  FaceOverlay faces;
  if (!faces.find(*model_.shapes[shape_a].shape, *model_.shapes[shape_b].shape, X_AB, X_AP)) return false;
  faces.centre(X_AP);
  FrozenContact* c = nearContact(index);
  if (!c) return false;
  placeNear(index, *c, places_.X_WS[shape_a] * X_AP);
  c->patch.freezeNear(faces, lawOf(pair), c->V_reference, g_);
  return true;
}

/// Puts a pair that is nearer than the reach into the problem: `n` [A's frame] from A to B is the way on which it
/// would meet.
void StageContacts::lookAhead(int index, const Pose& X_AB, const Vector3& n) noexcept {
  const ActivePair& pair = state_->pairs[index];
  const int shape_a = pair.shapeA(), shape_b = pair.shapeB();
  if (near_[index] >= 0) leave(near_[index]);
  if (!(n.squaredNorm() > 0)) return;
  PairCache ahead = pair.cache;  // the cache of a look ahead is not the world's
  CacheInA cache(ahead, places_.X_WS[shape_a].R);
  ContactVolume near;
  contactVolume(*model_.shapes[shape_a].shape, *model_.shapes[shape_b].shape, Pose(X_AB.R, X_AB.p - reach_ * n),
                cache, workspace_, near);
  if (near.status != ContactVolume::Status::kOverlap) return;
  FrozenContact* c = nearContact(index);
  if (!c) return;
  placeNear(index, *c, places_.X_WS[shape_a] * near.X_AP);
  c->patch.freezeNear(near, reach_, lawOf(pair), c->V_reference, g_);
}

/// A patch that has gone to another place of its pair still bars the way back: a body that rocks would go on
/// for ever.
void StageContacts::keepAside(int pair, const FrozenContact& c) noexcept {
  const int slot = addAside();
  if (slot < 0) return;
  contacts_[slot].pair = pair;
  problem_.contacts[slot] = c;
  part(slot);
}

/// The pair is in the problem elsewhere.
void StageContacts::leave(int slot) noexcept {
  contacts_[slot].touching = false;
  FrozenContact& c = problem_.contacts[slot];
  c.patch.forget();
  c.F_done.setZero();
}

void StageContacts::part(int slot) noexcept {
  FrozenContact& c = problem_.contacts[slot];
  contacts_[slot].touching = false;
  placeNear(contacts_[slot].pair, c, c.X_WP);
  c.patch.part(c.V_reference);
  c.F_done.setZero();
}

/// Of B relative to A at the patch, in its axes, by twists of their links and what belts carry.
template <class TwistOf>
Twist StageContacts::between(int pair, const FrozenContact& c, TwistOf&& twistOf) const noexcept {
  return (twistOf(c.link_b) - twistOf(c.link_a)).rotated(c.X_WP.R.transpose()) + beltOf(pair, c.X_WP);
}

/// By what hands hold and belts carry alone, a mean over the step.
Twist StageContacts::ofHands(int pair, const FrozenContact& c, const stepping::HeldLinks& held) const noexcept {
  const double share = 1 / held.step;
  return between(pair, c, [&](int link) {
    const Twist way = stepping::ledWay(held, places_.link, link, c.X_WP.p);
    return Twist{share * way.angular, share * way.linear};
  });
}

/// The same as the links were placed.
Twist StageContacts::ofHandsAsPlaced(int pair, const FrozenContact& c) const noexcept {
  return between(pair, c, [&](int link) { return places_.held_by[link] < 0 ? Twist{} : places_.link[link].twistAt(c.X_WP.p); });
}

bool StageContacts::isLed(const FrozenContact& c) const noexcept {
  return places_.held_by[c.link_a] >= 0 || places_.held_by[c.link_b] >= 0 || model_.has_belts;
}

double StageContacts::supply(const stepping::HeldLinks& held) const noexcept {
  double sum = 0;
  for (int i = 0; i < contacts_.size(); ++i) {
    const ImplicitContact& c = contacts_[i];
    const FrozenContact& frozen = problem_.contacts[i];
    if (c.touching && isLed(frozen)) sum -= power(c.force.F_BP_P, ofHands(c.pair, frozen, held));
  }
  return sum;
}

void StageContacts::finish(const double* u, const stepping::HeldLinks& held) noexcept {
  brushes_.clear();
  for (int i = 0; i < contacts_.size(); ++i) {
    ImplicitContact& c = contacts_[i];
    const FrozenContact& frozen = problem_.contacts[i];
    const Wrench done_P{frozen.F_done.head<3>(), frozen.F_done.tail<3>()};
    const bool led = isLed(frozen);
    c.V_led_P = led ? ofHands(c.pair, frozen, held) : Twist{};
    if (!c.touching) {
      if (!frozen.F_done.isZero(0)) brushes_.push_back({c.pair, frozen.X_WP, done_P, c.V_led_P});
      continue;
    }
    const Vector6 V = frozen.ends_here ? frozen.V : Vector6(frozen.V_reference + problem_.twistOf(frozen, u));
    FrozenPatch::Force at_V = frozen.force;
    if (!frozen.ends_here) frozen.patch.evaluate(V, at_V);
    frozen.patch.carry(V, at_V, c.volume.X_AP, c.force, c.elastic);
    c.V_P = Twist{V.head<3>(), V.tail<3>()};
    if (led) c.V_P = c.V_P - ofHandsAsPlaced(c.pair, frozen);
    c.done_P = done_P;
  }
  order();
}

/// Leaves the contacts that touch, in the order of their pairs. Few are out of it: those that a later pass
/// found.
void StageContacts::order() noexcept {
  int count = 0;
  for (int i = 0; i < contacts_.size(); ++i) {
    if (!contacts_[i].touching) continue;
    if (count != i) contacts_[count] = contacts_[i];
    ++count;
  }
  contacts_.resize(count);
  const auto key = [this](int i) { return ActivePair::keyOf(contacts_[i].shape_a, contacts_[i].shape_b); };
  for (int i = 1; i < count; ++i) {
    if (key(i - 1) < key(i)) continue;
    int to = i - 1;
    while (to > 0 && key(to - 1) > key(i)) --to;
    std::rotate(contacts_.begin() + to, contacts_.begin() + i, contacts_.begin() + i + 1);
  }
}

}  // namespace haptic
