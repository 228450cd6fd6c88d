#include "haptic_core/stepping/implicit_stage.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/dynamics/joint_space_inertia.h"
#include "haptic_core/stepping/standing_islands.h"
#include "haptic_core/world/applied_wrench.h"
#include "haptic_core/world/hands.h"

namespace haptic {
namespace {

/// Changes that shrink no more, but are this small already, are rounding in a stiff contact.
constexpr double kStagnation = 1e-9;
/// Newton steps of a pass: passes contract by 5–20 each, so that more of them beat longer ones.
constexpr int kStepsOfPass = 4;
/// Without contacts a pass costs little, and there is nothing that ends it but rounding: share of the
/// tolerance then.
constexpr double kContactFree = 1e-8;
constexpr int kContactFreePasses = 3,
              kAlonePasses = 7;  ///< alone: not even a pair is near, no geometry is asked
/// Weight of what gravity adds to speeds in a step, beside the change of the step: what lies has no change,
/// and must come to rest all the same. With 1, a dropped cube still moves by 1e-7 m after a second.
constexpr double kFree = 1e-2;
/// Way, as a share of the smallest body's size, that the error of a step may amount to.
constexpr double kOfSize = 1e-4;
/// Share of v that is left where no reference had little enough energy. Then nothing is left: what stands has
/// none.
constexpr double kSlower = 0.3;

}  // namespace

ImplicitStage::ImplicitStage(const Model& model)
    : model_(model), settings_(model.settings), joints_(model), problem_(model), contacts_(model, problem_),
      limit_(model, problem_, contacts_) {
  couplings.resize(model.pointers.size());
  force_.resize(model.forces.size());
  q_base.resize(model.nq);
  q_.resize(model.nq);
  for (auto* vector : {&v_base, &v, &before_, &residual_, &v_dot_, &calm_}) vector->resize(model.nv);
  tree_energy_.resize(model.trees.size());
  memory_base.resize(model.pair_capacity);
  yielding.resize(model.pair_capacity);
  moved_.resize(model.trees.size());
  work_.resize(model.links.size());
  held_by_.resize(model.links.size());
  X_WS_.resize(model.shapes.size());
  for (const ModelTree& tree : model.trees) {
    const auto first = std::find_if(model.shapes.begin(), model.shapes.end(),
                                    [&](const ModelShape& shape) { return shape.link >= tree.link; });
    first_shape_.push_back(static_cast<int>(first - model.shapes.begin()));
  }
  first_shape_.push_back(static_cast<int>(model.shapes.size()));
}

void ImplicitStage::begin(State& state, const std::vector<int>& trees, const HandWork& hands, Seams& seams, double h) noexcept {
  state_ = &state;
  contacts_.begin(state, {work_.data(), X_WS_.data(), held_by_.data(), hands.bound.data()}, seams);
  held_way_ = hands.moved.data();
  step_ = h;
  held_left_ = 0;
  std::copy(hands.held_by.begin(), hands.held_by.end(), held_by_.begin());
  for (std::size_t t = 0; !fixed_placed_ && t < model_.trees.size(); ++t) place(static_cast<int>(t), state.v);
  fixed_placed_ = true;
  for (const int t : trees) {
    const ModelTree& tree = model_.trees[static_cast<std::size_t>(t)];
    std::copy_n(state.q.begin() + tree.q, tree.model->nq(), q_.begin() + tree.q);
    place(t, state.v);
  }
  std::fill(moved_.begin(), moved_.end(), 0);
  evaluations = problem_.iterations = problem_.factorisations = 0;
  error = wrench_error = 0;
  island_ = Island{};  // its arrays may have been filled anew
  problem_.forget();
}

void ImplicitStage::select(const Island& island) noexcept {
  island_ = island;
  has_joints_ = island_jointed_ = false;
  mass_ = 0;
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island.trees[n]];
    has_joints_ |= tree.has_laws;
    island_jointed_ |= !model_.isFree(tree);
    for (int l = 0; l < tree.model->linkCount(); ++l) mass_ += model_.links[tree.link + l].mass;
  }
  problem_.select(island, work_.data(), has_joints_ ? &joints_ : nullptr);
  selectForces();
  contacts_.select(island);
}

