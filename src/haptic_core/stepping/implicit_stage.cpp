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
  problem_.couplings.resize(model.pointers.size());
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
  contacts_.select(island);
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
    most_passes = std::max(most_passes, island_.pair_count == 0 ? kAlonePasses : kContactFreePasses);
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
    // A body of a micrometre falls through itself in what is nothing to one of a metre.
    const double least = std::min(kFree * g * settings_.gravity.norm(), kOfSize * smallest / g);
    const double share = settings_.tolerance * (contacts_.all().empty() ? kContactFree : 1.0);
    const double of_step = change(v_base);
    sinceReference();
    tolerance_.speed = std::max(fine, std::min(share * (least + of_step), kOfSize * smallest / g));
    const double rate = pass > 0 ? changed / last : 1;
    error = rate < 0.5 ? changed * rate / (1 - rate) : changed;
    wrench_error = problem_.imbalance * std::min(1.0, rate);
    // Where stiffness is high a small error of v is a large one of the energy. Twice what the pass could gain
    // at its reference, -R·p, is known exactly; the end of the pass is nobody's reference yet. v_dot_ holds v - v_b.
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

/// Of the island at its reference, springs of contacts included [J].
double ImplicitStage::energy() const noexcept {
  double sum = 0;
  for (int n = 0; n < island_.tree_count; ++n) sum += tree_energy_[island_.trees[n]];
  return sum + contacts_.springEnergy();
}

/// Work of hands and belts over the stage, with the forces and velocities at its reference [J].
double ImplicitStage::supply(double g) const noexcept {
  double sum = contacts_.supply(held_way_, step_);
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    const int link = problem_.couplings[i].link;
    if (link >= 0) sum += power(couplings[i].F_W, work_[link].twistAtOrigin());
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
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    FrozenCoupling& frozen = problem_.couplings[i];
    frozen.link = couplings[i].link >= 0 && problem_.nodeOf(couplings[i].link) >= 0 ? couplings[i].link : -1;
    if (frozen.link < 0 || !moved_[model_.links[frozen.link].articulation]) continue;
    const CouplingMatrices c = matricesOf(couplings[i].law, work_[frozen.link].X_WL.R, couplings[i].X_WL.R);
    frozen.turn = g * g * c.rotational_stiffness + g * c.rotational_damping;
    frozen.way = g * g * c.stiffness + g * c.damping;
    pull(couplings[i]);
  }
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

/// Whether another evaluation would find what the last one predicts: the pass ended at its solution, all patches stay valid, and no
/// gap closes. Bodies on joints turn more than that: they are always looked at again.
bool ImplicitStage::holds() const noexcept {
  if (island_jointed_ || contacts_.all().empty()) return false;
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

/// Carries contacts and couplings from the reference to v.
void ImplicitStage::finish(double g) noexcept {
  sinceReference();
  contacts_.finish(before_.data(), held_way_, step_);
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    const FrozenCoupling& frozen = problem_.couplings[i];
    if (frozen.link < 0) continue;
    const LinkWork& link = work_[frozen.link];
    const Twist V = problem_.linkTwist(frozen.link, link.X_WL.p, before_.data());
    couplings[i].F_W += Wrench{-(1 / g) * (frozen.turn * V.angular), -(1 / g) * (frozen.way * V.linear)};
    couplings[i].power = power(couplings[i].F_W, link.twistAtOrigin() + V);
  }
}

}  // namespace haptic
