#include "velocity_verlet.h"

#include <algorithm>

#include "haptic_core/stepping/flow.h"
#include "haptic_core/world/link_forces.h"
#include "haptic_core/world/pair_search.h"
#include "point_contact.h"
#include "verlet_memory.h"

namespace haptic::comparators {
namespace {

class VelocityVerlet : public Comparator {
 public:
  VelocityVerlet(const Model& model, ContactModel contact_model)
      : contact_model_(contact_model), contacts_(model), pull_(model.nv), v_half_(model.nv), v_ahead_(model.nv), q_(model.nq), v_(model.nv),
        primed_(model.trees.size()), forces_(model.forces.size()) {
    for (const ModelTree& tree : model.trees) scratch_.fit(*tree.model);
  }

  void advance(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept override;

 private:
  /// A force element at the start of the step, for the ledger.
  struct ForceStart {
    double taken = 0;  ///< [W]
    Wrench F_W;        ///< on B about p_WB
  };

  SteppedTree inPlace(const Model& model, const ModelTree& tree, State& state, Work& work) noexcept;
  void finish(const Model& model, const ModelTree& tree, double h, State& state, Work& work) noexcept;
  bool isPrimed(const Model& model, const ModelTree& tree, const State& state) const noexcept;
  void prime(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept;
  void evaluate(const Model& model, double h, bool advances, State& state, Work& work, StepReport& report) noexcept;
  void pullCoupled(const Model& model, double h, bool advances, State& state, Work& work) const noexcept;
  void lookAhead(const Model& model, double h, State& state, Work& work) noexcept;
  void noteForces(const Model& model, const Work& work) noexcept;
  void bookForces(const Model& model, double h, const Work& work, State& state) const noexcept;

  ContactModel contact_model_;
  VerletContacts contacts_;
  /// By world velocity index: see SteppedTree; v_ahead: after the next half kick.
  std::vector<double> pull_, v_half_, v_ahead_;
  std::vector<double> q_, v_;  ///< where the last step ended: what is elsewhere now was put there
  std::vector<char> primed_;   ///< by tree: `pull_` is that of q_ and v_
  std::vector<ForceStart> forces_;
  TreeStepScratch scratch_;
};

auto movesOf(const Model& model, const HandWork& hands) {
  return [&model, &hands](int tree) { return hands.movesByItself(model.trees[tree]); };
}

/// v += dt M⁻¹ pull at the poses in `work`. Not of joints with laws.
void kick(const SteppedTree& tree, double dt) noexcept {
  if (!tree.model->isFreeBody()) {
    for (int i = 0; i < tree.model->nv(); ++i) tree.v[i] += dt * tree.pull[i];
    return;
  }
  const Matrix3& R = tree.work->X_WL.R;
  Eigen::Map<Vector6>(tree.v).head<3>() += dt * (R * (tree.model->link(0).I_O_inverse * (R.transpose() * Eigen::Map<Vector3>(tree.pull))));
  Eigen::Map<Vector6>(tree.v).tail<3>() += dt * Eigen::Map<Vector3>(tree.pull + 3);
}

SteppedTree VelocityVerlet::inPlace(const Model& model, const ModelTree& tree, State& state, Work& work) noexcept {
  SteppedTree stepped = stepping::inPlace(model, tree, state, work);
  stepped.pull = pull_.data() + tree.v;  // which it keeps from one step to the next
  stepped.half = v_half_.data() + tree.v;
  return stepped;
}

/// Ends the step of a tree, with the impulses of events about the links' origins.
void VelocityVerlet::finish(const Model& model, const ModelTree& tree, double h, State& state, Work& work) noexcept {
  SteppedTree stepped = inPlace(model, tree, state, work);
  const Vector3& gravity = model.settings.gravity;
  const Wrench* events = contacts_.has_kick ? contacts_.kick.data() + tree.link : nullptr;
  if (stepped.motion) {  // events pull in the next step
    readPull(stepped, gravity, scratch_);
    for (int i = 0; events && i < tree.model->linkCount(); ++i) {
      addGeneralisedForce(*tree.model, stepped.work, i, events[i] * (1 / h), stepped.work[i].p_WO, stepped.pull);
    }
    return;
  }
  finishVerlet(stepped, gravity, h, scratch_);
  if (!events) return;
  for (int i = 0; i < tree.model->linkCount(); ++i) stepped.work[i].F_ext = events[i];
  stepped.pull = v_ahead_.data() + tree.v;  // scratch
  readPull(stepped, Vector3::Zero(), scratch_);
  kick(stepped, 1);
  forwardVelocities(*tree.model, stepped.v, stepped.work);
}

/// The velocities after the next half kick.
void VelocityVerlet::lookAhead(const Model& model, double h, State& state, Work& work) noexcept {
  std::copy(state.v.begin(), state.v.end(), v_ahead_.begin());
  for (const ModelTree* tree : work.hands.movers) {
    if (tree->has_laws) continue;
    SteppedTree ahead = inPlace(model, *tree, state, work);
    ahead.v = v_ahead_.data() + tree->v;
    kick(ahead, h / 2);
  }
}

/// Virtual couplings pull at their links. Of a link that another hand holds nothing is booked: its energy is that hand's.
void VelocityVerlet::pullCoupled(const Model& model, double h, bool advances, State& state, Work& work) const noexcept {
  HandWork& hands = work.hands;
  for (const int i : hands.acting) {
    const PointerState& pointer = state.pointers[i];
    if (model.holds(i)) continue;
    LinkWork& link = work.placement.link[pointer.link];
    const Pose X_LP = model.pointerFrame(i, pointer.link);
    const Vector3 p_WP = link.X_WL * X_LP.p;
    const Wrench F_W = couplingForce(hands.coupling[i], X_LP, hands.goal[i], link);
    link.addWrench(F_W, p_WP);
    if (!advances) continue;
    if (hands.held_by[pointer.link] < 0) state.energy.external += h * power(F_W, link.twistAt(p_WP));
    hands.wrench[i] += -F_W;
  }
}

/// Contacts and pulls here and now, at the end of a step or, with time 0, at the start of the first one.
void VelocityVerlet::evaluate(const Model& model, double h, bool advances, State& state, Work& work,
                              StepReport& report) noexcept {
  work.clock.end(report.stages.motion);
  stepping::lookForPairs(model, 0, state, work, report);
  Advance advance;
  advance.time = advances ? h : 0;
  evaluateContacts(model, contact_model_, advance, state, work, contacts_, report);
  pullCoupled(model, h, advances, state, work);
  LinkWork* link = work.placement.link.data();
  eachForce(model, work.visits.trees, movesOf(model, work.hands), [&](int, const ModelForce& force) {
    addForce(forceNow(model, force, link), force.link_a >= 0 ? link + force.link_a : nullptr, link + force.link_b);
  });
  for (const ModelTree* tree : work.hands.movers) addWrenches(model, state, model.indexOf(*tree), link);
}

/// It goes on from where the last step left it, and is pulled at as then.
bool VelocityVerlet::isPrimed(const Model& model, const ModelTree& tree, const State& state) const noexcept {
  const int nq = tree.model->nq(), nv = tree.model->nv(), t = model.indexOf(tree);
  return primed_[t] && state.last_step[t] > 0 && std::equal(q_.begin() + tree.q, q_.begin() + tree.q + nq, state.q.begin() + tree.q) &&
         std::equal(v_.begin() + tree.v, v_.begin() + tree.v + nv, state.v.begin() + tree.v);
}

/// What pulls at trees that begin here.
void VelocityVerlet::prime(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept {
  const std::vector<const ModelTree*>& movers = work.hands.movers;
  for (const ModelTree* tree : movers) primed_[model.indexOf(*tree)] = isPrimed(model, *tree, state);
  const auto primed = [&](const ModelTree* tree) { return primed_[model.indexOf(*tree)] != 0; };
  if (std::all_of(movers.begin(), movers.end(), primed)) return;
  placeTrees(model, work.visits.trees, state, work.placement);
  evaluate(model, h, false, state, work, report);
  for (const ModelTree* tree : movers) {
    if (!primed(tree)) readPull(inPlace(model, *tree, state, work), model.settings.gravity, scratch_);
  }
  if (!model.settings.energy_ledger) return;
  lookAhead(model, h, state, work);
  notePowers(work.ledgerView(model), h, v_ahead_, contacts_, state);
}

void VelocityVerlet::noteForces(const Model& model, const Work& work) noexcept {
  eachForce(model, work.visits.trees, movesOf(model, work.hands), [&](int i, const ModelForce& force) {
    const LinkForce now = forceNow(model, force, work.placement.link.data());
    forces_[i] = {now.taken(), now.onB()};
  });
}

/// Dampers take the mean of their powers at both ends; what is led supplies the mean force along its way.
void VelocityVerlet::bookForces(const Model& model, double h, const Work& work, State& state) const noexcept {
  const auto way = [&](int link, const Vector3& p_W) {
    const int lead = link >= 0 ? work.hands.held_by[link] : -1;
    return lead < 0 ? Twist{} : work.hands.moved[lead].shifted(p_W - work.placement.link[link].X_WL.p);
  };
  eachForce(model, work.visits.trees, movesOf(model, work.hands), [&](int i, const ModelForce& force) {
    const LinkForce now = forceNow(model, force, work.placement.link.data());
    state.energy.damping += h * 0.5 * (forces_[i].taken + now.taken());
    const Wrench mean = forces_[i].F_W * 0.5 + now.onB() * 0.5;
    state.energy.external += power(mean, way(force.link_a, now.p_WA)) - power(mean, way(force.link_b, now.p_WB));
  });
}

void VelocityVerlet::advance(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept {
  prime(model, h, state, work, report);
  const Vector3& gravity = model.settings.gravity;
  const bool books = model.settings.energy_ledger;
  if (books) noteForces(model, work);
  for (const ModelTree* tree : work.hands.movers) {
    stepping::book(startVerlet(inPlace(model, *tree, state, work), gravity, h, scratch_), state, report);
  }
  moveHeld(model, state, work.hands, work.placement);
  for (const int t : work.visits.trees) {  // startVerlet has placed the others
    if (!work.hands.movesByItself(model.trees[t])) placeTree(model.trees[t], state, work.placement);
  }
  evaluate(model, h, true, state, work, report);
  for (const ModelTree* tree : work.hands.movers) {
    finish(model, *tree, h, state, work);
    const int t = model.indexOf(*tree);
    primed_[t] = 1;
    state.last_step[t] = h;
    state.mode[t] = TreeMode::kFlowed;
  }
  q_ = state.q;
  v_ = state.v;
  if (!books) return;
  bookForces(model, h, work, state);
  if (!contacts_.booked.empty()) lookAhead(model, h, state, work);
  bookContacts(work.ledgerView(model), h, v_half_, v_ahead_, contacts_, state);
}

}  // namespace

std::unique_ptr<Comparator> velocityVerlet(const Model& model) { return std::make_unique<VelocityVerlet>(model, nullptr); }
std::unique_ptr<Comparator> pointVerlet(const Model& model) { return std::make_unique<VelocityVerlet>(model, pointContact); }

}  // namespace haptic::comparators