/// Couplings that pull at the island's links, by pointer, then its force elements.
void ImplicitStage::selectForces() noexcept {
  FrozenForce frozen;
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    frozen.source = static_cast<int>(i);
    frozen.link_b = couplings[i].link;
    if (problem_.moves(frozen.link_b)) problem_.forces.push_back(frozen);
  }
  has_forces_ = false;
  stored_ = 0;
  const auto moves = [this](int tree) { return problem_.moves(model_.trees[tree].link); };
  eachForce(model_, TreeRange{island_.trees, island_.tree_count}, moves, [&](int i, const ModelForce& force) {
    has_forces_ = true;
    frozen.source = static_cast<int>(couplings.size()) + i;
    frozen.link_a = force.link_a;
    frozen.link_b = force.link_b;
    problem_.forces.push_back(frozen);
    force_[i] = forceNow(model_, force, work_.data());
  });
  if (has_forces_) bookForces(0, false);
}

/// Where the reference moved. A coupling's wrench goes to its link, and so into the residual.
void ImplicitStage::freezeForces(double g) noexcept {
  const auto moved = [this](int link) { return problem_.moves(link) && moved_[model_.links[link].articulation]; };
  stored_ = 0;
  for (FrozenForce& frozen : problem_.forces) {
    const int element = frozen.source - static_cast<int>(couplings.size());
    const bool moves_on = moved(frozen.link_b) || moved(frozen.link_a);
    if (element >= 0) {
      if (moves_on) force_[element] = forceNow(model_, model_.forces[element], work_.data());
      if (moves_on) frozen.freeze(force_[element], g, true);
      stored_ += force_[element].stored;
      continue;
    }
    if (!moves_on) continue;
    ImplicitCoupling& coupling = couplings[frozen.source];
    const CouplingMatrices c = matricesOf(coupling.law, work_[frozen.link_b].X_WL.R, coupling.X_WL.R);
    LinkForce now;
    now.p_WA = now.p_WB = work_[frozen.link_b].X_WL.p;
    now.turn_K = c.rotational_stiffness, now.turn_D = c.rotational_damping;
    now.way_K = c.stiffness, now.way_D = c.damping;
    frozen.freeze(now, g, false);
    pull(coupling);
  }
}

/// Velocity of a point of a link that a hand leads, its mean over the step; zero where none does.
Twist ImplicitStage::ledTwist(int link, const Vector3& p_W) const noexcept {
  const int lead = link >= 0 ? held_by_[link] : -1;
  if (lead < 0) return {};
  const Twist way = held_way_[lead].shifted(p_W - work_[link].X_WL.p);
  return {way.angular / step_, way.linear / step_};
}

/// Powers of the force elements at their references; where it `moves_on`, carried to v by `before_`, v - v_r.
void ImplicitStage::bookForces(double g, bool moves_on) noexcept {
  force_power_ = {};
  for (const FrozenForce& frozen : problem_.forces) {
    const int element = frozen.source - static_cast<int>(couplings.size());
    if (element < 0) continue;
    LinkForce now = force_[element];
    if (moves_on) {
      const Twist V = problem_.twistOf(frozen, before_.data());
      const double gained = now.line.n.dot(V.linear);
      now.V = now.V + V;
      now.line.spring -= g * now.line.stiffness * gained;
      now.line.damper -= now.line.damping * gained;
      now.F = now.F - Wrench{frozen.turn * V.angular, frozen.way * V.linear} * (1 / g);
    }
    force_power_.taken += now.taken();
    force_power_.supplied += power(now.onB(), ledTwist(frozen.link_a, now.p_WA)) - power(now.onB(), ledTwist(frozen.link_b, now.p_WB));
  }
}

void ImplicitStage::start(double g, double left) noexcept {
  left_ = left;
  if (left_ != held_left_) placeHeld();
  if (has_joints_) joints_.startStage(*state_, q_base.data(), g, v.data());
  contacts_.clear(memory_base.data(), yielding.data(), g, run);
  changed_ = 0;
  first_ = true;
  limited = false;
  for (int n = 0; n < island_.tree_count; ++n) moved_[island_.trees[n]] = 1;
  calm_energy_ = std::numeric_limits<double>::infinity();
}

/// Puts what hands hold to where it is at the stage's end: friction is told displacements, not rates.
void ImplicitStage::placeHeld() noexcept {
  held_left_ = left_;
  for (int link = 0; link < static_cast<int>(held_by_.size()); ++link) {
    const int lead = held_by_[link];
    if (lead < 0) continue;
    const int t = model_.links[link].articulation;
    const ModelTree& tree = model_.trees[t];
    const double *end = state_->q.data() + tree.q, back = left_ / step_;
    const Quaternion q_end(end[3], end[4], end[5], end[6]);
    const Quaternion q = rotationFromVector(-back * held_way_[lead].angular) * q_end;
    const Vector3 p_LC = tree.model->link(0).p_LO;
    const Vector3 p = Vector3(end[0], end[1], end[2]) - q_end * p_LC - back * held_way_[lead].linear + q * p_LC;
    const double pose[7] = {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()};
    std::copy_n(pose, 7, q_.begin() + tree.q);
    place(t, state_->v);
  }
}

