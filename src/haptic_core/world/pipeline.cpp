#include "haptic_core/world/pipeline.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/base/error.h"
#include "haptic_core/dynamics/runge_kutta.h"
#include "haptic_core/geometry/point_contact.h"
#include "haptic_core/world/features.h"

namespace haptic {
namespace {

Eigen::Map<Vector3> vec3(double* numbers) { return Eigen::Map<Vector3>(numbers); }

void store(const Wrench& F, double* out) {
  vec3(out) = F.torque;
  vec3(out + 3) = F.force;
}
Wrench load(const double* in) {
  return {Vector3(in[0], in[1], in[2]), Vector3(in[3], in[4], in[5])};
}
Quaternion quaternionAt(const double* q) {
  return Quaternion(q[0], q[1], q[2], q[3]);
}
void store(const Quaternion& r, double* out) {
  const double numbers[4] = {r.w(), r.x(), r.y(), r.z()};
  std::copy(numbers, numbers + 4, out);
}

}  // namespace

Pipeline::Pipeline(const WorldDef& def)
    : settings_(def.settings), pointers_(def.pointers), plan_(def), joint_normals_(plan_) {
  state_.pull.resize(plan_.nv);
  v_dot_.resize(plan_.nv);
  half_.resize(plan_.nv);
  alone_.resize(plan_.nv);
  for (const PlanTree& tree : plan_.trees) {
    const std::size_t links = tree.model->linkCount(), scratch = rungeKuttaScratch(*tree.model);
    coasting_.resize(std::max(coasting_.size(), scratch));
    no_wrench_.resize(std::max(no_wrench_.size(), links));
  }
  kick_.resize(plan_.links.size());
  work_.resize(plan_.links.size());
  held_by_.assign(plan_.links.size(), -1);
  free_movers_.reserve(plan_.trees.size());
  jointed_movers_.reserve(plan_.trees.size());
  contacts_on_.resize(plan_.links.size());
  state_.q = plan_.q_start;
  state_.v = plan_.v_start;
  X_WS_.resize(plan_.shapes.size());
  boxes_.resize(plan_.shapes.size());
  state_.pairs.resize(plan_.pair_capacity);
  previous_pairs_.resize(plan_.pair_capacity);
  contacts_.reserve(plan_.pair_capacity);
  works_.reserve(plan_.pair_capacity);
  plan_.reserve(workspace_);
  prepareSearch();
  automatic_ = settings_.integrator == Integrator::kAutomatic;
  const bool implicit =
      settings_.integrator == Integrator::kImplicitEuler || settings_.integrator == Integrator::kSdirk2;
  if (implicit || automatic_) {
    implicit_ = std::make_unique<ImplicitStep>(plan_, settings_, static_cast<int>(pointers_.size()));
    islands_ = std::make_unique<Islands>(plan_);
  }
  state_.mode.assign(plan_.trees.size(), implicit ? kImplicit : kUnprimed);
  number_.resize(plan_.links.size());
  retreat_.q.resize(plan_.nq);
  retreat_.v.resize(plan_.nv);
  retreat_.pull.resize(plan_.nv);
  makeMotions();
  addJointPaths(def);
  placeAll();
  state_.pointers.resize(pointers_.size());
  pointer_wrench_.resize(pointers_.size());
  pointer_moved_.resize(pointers_.size());
  for (const PointerDef& pointer : pointers_) tuning_.coupling.push_back(pointer.coupling);
  for (std::size_t i = 0; i < pointers_.size(); ++i) {
    state_.pointers[i].link = -1;
    grab(static_cast<int>(i), pointerHome(static_cast<int>(i)));
  }
  noteHolders();
  findBuried();
  history_ = std::make_unique<StepHistory>(settings_.history_steps, state_);
}

bool Pipeline::holds(int pointer) const {
  return pointers_[pointer].coupling.mode == PointerCoupling::Mode::kDirect;
}

void Pipeline::grab(int pointer, int link) {
  if (pointer < 0 || pointer >= static_cast<int>(pointers_.size()) || link < 0 ||
      link >= static_cast<int>(plan_.links.size())) {
    throw SetupError("grab", "no pointer " + std::to_string(pointer) + " or no link " + std::to_string(link),
                     "name a pointer and a link of the scene");
  }
  if (tryGrab(pointer, link)) return;
  const int other = heldBy(link);
  if (other >= 0) {
    throw SetupError("grab", "link " + plan_.links[link].name + " is held by the hand of " + pointers_[other].device,
                     "let it go there first");
  }
  throw SetupError("grab", "link " + plan_.links[link].name + " hangs on joints or is fixed",
                   "hold free bodies, or use the virtual coupling");
}

bool Pipeline::canGrab(int pointer, int link) const noexcept {
  if (!holds(pointer)) return plan_.links[link].moves;
  const int other = heldBy(link);
  return plan_.trees[plan_.links[link].articulation].model->isFreeBody() && (other < 0 || other == pointer);
}

bool Pipeline::tryGrab(int pointer, int link) noexcept {
  if (!canGrab(pointer, link)) return false;
  PointerState& state = state_.pointers[pointer];
  state.link = link;
  const Pose& X_WL = work_[link].X_WL;
  vec3(state.p_WL) = X_WL.p;
  store(Quaternion(X_WL.R), state.q_WL);
  state.targeted = 0;
  forgetPull();
  resolveCoupling(pointer);
  noteHolders();
  return true;
}

void Pipeline::resolveCoupling(int i) noexcept {
  const int link = static_cast<int>(state_.pointers[i].link);
  const double h = settings_.step / settings_.substeps;
  pointers_[i].coupling = resolved(tuning_.coupling[i], loadOf(link), h, link != pointerHome(i));
}

void Pipeline::noteHolders() noexcept {
  std::fill(held_by_.begin(), held_by_.end(), -1);
  for (int i = 0; i < static_cast<int>(pointers_.size()); ++i) {
    if (holds(i) && state_.pointers[i].link >= 0) held_by_[static_cast<int>(state_.pointers[i].link)] = i;
  }
  free_movers_.clear();
  jointed_movers_.clear();
  for (const PlanTree& tree : plan_.trees) {
    if (movesByItself(tree)) (isFree(tree) ? free_movers_ : jointed_movers_).push_back(&tree);
  }
}

void Pipeline::tune(const WorldTuning& tuning) {
  std::vector<CouplingLoad> loads;
  for (const PointerState& pointer : state_.pointers) loads.push_back(loadOf(static_cast<int>(pointer.link)));
  check(tuning, loads, settings_.step / settings_.substeps);
  tuning_ = tuning;
  plan_.scaleLaws(tuning.stiffness_scale, tuning.friction_scale);
  for (std::size_t i = 0; i < pointers_.size(); ++i) {
    resolveCoupling(static_cast<int>(i));
    if (!canGrab(static_cast<int>(i), static_cast<int>(state_.pointers[i].link))) {
      grab(static_cast<int>(i), pointerHome(static_cast<int>(i)));
    }
  }
  noteHolders();
  forgetPull();
}

/// What pulled at the end of the last step holds no longer.
void Pipeline::forgetPull() noexcept {
  for (double& mode : state_.mode) {
    if (mode == kPrimed) mode = kUnprimed;
  }
}

void Pipeline::restore(const std::vector<double>& packed) {
  state_.unpack(packed);
  report_ = StepReport{};
  report_.step = state_.step;
  noteHolders();
  for (int i = 0; i < static_cast<int>(pointers_.size()); ++i) resolveCoupling(i);
  contacts_.clear();
  history_->clear();
  placeAll();
}

void Pipeline::setPointerTarget(int i, const Pose& X_WL, const Twist& V_WL) noexcept {
  PointerState& pointer = state_.pointers[i];
  if (!X_WL.p.allFinite() || !X_WL.R.allFinite() || !V_WL.angular.allFinite() || !V_WL.linear.allFinite()) return;
  vec3(pointer.p_WL) = X_WL.p;
  store(Quaternion(X_WL.R), pointer.q_WL);
  vec3(pointer.V_WL) = V_WL.angular;
  vec3(pointer.V_WL + 3) = V_WL.linear;
  pointer.targeted = 1;
}

void Pipeline::measureStages(bool on) noexcept {
  clock_.on = on;
  report_.stages = {};
}

void Pipeline::step() noexcept {
  if (!report_.finite) return;
  report_.flags = 0;
  report_.closure = 0;
  if (kFullWorld) clock_.start(report_.stages);
  report_.evaluations = report_.factorisations = 0;
  if (kFullWorld) report_.iterations = report_.parts = report_.implicit_islands = report_.redone = report_.fallbacks = 0;
  report_.residual = report_.wrench_error = 0;
  report_.substeps = 0;
  if (kFullWorld) std::fill(pointer_wrench_.begin(), pointer_wrench_.end(), Wrench{});
  if (kFullWorld && !joint_paths_.empty()) followJointPaths();
  const double h = settings_.step / settings_.substeps;
  for (int s = 0; s < settings_.substeps && report_.finite; ++s) {
    // Where something fast comes near something thin, in parts.
    for (double left = h; left > 0 && report_.finite;) {
      const double part = kFullWorld ? safePart(left) : left;
      share_ = part / h;
      substep(part, part / (left + h * (settings_.substeps - 1 - s)));
      left = part < left ? left - part : 0;
    }
  }
  for (int i = 0; i < pointerCount(); ++i) {
    store(report_.finite ? pointer_wrench_[i] * (1.0 / settings_.substeps) : Wrench{}, state_.pointers[i].F_W);
  }
  if (kFullWorld) clock_.end(report_.stages.motion);
  report_.step = ++state_.step;
  state_.time = static_cast<double>(state_.step) * settings_.step;
  if (report_.finite) history_->keep();
}

/// Direct coupling: the link goes where the hand is. The hand's work is that of the contact wrench, by the
/// trapezoidal rule over the way.
void Pipeline::movePointers(double progress) noexcept {
  for (int i = 0; i < pointerCount(); ++i) {
    const PointerState& pointer = state_.pointers[i];
    if (!holds(i) || pointer.targeted == 0) continue;
    const int link = static_cast<int>(pointer.link);
    const PlanTree& tree = plan_.trees[plan_.links[link].articulation];
    double* q = state_.q.data() + tree.q;
    double* v = state_.v.data() + tree.v;
    const Quaternion from = quaternionAt(q + 3);
    const Quaternion to = from.slerp(progress, quaternionAt(pointer.q_WL)).normalized();
    const Vector3 p_WL = work_[link].X_WL.p + progress * (Vector3(pointer.p_WL) - work_[link].X_WL.p);
    const Vector3 p_LC = tree.model->link(0).p_LO;
    const Vector3 omega(pointer.V_WL), velocity(pointer.V_WL + 3);
    pointer_moved_[i] = {vectorFromRotation(to * from.conjugate()), p_WL - work_[link].X_WL.p};
    state_.energy[2] -= 0.5 * power(load(pointer.F_last_W), pointer_moved_[i]);
    vec3(q) = p_WL + to * p_LC;
    store(to, q + 3);
    vec3(v) = omega;
    vec3(v + 3) = velocity + omega.cross(to * p_LC);
    forwardKinematics(*tree.model, q, v, work_.data() + tree.link);
  }
}

void Pipeline::updateKinematics() noexcept {
  for (const int t : plan_.updated_trees) {
    const PlanTree& tree = plan_.trees[t];
    forwardKinematics(*tree.model, state_.q.data() + tree.q, state_.v.data() + tree.v, work_.data() + tree.link);
  }
}

/// The sweep knows which pairs to leave out; in the general pipeline it finds them all, and findPairs drops them.
void Pipeline::prepareSearch() {
  const int n = static_cast<int>(plan_.shapes.size());
  std::vector<std::pair<int, int>> never;
  for (int a = 0; settings_.leave_out && a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      if (!plan_.mayCollide(a, b)) never.emplace_back(a, b);
    }
  }
  broad_phase_ = std::make_unique<BroadPhase>(n, never, settings_.leave_out ? plan_.pair_capacity : 0);
}

