#include "haptic_core/world/ledger.h"

#include "haptic_core/dynamics/kinematics.h"

namespace haptic {
namespace {

/// Twist at `p_W`; of a link in a hand the mean over the time h.
Twist twistForWork(const LedgerView& view, int link, const Vector3& p_W, double h) noexcept {
  const int pointer = view.hands.held_by[link];
  const LinkWork& place = view.placement.link[link];
  if (pointer < 0) return place.twistAt(p_W);
  Twist moved = view.hands.moved[pointer].shifted(p_W - place.X_WL.p);
  if (!(h > 0)) return Twist{};
  moved.angular /= h;
  moved.linear /= h;
  return moved;
}

/// Of B relative to A at P, in P's axes, at the velocities in the placement.
Twist relativeTwist(const LedgerView& view, const State& state, const BookedContact& contact, double h) noexcept {
  const ActivePair& pair = state.pairs[contact.pair];
  const int a = view.model.shapes[pair.shapeA()].link, b = view.model.shapes[pair.shapeB()].link;
  return (twistForWork(view, b, contact.X_WP.p, h) - twistForWork(view, a, contact.X_WP.p, h))
      .rotated(contact.X_WP.R.transpose());
}

/// Of the trees that explicit steps kick.
void setVelocities(const LedgerView& view, const State& state, const std::vector<double>& v) noexcept {
  for (const ModelTree* tree : view.hands.movers) {
    if (tree->has_laws || state.mode[view.model.indexOf(*tree)] == TreeMode::kImplicit) continue;
    forwardVelocities(*tree->model, v.data() + tree->v, view.placement.link.data() + tree->link);
  }
}

/// The power of each contact's springs and dampers, and its rate towards `v_ahead`; leaves that in the placement.
void measurePowers(const LedgerView& view, double h, const std::vector<double>& v_ahead, BookedContacts& contacts,
                   State& state) noexcept {
  for (BookedContact& contact : contacts) contact.V_AB_P = relativeTwist(view, state, contact, h);
  setVelocities(view, state, v_ahead);
  for (const BookedContact& contact : contacts) {
    const Twist gained = relativeTwist(view, state, contact, h) - contact.V_AB_P;
    FrictionMemory& memory = state.pairs[contact.pair].friction;
    memory.power = contactPower(contact.F_BP_P, contact.elastic_P, contact.V_AB_P);
    memory.power_rate = contactPower(contact.F_BP_P, contact.elastic_P, gained) * (2 / h);
  }
}

void book(const BookedContact& contact, const ContactPower& taken, State& state) noexcept {
  const ActivePair& pair = state.pairs[contact.pair];
  const FrictionMemory& now = pair.friction;
  const double friction = taken.friction - (now.energy - contact.before.energy);
  state.energy.friction += contact.sticking ? 0.0 : friction;
  const double beyond = taken.elastic - (now.elastic_energy - contact.before.elastic_energy);
  state.energy.bookPressure(taken.damping + (contact.sticking ? friction : 0.0), beyond, contact.before, now, pair.buried);
}

}  // namespace

void noteContact(int pair, const ContactEvaluation& c, const FrictionMemory& before, double elastic_energy,
                 FrictionMemory& now, BookedContacts& contacts, EnergyLedger& energy) noexcept {
  now.elastic_energy = elastic_energy;
  energy.elastic += now.elastic_energy;
  energy.tangential += now.energy;
  BookedContact contact;
  contact.pair = pair;
  contact.X_WP = c.X_WP;
  contact.F_BP_P = c.force.F_BP_P;
  contact.elastic_P = c.force.elastic();
  contact.J_BP_P = c.force.impulse_P;
  contact.elastic_impulse_P = c.force.elastic_impulse_P;
  contact.sticking = c.force.sticking;
  contact.before = before;
  contacts.push_back(contact);
}

void bookEuler(const LedgerView& view, double h, const std::vector<double>& v_mean, const BookedContacts& contacts,
               State& state) noexcept {
  setVelocities(view, state, v_mean);
  for (const BookedContact& contact : contacts) {
    const Twist V = relativeTwist(view, state, contact, h);
    book(contact, contactPower(contact.F_BP_P, contact.elastic_P, V) * h, state);
  }
}

void bookVerlet(const LedgerView& view, double h, const std::vector<double>& v_half, const std::vector<double>& v_ahead,
                BookedContacts& contacts, State& state) noexcept {
  if (contacts.empty()) return;
  measurePowers(view, h, v_ahead, contacts, state);
  setVelocities(view, state, v_half);
  for (const BookedContact& contact : contacts) {
    const Twist V_half = relativeTwist(view, state, contact, h);
    const Twist V_mean{0.5 * (V_half.angular + contact.V_AB_P.angular), 0.5 * (V_half.linear + contact.V_AB_P.linear)};
    const ContactPower second = contactPower(contact.F_BP_P * (h / 2) + contact.J_BP_P,
                                             contact.elastic_P * (h / 2) + contact.elastic_impulse_P, V_mean);
    book(contact, contact.before.power * (h / 2) + contact.before.power_rate * (h * h / 8) + second, state);
  }
  setVelocities(view, state, state.v);
}

void notePowers(const LedgerView& view, double h, const std::vector<double>& v_ahead, BookedContacts& contacts,
                State& state) noexcept {
  measurePowers(view, h, v_ahead, contacts, state);
  setVelocities(view, state, state.v);
}

void bookRelease(const FrictionMemory& last, double h, double tau, double order, EnergySums& sums) noexcept {
  const ContactPower taken = last.power * (tau / (order + 1)) +
                             last.power_rate * (h * h / 8 + (tau / (order + 1) - h / 2) * h / 2);
  sums.damping += taken.damping + (last.sliding != 0 ? 0.0 : taken.friction + last.energy);
  sums.friction += last.sliding != 0 ? taken.friction + last.energy : 0.0;
  sums.bookTurning(taken.elastic + last.elastic_energy, last, FrictionMemory{});
}

MechanicalEnergy mechanicalEnergy(const Model& model, const HandWork& hands, const Placement& placement) noexcept {
  MechanicalEnergy sum;
  for (const ModelTree* tree : hands.movers) {  // a held link's energy is the hand's
    const LinkWork* link = placement.link.data() + tree->link;
    sum.kinetic += kineticEnergy(*tree->model, link);
    sum.potential += potentialEnergy(*tree->model, link, model.settings.gravity);
  }
  return sum;
}

void closeLedger(const LedgerView& view, double unaccounted, State& state, EnergyLedger& energy) noexcept {
  const MechanicalEnergy now = mechanicalEnergy(view.model, view.hands, view.placement);
  energy.kinetic = now.kinetic;
  energy.potential = now.potential;
  energy.damping = state.energy.damping;
  energy.friction = state.energy.friction;
  energy.external = state.energy.external;
  energy.turning = state.energy.turning;
  const double balance = energy.balance();
  if (state.energy.balanced) {
    state.energy.lost += state.energy.balance - balance;
  } else {
    state.energy.lost += unaccounted - state.energy.unaccounted();
    state.energy.supply += energy.elastic + energy.tangential;
  }
  state.energy.balance = balance;
  state.energy.balanced = true;
  energy.numerical = state.energy.lost + state.energy.still;
}

}  // namespace haptic
