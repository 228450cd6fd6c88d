#include "haptic_core/dynamics/kinematics.h"
#include "verlet_memory.h"

namespace haptic::comparators {
namespace {

/// Who moves a link, and so by which velocities a contact takes from it.
enum class Mover : unsigned char { kHand, kKicks, kLaws };

Mover moverOf(const LedgerView& view, int link) noexcept {
  if (view.hands.held_by[link] >= 0) return Mover::kHand;
  return view.model.trees[view.model.links[link].articulation].has_laws ? Mover::kLaws : Mover::kKicks;
}

bool involves(const LedgerView& view, Mover mover, const ActivePair& pair) noexcept {
  return moverOf(view, view.model.shapes[pair.shapeA()].link) == mover ||
         moverOf(view, view.model.shapes[pair.shapeB()].link) == mover;
}

/// What `of` says of the pair's links that `mover` moves, B's less A's, in P's axes.
template <class Of>
Twist relative(const LedgerView& view, Mover mover, const ActivePair& pair, const Pose& X_WP,
               Of&& of) noexcept {
  const int a = view.model.shapes[pair.shapeA()].link, b = view.model.shapes[pair.shapeB()].link;
  Twist V_W;
  if (moverOf(view, b) == mover) V_W = of(b);
  if (moverOf(view, a) == mover) V_W = V_W - of(a);
  return V_W.rotated(X_WP.R.transpose());
}

/// Of B relative to A at P, in P's axes, by `mover` alone, at the velocities in the placement.
Twist twistBy(const LedgerView& view, Mover mover, const ActivePair& pair, const Pose& X_WP) noexcept {
  return relative(view, mover, pair, X_WP,
                  [&](int link) { return view.placement.link[link].twistAt(X_WP.p); });
}

/// How hands and belts moved B's surface relative to A's at P in this part, in P's axes [rad], [m]. `share`: of that motion of hands
/// that is over at P.
Twist led(const LedgerView& view, double h, const ActivePair& pair, const Pose& X_WP, double share) noexcept {
  const Twist belt = beltTwist(view.model, pair.shapeA(), pair.shapeB(), view.placement.link.data(), X_WP);
  return relative(view, Mover::kHand, pair, X_WP, [&](int link) {
    const Twist& moved = view.hands.moved[view.hands.held_by[link]];
    return moved.shifted(X_WP.p - (view.placement.link[link].X_WL.p - (1 - share) * moved.linear));
  }) + Twist{h * belt.angular, h * belt.linear};
}

/// Something works on the pair that is no body of the world: a lead, or a belt.
bool isSupplied(const LedgerView& view, const ActivePair& pair) noexcept {
  const auto runs = [&](int shape) { return view.model.shapes[shape].belt.moves(); };
  return involves(view, Mover::kHand, pair) || (view.model.has_belts && (runs(pair.shapeA()) || runs(pair.shapeB())));
}

/// Of the trees that kicks move.
void setVelocities(const LedgerView& view, const std::vector<double>& v) noexcept {
  for (const ModelTree* tree : view.hands.movers) {
    forwardVelocities(*tree->model, v.data() + tree->v, view.placement.link.data() + tree->link);
  }
}

/// The power of each contact's springs and dampers on what kicks move, and its rate towards `v_ahead`; leaves
/// that in the placement.
void measurePowers(const LedgerView& view, double h, const std::vector<double>& v_ahead,
                   VerletContacts& contacts, State& state) noexcept {
  for (BookedContact& contact : contacts.booked) {
    contact.V_AB_P = twistBy(view, Mover::kKicks, state.pairs[contact.pair], contact.X_WP);
  }
  setVelocities(view, v_ahead);
  for (const BookedContact& contact : contacts.booked) {
    if (contact.parted) continue;
    const ActivePair& pair = state.pairs[contact.pair];
    PairMemory& memory = contacts.memory[contact.pair];
    const Twist gained = twistBy(view, Mover::kKicks, pair, contact.X_WP) - contact.V_AB_P;
    memory.power = contactPower(contact.F_BP_P, contact.elastic_P, contact.V_AB_P);
    memory.power_rate = contactPower(contact.F_BP_P, contact.elastic_P, gained) * (2 / h);
  }
}

/// Energy that the impulses of a contact took from kicked bodies: half a kick by the last force, half of one and
/// events by the new.
ContactPower fromKicks(const LedgerView& view, double h, const BookedContact& contact,
                       const State& state) noexcept {
  const Twist V = twistBy(view, Mover::kKicks, state.pairs[contact.pair], contact.X_WP) + contact.V_AB_P;
  const ContactPower second = contactPower(contact.F_BP_P * (h / 2) + contact.J_BP_P,
                                           contact.elastic_P * (h / 2) + contact.elastic_impulse_P, V);
  return contact.last.power * (h / 2) + contact.last.power_rate * (h * h / 8) + second * 0.5;
}

/// Power of the force of the last evaluation at a twist, in P's axes, or along a way.
ContactPower byLast(const ReleaseMemory& last, const Twist& V_AB_P) noexcept {
  const Matrix3 R_PW = last.X_WP.R.transpose();
  return contactPower(last.F_BP_W.rotated(R_PW), last.elastic_W.rotated(R_PW), V_AB_P);
}

/// Energy that they took from joints with laws, which the last force has pulled at over the whole step. Events pull
/// in the next one: they are booked at the velocities of this.
ContactPower fromLaws(const LedgerView& view, double h, const BookedContact& contact,
                      const State& state) noexcept {
  const ActivePair& pair = state.pairs[contact.pair];
  const Twist V = twistBy(view, Mover::kLaws, pair, contact.X_WP);
  const ContactPower events = contactPower(contact.J_BP_P, contact.elastic_impulse_P, V);
  if (contact.before.touching == 0) return events;
  return byLast(contact.last.release, twistBy(view, Mover::kLaws, pair, contact.last.release.X_WP)) * h + events;
}

/// Energy that the mean wrench of the step took from hands along their way: by the trapezoidal rule, corrected for
/// events.
ContactPower fromHands(const LedgerView& view, double h, const BookedContact& contact,
                       const State& state) noexcept {
  const ActivePair& pair = state.pairs[contact.pair];
  const Wrench F_P = contact.F_BP_P * 0.5 + contact.J_BP_P * (1 / h);
  const Wrench elastic_P = contact.elastic_P * 0.5 + contact.elastic_impulse_P * (1 / h);
  const Twist moved = led(view, h, pair, contact.X_WP, contact.parted ? 0 : 1);
  const ContactPower now = contactPower(F_P, elastic_P, moved);
  if (contact.before.touching == 0) return now;
  return byLast(contact.last.release, led(view, h, pair, contact.last.release.X_WP, 0)) * 0.5 + now;
}

/// Adds the energy that the contact took from hands, which they supplied.
void supply(const ContactPower& from_hands, ContactPower& taken, EnergySums& sums) noexcept {
  sums.external += from_hands.elastic + from_hands.damping + from_hands.friction;
  taken = taken + from_hands;
}

void book(const BookedContact& contact, const ContactPower& taken, State& state) noexcept {
  const ActivePair& pair = state.pairs[contact.pair];
  const FrictionMemory& now = pair.friction;
  const double friction = taken.friction - (now.energy - contact.before.energy);
  state.energy.friction += contact.sticking ? 0.0 : friction;
  const double beyond = taken.elastic - (now.elastic_energy - contact.before.elastic_energy);
  state.energy.bookPressure(taken.damping + (contact.sticking ? friction : 0.0), beyond, contact.before, now,
                            pair.buried);
}

}  // namespace

void bookContacts(const LedgerView& view, double h, const std::vector<double>& v_half, const std::vector<double>& v_ahead,
                  VerletContacts& contacts, State& state) noexcept {
  if (contacts.booked.empty()) return;
  measurePowers(view, h, v_ahead, contacts, state);
  setVelocities(view, v_half);
  for (const BookedContact& contact : contacts.booked) {
    const ActivePair& pair = state.pairs[contact.pair];
    ContactPower taken = fromKicks(view, h, contact, state);
    if (involves(view, Mover::kLaws, pair)) taken = taken + fromLaws(view, h, contact, state);
    if (isSupplied(view, pair)) supply(fromHands(view, h, contact, state), taken, state.energy);
    book(contact, taken, state);
  }
  setVelocities(view, state.v);
}

void notePowers(const LedgerView& view, double h, const std::vector<double>& v_ahead, VerletContacts& contacts, State& state) noexcept {
  measurePowers(view, h, v_ahead, contacts, state);
  setVelocities(view, state.v);
}

}  // namespace haptic::comparators