/// Everything once, what never moves included.
void Pipeline::placeAll() noexcept {
  for (const PlanTree& tree : plan_.trees) {
    forwardKinematics(*tree.model, state_.q.data() + tree.q, state_.v.data() + tree.v, work_.data() + tree.link);
  }
  for (int s = 0; s < static_cast<int>(plan_.shapes.size()); ++s) placeShape(s, 0);
}

/// Pose and box of a shape. With h > 0 the box of an implicit tree, which has yet to move, is widened by how far its link
/// may come in that time.
void Pipeline::placeShape(int s, double h) noexcept {
  const PlanShape& shape = plan_.shapes[s];
  X_WS_[s] = work_[shape.link].X_WL * shape.X_LS;
  boxes_[s] = shape.shape->aabb(X_WS_[s]);
  if (!(h > 0) || !plan_.links[shape.link].moves || !isImplicit(plan_.links[shape.link].articulation)) return;
  const LinkWork& link = work_[shape.link];
  // Twice the way at today's speed and gravity: what a collision adds to the speed is within it.
  const double way =
      2 * h *
      (link.velocity.norm() + link.omega.norm() * plan_.links[shape.link].size + h * settings_.gravity.norm());
  boxes_[s].lower.array() -= way;
  boxes_[s].upper.array() += way;
}

