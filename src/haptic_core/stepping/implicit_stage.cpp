#include "haptic_core/stepping/implicit_stage.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/dynamics/joint_space_inertia.h"
#include "haptic_core/geometry/contact_moments.h"
#include "haptic_core/geometry/convex_polyhedron.h"
#include "haptic_core/world/hands.h"

namespace haptic {
namespace {

/// No solve goes on below this share of the speeds of the step, plus what rounding of coordinates amounts to:
/// kRounding of the distance from W's origin, per step. Smaller iterates on rounding.
constexpr double kFinest = 1e-13;
constexpr double kRounding = 4 * 2.2e-16;
/// Changes that shrink no more, but are this small already, are rounding in a stiff contact.
constexpr double kStagnation = 1e-9;
/// Newton steps of a pass: first passes contract by 5–20 each, so that more of them beat longer ones. What has not settled
/// then keeps its patches and waits for friction to choose between stick and slip.
constexpr int kStepsOfPass = 4, kStepsOfLatePass = 7, kFirstPasses = 2;
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
/// Share of the tolerance that a frozen patch may be wrong by, or a body may move, without another evaluation.
constexpr double kStays = 0.5;

/// ∫ d² dA: exact for a face (extent = mean), 3 % above it for an edge (twice) and exact for a corner (three
/// times).
double estimatedSquares(const ContactVolume& volume) {
  const double mean = volume.volume / std::max(volume.A0, volume.volume / volume.depth);
  return volume.volume * mean * (1 + 0.75 * (1 - mean / volume.depth));
}

}  // namespace

ImplicitStage::ImplicitStage(const Model& model)
    : model_(model), settings_(model.settings), joints_(model), problem_(model), seams_(model) {
  couplings.resize(model.pointers.size());
  problem_.couplings.resize(model.pointers.size());
  q_base.resize(model.nq);
  q_.resize(model.nq);
  for (auto* vector : {&v_base, &v, &before_, &residual_, &v_dot_, &calm_}) vector->resize(model.nv);
  tree_energy_.resize(model.trees.size());
  memory_base.resize(model.pair_capacity);
  yielding.resize(model.pair_capacity);
  slot_.resize(model.pair_capacity);
  near_.resize(model.pair_capacity);
  gap_.resize(model.pair_capacity);
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
  contacts_.reserve(problem_.contacts.capacity());
  model.reserve(workspace_);
}

void ImplicitStage::begin(State& state, const std::vector<int>& held_by, const std::vector<Twist>& moved, double h) noexcept {
  state_ = &state;
  held_way_ = moved.data();
  step_ = h;
  held_left_ = 0;
  std::copy(held_by.begin(), held_by.end(), held_by_.begin());
  std::copy(state.q.begin(), state.q.end(), q_.begin());
  for (std::size_t t = 0; t < model_.trees.size(); ++t) place(static_cast<int>(t), state.v);
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
  contacts_.clear();
}

void ImplicitStage::start(double g, double left) noexcept {
  left_ = left;
  if (left_ != held_left_) placeHeld();
  if (has_joints_) joints_.startStage(*state_, q_base.data(), g, v.data());
  contacts_.clear();
  problem_.contacts.clear();
  for (int i = 0; i < island_.pair_count; ++i) slot_[island_.pairs[i]] = near_[island_.pairs[i]] = -1;
  reach_ = 0;
  rough_ = false;
  for (int n = 0; n < island_.tree_count; ++n) moved_[island_.trees[n]] = 1;
  calm_energy_ = std::numeric_limits<double>::infinity();
}

/// Puts what hands hold to where it is at the stage's end: friction is told displacements, not rates.
void ImplicitStage::placeHeld() noexcept {
  held_left_ = left_;
  for (std::size_t i = 0; i < state_->pointers.size(); ++i) {
    const int link = state_->pointers[i].link;
    if (held_by_[link] != static_cast<int>(i)) continue;
    const int t = model_.links[link].articulation;
    const ModelTree& tree = model_.trees[t];
    const double *end = state_->q.data() + tree.q, back = left_ / step_;
    const Quaternion q_end(end[3], end[4], end[5], end[6]);
    const Quaternion q = rotationFromVector(-back * held_way_[i].angular) * q_end;
    const Vector3 p_LC = tree.model->link(0).p_LO;
    const Vector3 p = Vector3(end[0], end[1], end[2]) - q_end * p_LC - back * held_way_[i].linear + q * p_LC;
    const double pose[7] = {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()};
    std::copy_n(pose, 7, q_.begin() + tree.q);
    place(t, state_->v);
  }
}

/// Passes, of which the first has been evaluated.
bool ImplicitStage::iterate(double g, int most_passes) noexcept {
  double last = 0;
  bool converged = false;
  tolerance_ = settings_.tolerance * kFree * g * settings_.gravity.norm();
  energy_tolerance_ = 0;
  double smallest = std::numeric_limits<double>::infinity();
  for (int n = 0; n < island_.tree_count; ++n) {
    smallest = std::min(smallest, model_.links[model_.trees[island_.trees[n]].link].size);
  }
  if (contacts_.empty())
    most_passes = std::max(most_passes, island_.pair_count == 0 ? kAlonePasses : kContactFreePasses);
  for (int pass = 0; pass < most_passes && !converged; ++pass) {
    if (pass > 0) evaluate(g);
    const double now = energy();
    const bool calmer = now <= calm_energy_;
    if (calmer) calm_energy_ = now;
    for (int n = 0; n < island_.tree_count; ++n) {
      const ModelTree& tree = model_.trees[island_.trees[n]];
      if (calmer) std::copy_n(v.begin() + tree.v, tree.model->nv(), calm_.begin() + tree.v);
      std::copy_n(v.begin() + tree.v, tree.model->nv(), before_.begin() + tree.v);
    }
    const double fine = finest(g);
    if (!problem_.minimise(g, pass < kFirstPasses ? kStepsOfPass : kStepsOfLatePass, fine, kStays * tolerance_, q_.data(), v.data())) break;
    const double changed = change(before_);
    if (!std::isfinite(changed)) break;
    // A body of a micrometre falls through itself in what is nothing to one of a metre.
    const double least = std::min(kFree * g * settings_.gravity.norm(), kOfSize * smallest / g);
    const double share = settings_.tolerance * (contacts_.empty() ? kContactFree : 1.0);
    tolerance_ = std::max(fine, std::min(share * (least + change(v_base)), kOfSize * smallest / g));
    const double rate = pass > 0 ? changed / last : 1;
    error = rate < 0.5 ? changed * rate / (1 - rate) : changed;
    wrench_error = problem_.imbalance * std::min(1.0, rate);
    // Where stiffness is high a small error of v is a large one of the energy. Twice what the pass could gain
    // at its reference, -R·p, is known exactly; the end of the pass is nobody's reference yet.
    change(v_base);  // into v_dot_
    energy_tolerance_ = settings_.tolerance * (problem_.massNorm2(v_dot_.data()) + mass_ * least * least);
    const bool harmless = problem_.decrement <= energy_tolerance_;
    converged = !rough_ && (changed <= fine || holds(g) || (error <= tolerance_ && harmless) ||
                (rate >= 0.5 && changed <= kStagnation * problem_.speed(v.data())));
    rough_ = false;
    last = changed;
    reach_ = g * changed;
    for (int n = 0; n < island_.tree_count; ++n) {
      const int t = island_.trees[n];
      moved_[t] = problem_.speedOf(t, before_.data()) > std::max(fine, kStays * tolerance_);
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
  for (const ImplicitContact& c : contacts_) sum += c.touching ? c.elastic : 0.0;
  return sum;
}

/// The same at the start of the stage. Leaves the links there.
double ImplicitStage::startEnergy() noexcept {
  double sum = 0;
  for (int n = 0; n < island_.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island_.trees[n]];
    std::copy_n(q_base.begin() + tree.q, tree.model->nq(), q_.begin() + tree.q);
    place(island_.trees[n], v_base);
    sum += energyOf(island_.trees[n]);
  }
  for (int i = 0; i < island_.pair_count; ++i) sum += memory_base[island_.pairs[i]].elastic_energy;
  return sum;
}

/// v = share · from, of which everything is evaluated anew.
void ImplicitStage::setVelocity(const std::vector<double>& from, double share) noexcept {
  for (int n = 0; n < island_.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island_.trees[n]];
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) v[i] = share * from[i];
    moved_[island_.trees[n]] = 1;
  }
  contacts_.clear();
  problem_.contacts.clear();
  for (int i = 0; i < island_.pair_count; ++i) slot_[island_.pairs[i]] = near_[island_.pairs[i]] = -1;
  reach_ = 0;
}