/// Passes, of which the first has been evaluated.
bool ImplicitStage::iterate(double g, int most_passes) noexcept {
  double last = 0;
  bool converged = false;
  tolerance_.speed = settings_.tolerance * kFree * g * settings_.gravity.norm();
  tolerance_.energy = 0;
  double smallest = std::numeric_limits<double>::infinity();
  for (int n = 0; n < island_.tree_count; ++n) {
    smallest = std::min(smallest, model_.links[model_.trees[island_.trees[n]].link].size);
  }
  if (contacts_.all().empty())
    most_passes = std::max(most_passes, island_.pair_count == 0 || has_forces_ ? kAlonePasses : kContactFreePasses);
  for (int pass = 0; pass < most_passes && !converged; ++pass) {
    if (pass > 0) evaluate(g);
    const double now = energy() - supply(g);
    const bool calmer = now <= calm_energy_;
    if (calmer) calm_energy_ = now;
    for (int n = 0; n < island_.tree_count; ++n) {
      const ModelTree& tree = model_.trees[island_.trees[n]];
      if (calmer) std::copy_n(v.begin() + tree.v, tree.model->nv(), calm_.begin() + tree.v);
      std::copy_n(v.begin() + tree.v, tree.model->nv(), before_.begin() + tree.v);
    }
    const double fine = finest(g);
    if (!problem_.solve(g, kStepsOfPass, fine, kStays * tolerance_.speed, moved_, q_.data(), v.data())) break;
    const double changed = change(before_);
    if (!std::isfinite(changed)) break;
    // A body of a micrometre falls through itself in a time that is nothing to one of a metre.
    const double least = std::min(kFree * g * settings_.gravity.norm(), kOfSize * smallest / g);
    const double share = settings_.tolerance * (contacts_.all().empty() ? kContactFree : 1.0);
    const double of_step = change(v_base);
    sinceReference();
    tolerance_.speed = std::max(fine, std::min(share * (least + of_step), kOfSize * smallest / g));
    const double rate = pass > 0 ? changed / last : 1;
    error = rate < 0.5 ? changed * rate / (1 - rate) : changed;
    wrench_error = problem_.imbalance * std::min(1.0, rate);
    // Where stiffness is high a small error of v is a large one of the energy. Twice the possible gain of the pass
    // at its reference, -R·p, is known exactly; the end of the pass is no reference yet. v_dot_ holds v - v_b.
    tolerance_.energy = settings_.tolerance * (problem_.massNorm2(v_dot_.data()) + mass_ * least * least);
    const bool harmless = problem_.decrement <= tolerance_.energy;
    converged = !contacts_.isRough() && (changed <= fine || holds() || (error <= tolerance_.speed && harmless) ||
                (rate >= 0.5 && changed <= kStagnation * problem_.speed(v.data())));
    last = changed_ = changed;
    for (int n = 0; n < island_.tree_count; ++n) {
      const int t = island_.trees[n];
      moved_[t] = problem_.speedOf(t, before_.data()) > std::max(fine, kStays * tolerance_.speed);
    }
  }
  finish(g);
  return converged;
}

double ImplicitStage::energyOf(int t) const noexcept {
  const ModelTree& tree = model_.trees[t];
  return kineticEnergy(*tree.model, work_.data() + tree.link) +
         potentialEnergy(*tree.model, work_.data() + tree.link, settings_.gravity);
}

/// Of the island at its reference, springs of contacts and force elements included [J].
double ImplicitStage::energy() const noexcept {
  double sum = 0;
  for (int n = 0; n < island_.tree_count; ++n) sum += tree_energy_[island_.trees[n]];
  return sum + contacts_.springEnergy() + stored_;
}

/// Work of hands and belts over the stage, with the forces and velocities at its reference [J].
double ImplicitStage::supply(double g) const noexcept {
  double sum = contacts_.supply(held_way_, step_);
  for (const FrozenForce& frozen : problem_.forces) {
    const int element = frozen.source - static_cast<int>(couplings.size());
    if (element < 0) {
      sum += power(couplings[frozen.source].F_W, work_[frozen.link_b].twistAtOrigin());
      continue;
    }
    const LinkForce& now = force_[element];
    sum += power(now.onB(), ledTwist(frozen.link_a, now.p_WA)) - power(now.onB(), ledTwist(frozen.link_b, now.p_WB));
  }
  return g * sum;
}