/// Overlapping boxes, in the order of their keys; what a pair remembers comes along from the last step. With h > 0
/// boxes of implicit trees, which have yet to move, are widened by how far they may come in that time.
void Pipeline::findPairs(double h) noexcept {
  if (!plan_.searches_pairs) return;
  if (kFullWorld) clock_.end(report_.stages.motion);
  for (const int s : plan_.updated_shapes) placeShape(s, h);
  std::swap(previous_pairs_, state_.pairs);
  const int previous_count = state_.pair_count;
  int before = 0;
  state_.pair_count = 0;
  const auto meet = [&](int a, int b) {
    const std::uint64_t key = ActivePair::keyOf(a, b);
    while (before < previous_count && previous_pairs_[before].key < key) ++before;
    const bool known = before < previous_count && previous_pairs_[before].key == key;
    if (state_.pair_count == static_cast<int>(state_.pairs.size())) {
      report_.flags |= kPairsDropped;
      return;
    }
    ActivePair& pair = state_.pairs[state_.pair_count++];
    pair = known ? previous_pairs_[before] : ActivePair{};
    pair.key = key;
  };
  if (!plan_.listed_pairs.empty()) {
    for (const auto& [a, b] : plan_.listed_pairs) {
      if ((boxes_[a].lower.array() <= boxes_[b].upper.array()).all() &&
          (boxes_[b].lower.array() <= boxes_[a].upper.array()).all()) {
        meet(a, b);
      }
    }
    return;
  }
  if (!broad_phase_->update(boxes_.data())) report_.flags |= kPairsDropped;
  for (const BroadPhase::Pair& found : broad_phase_->pairs()) {
    if (settings_.leave_out || plan_.mayCollide(found.a, found.b)) meet(found.a, found.b);
  }
}