void ImplicitStage::keepEnergy(double g) noexcept {
  const double most = startEnergy(), calm = calm_energy_;
  setVelocity(v, 1);
  evaluate(g);
  if (!(energy() <= most)) {
    setVelocity(calm_, calm <= most ? 1.0 : kSlower);
    evaluate(g);
  }
  if (!(energy() <= most)) {
    setVelocity(calm_, 0);
    evaluate(g);
  }
  finish(g);
}

/// Largest speed by which v differs from `since`. Leaves v - v_r in `before_`.
double ImplicitStage::change(const std::vector<double>& since) noexcept {
  double largest = 0;
  for (int n = 0; n < island_.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island_.trees[n]];
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) v_dot_[i] = v[i] - since[i];
    largest = std::max(largest, problem_.speedOf(island_.trees[n], v_dot_.data()));
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) before_[i] = v[i] - problem_.reference()[i];
  }
  return largest;
}

double ImplicitStage::finest(double g) const noexcept {
  return kFinest * (problem_.speed(v.data()) + settings_.gravity.norm() * g) + kRounding * farthest() / g;
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

/// Moves the reference to v: contacts and residual at the poses of the end of the stage, of the trees that
/// moved.
void ImplicitStage::evaluate(double g) noexcept {
  evaluations += island_.pair_count > 0 ? 1 : 0;
  for (int n = 0; n < island_.tree_count; ++n) {
    const int t = island_.trees[n];
    if (!moved_[t]) continue;
    const ModelTree& tree = model_.trees[t];
    std::copy_n(q_base.begin() + tree.q, tree.model->nq(), q_.begin() + tree.q);
    integratePositions(*tree.model, q_.data() + tree.q, v.data() + tree.v, g);
    place(t, v);
  }
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    FrozenCoupling& frozen = problem_.couplings[i];
    frozen.link = couplings[i].link >= 0 && nodeOf(couplings[i].link) >= 0 ? couplings[i].link : -1;
    if (frozen.link < 0 || !moved_[model_.links[frozen.link].articulation]) continue;
    const PointerCoupling& c = couplings[i].law;
    frozen.turn = g * g * c.rotational_stiffness + g * c.rotational_damping;
    frozen.way = g * g * c.stiffness + g * c.damping;
    pull(couplings[i]);
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
  if (seams_.any()) {
    seams_.find(state_->pairs.data(), island_.pairs, island_.pair_count, X_WS_.data(), workspace_);
  }
  const int aside = contacts_.size();
  for (int i = 0; i < island_.pair_count; ++i) {
    const ActivePair& pair = state_->pairs[island_.pairs[i]];
    if (!moved_[treeOf(pair.shapeA())] && !moved_[treeOf(pair.shapeB())]) continue;
    const int slot = slot_[island_.pairs[i]];
    if (slot >= 0 && contacts_[slot].touching && staysValid(slot, g)) {
      problem_.contacts[slot].V_reference = problem_.contacts[slot].V;
    } else {
      evaluatePair(island_.pairs[i], g);
    }
  }
  for (int i = 0; i < aside; ++i) {
    const FrozenContact& c = problem_.contacts[i];
    if (contacts_[i].touching || slot_[contacts_[i].pair] == i || near_[contacts_[i].pair] == i) continue;
    if (moved_[model_.links[c.link_a].articulation] || moved_[model_.links[c.link_b].articulation]) part(i);
  }
}

/// Whether another evaluation would find what the last one predicts: the pass ended at its minimum with the limits of friction
/// that it was given, all patches stay valid, and no gap closes. Bodies on joints turn more than that: they are always looked at again.
bool ImplicitStage::holds(double g) const noexcept {
  if (island_jointed_ || contacts_.empty()) return false;
  if (problem_.remainder + problem_.limitError(g) > kStays * tolerance_) return false;
  if (problem_.energy_remainder > kStays * energy_tolerance_) return false;
  for (int i = 0; i < island_.pair_count; ++i) {
    const int index = island_.pairs[i], slot = slot_[index];
    if (slot >= 0) {
      if (!contacts_[slot].touching || !staysValid(slot, g)) return false;
      continue;
    }
    const ActivePair& pair = state_->pairs[index];
    double closing = 0;
    for (const int shape : {pair.shapeA(), pair.shapeB()}) {
      if (nodeOf(model_.shapes[shape].link) >= 0) closing += problem_.speedOf(treeOf(shape), before_.data());
    }
    if (gap_[index] < M_SQRT2 * g * closing) return false;
  }
  return true;
}

/// Whether a patch still answers as a new one would: what the frozen geometry leaves out, of second order in the way
/// along n and of first order in the turn of n, is small against the tolerance, as a speed and as an energy.
bool ImplicitStage::staysValid(int slot, double g) const noexcept {
  const FrozenContact& c = problem_.contacts[slot];
  if (c.patch.isRough()) return false;
  const ImplicitContact& contact = contacts_[slot];
  const double mass = std::min(problem_.massOf(c.link_a), problem_.massOf(c.link_b));
  const Vector6 change = c.V - c.V_frozen;
  const double depth = contact.volume.volume / std::max(contact.volume.A0, contact.volume.volume / contact.volume.depth);
  const double turn = g * (change.head<3>().norm() + change.segment<2>(3).norm() / c.patch.extent());
  const double missed = c.patch.missedDepth(change, depth);
  return missed / g + c.force.normal * g / mass * turn <= kStays * tolerance_ &&
         c.patch.stiffness() * missed * missed <= kStays * energy_tolerance_;
}

/// Leaves a contact and its frozen patch behind, or parts those that an earlier pass left.
void ImplicitStage::evaluatePair(int index, double g) noexcept {
  ActivePair& pair = state_->pairs[index];
  const int shape_a = pair.shapeA(), shape_b = pair.shapeB();
  const ContactPlaces places{work_.data(), X_WS_.data(), held_by_.data()};
  const Pose X_AB = relativePose(X_WS_[shape_a], X_WS_[shape_b]);
  Advance advance;
  advance.time = g;
  advance.yielding = yielding[index];
  advance.mean_rate = settings_.integrator == Integrator::kImplicitEuler;  // SDIRK2's rates, its stand-in's too, are the end's
  ContactEvaluation found;
  int& slot = slot_[index];
  if (!evaluateContact(model_, seams_, index, pair, places, memory_base[index], advance, workspace_, found)) {
    gap_[index] = -found.volume.depth;
    if (reach_ > 0 && lookAtFaces(index, X_AB, pair.cache.direction, g)) {
      if (slot >= 0) leave(slot);
      return;
    }
    if (slot >= 0) part(slot);
    if (reach_ > 0) lookAhead(index, X_AB, pair.cache.direction, g);
    return;
  }
  const bool known = slot >= 0;
  if (!known) {
    slot = contacts_.size();
    contacts_.resize(slot + 1);
    problem_.contacts.resize(slot + 1);
  }
  ImplicitContact& contact = contacts_[slot];
  FrozenContact& frozen = problem_.contacts[slot];
  contact.pair = index;
  contact.shape_a = shape_a;
  contact.shape_b = shape_b;
  contact.volume = found.volume;
  contact.touching = true;
  contact.X_WP = found.X_WP;
  contact.force = found.force;
  // Half of what a contact costs: without the ledger an estimate does, from the volume and its extent.
  const double k = found.law.material.stiffness;
  contact.elastic = settings_.energy_ledger ? elasticEnergy(model_, found.volume, k, workspace_)
                                            : 0.5 * k * estimatedSquares(found.volume);
  const FrozenContact before = frozen;
  frozen.link_a = model_.shapes[shape_a].link;
  frozen.link_b = model_.shapes[shape_b].link;
  frozen.X_WP = contact.X_WP;
  frozen.V_reference = frozen.V_frozen = found.V_AB_P.vector();
  const double squares = 2 * contact.elastic / k;  // ∫d² dA [m⁴]
  frozen.patch.freeze(found.volume, squares, contact.force, found.law, frozen.V_reference, g);
  // The last pass knows better what presses at its end than the force at the new reference, which stiffness magnifies.
  if (!known) frozen.limit = contact.force.normal_force;
  if (!(reach_ > 0)) {
    frozen.patch.dropConstant();
    rough_ |= frozen.patch.isRough();
    return;
  }
  const ConvexShape &A = *model_.shapes[shape_a].shape, &B = *model_.shapes[shape_b].shape;
  FaceOverlay faces;
  if (faces.find(A, B, X_AB, found.volume.X_AP) && frozen.patch.spread(faces, frozen.V_reference)) {
    if (near_[index] >= 0) leave(near_[index]);
    return;
  }
  if (known && before.patch.isElsewhere(frozen.patch)) keepAside(index, before);
  if (found.volume.depth < reach_) lookAhead(index, X_AB, found.volume.normal(), g);
}

/// The contact of what is near, not touching, made or reused; null where there is no room.
FrozenContact* ImplicitStage::nearContact(int index) noexcept {
  int& slot = near_[index];
  if (slot < 0) {
    const int last = contacts_.size();
    contacts_.resize(last + 1);
    problem_.contacts.resize(last + 1);
    if (contacts_.size() == last) return nullptr;
    slot = last;
  }
  const ActivePair& pair = state_->pairs[index];
  contacts_[slot].pair = index;
  contacts_[slot].touching = false;
  FrozenContact& c = problem_.contacts[slot];
  c.link_a = model_.shapes[pair.shapeA()].link;
  c.link_b = model_.shapes[pair.shapeB()].link;
  c.limit = 0;
  return &c;
}

/// Puts two faces that look at one another across a gap into the problem. False: there are none.
bool ImplicitStage::lookAtFaces(int index, const Pose& X_AB, const Vector3& n, double g) noexcept {
  const ActivePair& pair = state_->pairs[index];
  const int shape_a = pair.shapeA(), shape_b = pair.shapeB();
  if (!(n.squaredNorm() > 0)) return false;
  Pose X_AP(patchAxes(n), X_AB.p);
  FaceOverlay faces;
  if (!faces.find(*model_.shapes[shape_a].shape, *model_.shapes[shape_b].shape, X_AB, X_AP)) return false;
  faces.centre(X_AP);
  FrozenContact* c = nearContact(index);
  if (!c) return false;
  c->X_WP = X_WS_[shape_a] * X_AP;
  const Twist V_W = work_[c->link_b].twistAt(c->X_WP.p) - work_[c->link_a].twistAt(c->X_WP.p);
  c->V_reference = V_W.rotated(c->X_WP.R.transpose()).vector();
  const PairLaw law = model_.law(shape_a, shape_b, held_by_[c->link_a] >= 0, held_by_[c->link_b] >= 0);
  c->patch.freezeNear(faces, law, c->V_reference, g);
  return true;
}

/// Puts what is nearer than the reach into the problem: `n` [A's frame] from A to B is the way on which it
/// would meet.
void ImplicitStage::lookAhead(int index, const Pose& X_AB, const Vector3& n, double g) noexcept {
  const ActivePair& pair = state_->pairs[index];
  const int shape_a = pair.shapeA(), shape_b = pair.shapeB();
  if (near_[index] >= 0) leave(near_[index]);
  if (!(n.squaredNorm() > 0)) return;
  PairCache cache = pair.cache;
  ContactVolume near;
  contactVolume(*model_.shapes[shape_a].shape, *model_.shapes[shape_b].shape, Pose(X_AB.R, X_AB.p - reach_ * n),
                cache, workspace_, near, settings_.normal_rule);
  if (near.status != ContactVolume::Status::kOverlap) return;
  FrozenContact* c = nearContact(index);
  if (!c) return;
  c->X_WP = X_WS_[shape_a] * near.X_AP;
  const Twist V_W = work_[c->link_b].twistAt(c->X_WP.p) - work_[c->link_a].twistAt(c->X_WP.p);
  c->V_reference = V_W.rotated(c->X_WP.R.transpose()).vector();
  const PairLaw law = model_.law(shape_a, shape_b, held_by_[c->link_a] >= 0, held_by_[c->link_b] >= 0);
  c->patch.freezeNear(near, reach_, law, c->V_reference, g);
}

/// A patch that has gone to another place of its pair still bars the way back: a body that rocks would go on
/// for ever.
void ImplicitStage::keepAside(int pair, const FrozenContact& c) noexcept {
  const int slot = contacts_.size();
  contacts_.resize(slot + 1);
  problem_.contacts.resize(slot + 1);
  if (problem_.contacts.size() == slot || contacts_.size() == slot) return;
  contacts_[slot].pair = pair;
  problem_.contacts[slot] = c;
  part(slot);
}

/// The pair is in the problem elsewhere.
void ImplicitStage::leave(int slot) noexcept {
  contacts_[slot].touching = false;
  problem_.contacts[slot].patch.forget();
}

void ImplicitStage::part(int slot) noexcept {
  FrozenContact& c = problem_.contacts[slot];
  contacts_[slot].touching = false;
  const Twist V_W = work_[c.link_b].twistAt(c.X_WP.p) - work_[c.link_a].twistAt(c.X_WP.p);
  c.V_reference = V_W.rotated(c.X_WP.R.transpose()).vector();
  c.patch.part(c.V_reference);
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
  change(v_base);  // v - v_r into before_
  for (int i = 0; i < contacts_.size(); ++i) {
    ImplicitContact& c = contacts_[i];
    const FrozenContact& frozen = problem_.contacts[i];
    if (!c.touching) continue;
    const Vector6 V = frozen.V_reference + problem_.twistOf(frozen, before_.data());
    frozen.patch.carry(V, frozen.limit, c.volume.X_AP, c.force, c.elastic);
  }
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    const FrozenCoupling& frozen = problem_.couplings[i];
    if (frozen.link < 0) continue;
    const LinkWork& link = work_[frozen.link];
    const Twist V = problem_.linkTwist(frozen.link, link.X_WL.p, before_.data());
    couplings[i].F_W += Wrench{-frozen.turn / g * V.angular, -frozen.way / g * V.linear};
    couplings[i].power = power(couplings[i].F_W, link.twistAtOrigin() + V);
  }
  orderContacts();
}

/// Leaves the contacts that touch, in the order of their pairs. Few are out of it: those that a later pass
/// found.
void ImplicitStage::orderContacts() noexcept {
  int count = 0;
  for (int i = 0; i < contacts_.size(); ++i) {
    if (!contacts_[i].touching) continue;
    if (count != i) contacts_[count] = contacts_[i];
    ++count;
  }
  contacts_.resize(count);
  for (int i = 1; i < count; ++i) {
    if (contacts_[i - 1].pair < contacts_[i].pair) continue;
    int to = i - 1;
    while (to > 0 && contacts_[to - 1].pair > contacts_[i].pair) --to;
    std::rotate(contacts_.begin() + to, contacts_.begin() + i, contacts_.begin() + i + 1);
  }
}

}  // namespace haptic