/// Of the island at the start of the stage [J]. Leaves the links there.
double ImplicitStage::startEnergy() noexcept {
  double sum = 0;
  for (int n = 0; n < island_.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island_.trees[n]];
    std::copy_n(q_base.begin() + tree.q, tree.model->nq(), q_.begin() + tree.q);
    place(island_.trees[n], v_base);
    sum += energyOf(island_.trees[n]);
  }
  for (const FrozenForce& frozen : problem_.forces) {
    const int element = frozen.source - static_cast<int>(couplings.size());
    if (element >= 0) sum += forceNow(model_, model_.forces[element], work_.data()).stored;
  }
  for (int i = 0; i < island_.pair_count; ++i) {
    const FrictionMemory& memory = memory_base[island_.pairs[i]];
    sum += memory.elastic_energy + memory.energy;
  }
  return sum;
}

/// v = share · from, of which everything is evaluated anew.
void ImplicitStage::setVelocity(const std::vector<double>& from, double share, double g) noexcept {
  for (int n = 0; n < island_.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island_.trees[n]];
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) v[i] = share * from[i];
    moved_[island_.trees[n]] = 1;
  }
  contacts_.clear(memory_base.data(), yielding.data(), g, run);
  changed_ = 0;
}

double ImplicitStage::keepEnergy(double g) noexcept {
  const double most = startEnergy(), calm = calm_energy_;
  const auto isTooMuch = [&] { return !(energy() - supply(g) <= most); };
  setVelocity(v, 1, g);
  evaluate(g);
  if (isTooMuch()) {
    setVelocity(calm_, calm <= most ? 1.0 : kSlower, g);
    evaluate(g, false);
  }
  if (isTooMuch()) {
    setVelocity(calm_, 0, g);
    evaluate(g, false);
  }
  const double lost = most - energy();
  finish(g);
  return lost;
}

/// Largest speed by which v differs from `since`; the difference is left in `v_dot_`.
double ImplicitStage::change(const std::vector<double>& since) noexcept {
  for (int n = 0; n < island_.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island_.trees[n]];
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) v_dot_[i] = v[i] - since[i];
  }
  return problem_.speed(v_dot_.data());
}

/// v - v_r into `before_`.
void ImplicitStage::sinceReference() noexcept {
  for (int n = 0; n < island_.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island_.trees[n]];
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) before_[i] = v[i] - problem_.reference()[i];
  }
}

double ImplicitStage::finest(double g) const noexcept {
  return stepping::roundingSpeed(problem_.speed(v.data()) + settings_.gravity.norm() * g, farthest(), g);
}

/// Largest distance of a moving body's parts from W's origin [m].
double ImplicitStage::farthest() const noexcept {
  double largest = 0;
  for (int n = 0; n < island_.tree_count; ++n) {
    const int link = model_.trees[island_.trees[n]].link;
    largest = std::max(largest, work_[link].p_WO.norm() + model_.links[link].size);
  }
  return largest;
}

/// Kinematics of a tree and its shapes from q_.
void ImplicitStage::place(int t, const std::vector<double>& velocity) noexcept {
  const ModelTree& tree = model_.trees[t];
  forwardKinematics(*tree.model, q_.data() + tree.q, velocity.data() + tree.v, work_.data() + tree.link);
  for (int s = first_shape_[t]; s < first_shape_[t + 1]; ++s) {
    X_WS_[s] = work_[model_.shapes[s].link].X_WL * model_.shapes[s].X_LS;
  }
}

/// Places the trees that moved at the end of the stage.
void ImplicitStage::move(double g) noexcept {
  for (int n = 0; n < island_.tree_count; ++n) {
    const int t = island_.trees[n];
    if (!moved_[t]) continue;
    const ModelTree& tree = model_.trees[t];
    std::copy_n(q_base.begin() + tree.q, tree.model->nq(), q_.begin() + tree.q);
    integratePositions(*tree.model, q_.data() + tree.q, v.data() + tree.v, g);
    place(t, v);
  }
}

/// v less the last reference's, or v, into `v_dot_`: whether a pair may get too deep on that way. Then the last reference is noted.
bool ImplicitStage::mayGetDeep(double g) noexcept {
  for (int n = 0; n < island_.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island_.trees[n]];
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) v_dot_[i] = first_ ? v[i] : v[i] - problem_.reference()[i];
  }
  if (!limit_.mayBePassed(island_, *state_, v_dot_.data(), g)) return false;
  for (int n = 0; n < island_.tree_count; ++n) {
    const int t = island_.trees[n];
    const ModelTree& tree = model_.trees[t];
    if (first_) {
      std::copy_n(q_base.begin() + tree.q, tree.model->nq(), q_.begin() + tree.q);
      place(t, v);
    }
    limit_.note(X_WS_.data(), first_shape_[t], first_shape_[t + 1]);
  }
  return true;
}