void Pipeline::evaluateContacts(const Advance& advance) noexcept {
  contacts_.clear();
  works_.clear();
  report_.energy.elastic = report_.energy.tangential = 0;
  has_kick_ = false;
  if (kFullWorld) clock_.end(report_.stages.search);
  std::fill(contacts_on_.begin(), contacts_on_.end(), 0);
  for (int i = 0; i < state_.pair_count; ++i) {
    const ActivePair& pair = state_.pairs[i];
    if (pair.friction.touching == 0) continue;
    for (const int shape : {pair.shapeA(), pair.shapeB()}) {
      const int link = plan_.shapes[shape].link;
      if (plan_.links[link].moves) ++contacts_on_[link];  // what stands still has no mass to share
    }
  }
  if (joint_normals_.any()) joint_normals_.find(state_.pairs.data(), nullptr, state_.pair_count, X_WS_.data(), workspace_);
  if (kFullWorld && automatic_) {
    for (std::size_t l = 0; l < number_.size(); ++l) number_[l] = 0;
    for (std::size_t p = 0; p < pointers_.size(); ++p) {
      const int link = static_cast<int>(state_.pointers[p].link);
      if (isImplicit(plan_.links[link].articulation)) continue;
      number_[link] = couplingNumber(link, settings_.step / settings_.substeps);
    }
  }
  for (int i = 0; i < state_.pair_count; ++i) {
    if (kFullWorld && automatic_ && (isImplicit(treeOf(state_.pairs[i].shapeA())) || isImplicit(treeOf(state_.pairs[i].shapeB())))) {
      continue;
    }
    evaluatePair(i, advance);
  }
  report_.pairs = state_.pair_count;
  report_.contacts = contacts_.size();
}

void Pipeline::evaluatePair(int index, const Advance& advance) noexcept {
  ActivePair& pair = state_.pairs[index];
  const int a = pair.shapeA(), b = pair.shapeB();
  const PlanShape &A = plan_.shapes[a], &B = plan_.shapes[b];
  ContactVolume volume;
  const NormalRule rule = joint_normals_.ruleFor(index, settings_.normal_rule, X_WS_[a], pair.cache);
  contactVolume(*A.shape, *B.shape, relativePose(X_WS_[a], X_WS_[b]), pair.cache, workspace_, volume, rule);
  const bool overlap = volume.status == ContactVolume::Status::kOverlap;
  if (kFullWorld) clock_.end(overlap ? report_.stages.volume : report_.stages.detection);
  if (!overlap) {
    if (pair.friction.touching != 0) part(pair, advance);
    pair.friction = {};
    pair.stability = {};
    pair.buried = 0;
    return;
  }
  if (settings_.contact_model == ContactModel::kPoint) {
    concentrate(workspace_, std::min(A.point_area, B.point_area), volume);
  }
  LinkWork &link_a = work_[A.link], &link_b = work_[B.link];
  const Pose X_WP = X_WS_[a] * volume.X_AP;
  const Twist V_AB_P = (link_b.twistAt(X_WP.p) - link_a.twistAt(X_WP.p)).rotated(X_WP.R.transpose());
  PairLaw law = plan_.law(a, b, heldBy(A.link) >= 0, heldBy(B.link) >= 0);
  if (kFullWorld && pair.buried != 0) {
    law = plan_.recoveryLaw(law, a, b, volume);
    if (volume.depth < plan_.buriedDepth(a, b, volume.A0)) pair.buried = 0;
  }
  const LocatedForce force = settledForce(pair, volume, law, X_WP, V_AB_P, advance);
  const Wrench F_BP_W = force.F_BP_P.rotated(X_WP.R);
  link_b.addWrench(F_BP_W, X_WP.p);
  link_a.addWrench(-F_BP_W, X_WP.p);
  if (force.has_impulse) addKick(A.link, B.link, force.impulse_P.rotated(X_WP.R), X_WP.p);
  FrictionMemory memory = force.memory;
  if (keepsLedger()) keepLedger(index, volume, law, force, X_WP, pair.friction, memory);
  pair.friction = memory;
  if (kFullWorld && automatic_) {
    noteStability(pair, volume, force.tangent, X_WP, settings_.step / settings_.substeps);
  }
  if (advance.old_share > 0) remember(volume, V_AB_P, X_WP.p, F_BP_W, pair.release);
  if (force.clipped) report_.flags |= kPressureClipped;
  noteContact(a, b, volume, force.normal_force, force.sticking, X_WP, F_BP_W);
  if (!contacts_.empty()) contacts_[contacts_.size() - 1].event = force.event;
  if (kFullWorld) clock_.end(report_.stages.force);
}