/// Moves the reference to v, or a share of the way: contacts and residual at the poses of the end of the stage, of the trees that
/// moved. v becomes the reference.
void ImplicitStage::evaluate(double g, bool may_limit) noexcept {
  evaluations += island_.pair_count > 0 ? 1 : 0;
  const bool looks = may_limit && mayGetDeep(g);
  move(g);
  const double share = looks ? limit_.share(island_, *state_, X_WS_.data(), v_dot_.data(), g, first_) : 1;
  if (share < 1) {
    limited = true;
    for (int n = 0; n < island_.tree_count; ++n) {
      const ModelTree& tree = model_.trees[island_.trees[n]];
      for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) v[i] -= (1 - share) * v_dot_[i];
      moved_[island_.trees[n]] = 1;
    }
    move(g);
  }
  first_ = false;
  if (!problem_.forces.empty()) freezeForces(g);
  for (int n = 0; n < island_.tree_count; ++n) {
    if (moved_[island_.trees[n]]) addWrenches(model_, *state_, island_.trees[n], work_.data());
  }
  for (int n = 0; n < island_.tree_count; ++n) {
    const int t = island_.trees[n];
    if (!moved_[t]) continue;
    const ModelTree& tree = model_.trees[t];
    const int nv = tree.model->nv();
    for (int i = tree.v; i < tree.v + nv; ++i) v_dot_[i] = (v[i] - v_base[i]) / g;
    inverseDynamics(*tree.model, settings_.gravity, v_dot_.data() + tree.v, work_.data() + tree.link,
                    residual_.data() + tree.v);
    for (int i = tree.v; i < tree.v + nv; ++i) residual_[i] *= g;
    problem_.freezeTree(t, v.data(), residual_.data());
    tree_energy_[t] = energyOf(t);
  }
  contacts_.evaluate(moved_, tolerance_, changed_);
}

/// True if another evaluation would agree with the last prediction: the pass ended at its solution, all patches stay valid, and no
/// gap closes. Bodies on joints turn more than that: they are always looked at again.
bool ImplicitStage::holds() const noexcept {
  if (island_jointed_ || contacts_.all().empty()) return false;
  if (has_forces_ && forcesBend()) return false;
  if (problem_.remainder > kStays * tolerance_.speed) return false;
  if (problem_.energy_remainder > kStays * tolerance_.energy) return false;
  return contacts_.hold(tolerance_, before_.data());
}

/// The target moves at its own velocity, so that a stage inside the step sees it where it is then.
void ImplicitStage::pull(ImplicitCoupling& coupling) noexcept {
  LinkWork& link = work_[coupling.link];
  const Vector3 p_WT = coupling.X_WL.p - left_ * coupling.V_WL.linear;
  const Quaternion back = rotationFromVector(-left_ * coupling.V_WL.angular);
  coupling.F_W = couplingForce(coupling.law, p_WT, back * Quaternion(coupling.X_WL.R), coupling.V_WL, link);
  link.addWrench(coupling.F_W, link.X_WL.p);
}

/// Whether the derivatives of a force element change with the motion.
bool ImplicitStage::forcesBend() const noexcept {
  return std::any_of(problem_.forces.begin(), problem_.forces.end(), [this](const FrozenForce& frozen) {
    const int element = frozen.source - static_cast<int>(couplings.size());
    return element >= 0 && force_[element].bends;
  });
}

/// Carries contacts, couplings and force elements from the reference to v.
void ImplicitStage::finish(double g) noexcept {
  sinceReference();
  contacts_.finish(before_.data(), held_way_, step_);
  for (const FrozenForce& frozen : problem_.forces) {
    if (frozen.source >= static_cast<int>(couplings.size())) break;  // couplings come first
    ImplicitCoupling& coupling = couplings[frozen.source];
    const Twist V = problem_.twistOf(frozen, before_.data());
    coupling.F_W += Wrench{-(1 / g) * (frozen.turn * V.angular), -(1 / g) * (frozen.way * V.linear)};
    coupling.power = power(coupling.F_W, work_[frozen.link_b].twistAtOrigin() + V);
  }
  if (has_forces_) bookForces(g, true);
}

}  // namespace haptic