void Pipeline::noteContact(int a, int b, const ContactVolume& volume, double normal_force, bool sticking,
                           const Pose& X_WP, const Wrench& F_BP_W) noexcept {
  if (volume.flags & ContactVolume::kCapacityExceeded) report_.flags |= kContactsIncomplete;
  if (volume.flags & ContactVolume::kNormalFromHistory) report_.flags |= kNormalRemembered;
  ContactReport contact;
  contact.link_a = plan_.shapes[a].link;
  contact.link_b = plan_.shapes[b].link;
  contact.X_WP = X_WP;
  contact.F_BP_W = F_BP_W;
  contact.normal_force = normal_force;
  contact.volume = volume.volume;
  contact.area = volume.A0;
  contact.depth = volume.depth;
  contact.sticking = sticking;
  contact.flags = volume.flags;
  contact.shape_a = a;
  contact.shape_b = b;
  contacts_.push_back(contact);
}

/// Virtual coupling: a spring-damper from the hand's target to the link.
void Pipeline::pullPointers(double h) noexcept {
  for (int i = 0; i < pointerCount(); ++i) {
    PointerState& pointer = state_.pointers[i];
    if (holds(i) || isImplicit(plan_.links[static_cast<int>(pointer.link)].articulation)) continue;
    Wrench F_W;
    LinkWork& link = work_[static_cast<int>(pointer.link)];
    const Twist V = link.twistAtOrigin();
    if (pointer.targeted != 0) {
      const PointerCoupling& c = pointers_[i].coupling;
      const Vector3 turn = vectorFromRotation(quaternionAt(pointer.q_WL) * Quaternion(link.X_WL.R).conjugate());
      F_W.force =
          c.stiffness * (Vector3(pointer.p_WL) - link.X_WL.p) + c.damping * (Vector3(pointer.V_WL + 3) - V.linear);
      F_W.torque = c.rotational_stiffness * turn + c.rotational_damping * (Vector3(pointer.V_WL) - V.angular);
      link.addWrench(F_W, link.X_WL.p);
    }
    state_.energy[2] += h * power(F_W, V);
    if (h > 0) pointer_wrench_[i] += -(F_W * share_);
  }
}

/// Direct coupling: what touches the pointer goes to the hand.
void Pipeline::collectPointerWrenches() noexcept {
  for (int i = 0; i < pointerCount(); ++i) {
    if (!holds(i)) continue;
    PointerState& pointer = state_.pointers[i];
    const LinkWork& link = work_[static_cast<int>(pointer.link)];
    const Wrench F_W = link.F_ext.shifted(link.X_WL.p - link.p_WO);
    state_.energy[2] -= 0.5 * power(F_W, pointer_moved_[i]);
    store(F_W, pointer.F_last_W);
    pointer_wrench_[i] += F_W * share_;
  }
}

namespace {

/// 0, or NaN: infinity does not survive in it either, 0·∞ = NaN.
double nothing(const double* x, int count) {
  double sum[4] = {0, 0, 0, 0};
  int i = 0;
  for (; i + 4 <= count; i += 4) {
    for (int k = 0; k < 4; ++k) sum[k] += 0 * x[i + k];
  }
  for (; i < count; ++i) sum[0] += 0 * x[i];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

}  // namespace

void Pipeline::checkFinite() noexcept {
  if (nothing(state_.v.data(), plan_.nv) + nothing(state_.q.data(), plan_.nq) == 0) return;
  for (const PlanTree& tree : plan_.trees) {
    if (nothing(state_.v.data() + tree.v, tree.model->nv()) + nothing(state_.q.data() + tree.q, tree.model->nq()) == 0) continue;
    report_.finite = false;
    report_.culprit = tree.link;
    return;
  }
}

}  // namespace haptic
