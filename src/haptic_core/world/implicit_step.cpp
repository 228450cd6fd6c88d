#include "haptic_core/world/implicit_step.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/dynamics/joint_space_inertia.h"
#include "haptic_core/geometry/contact_integrals.h"
#include "haptic_core/geometry/convex_polyhedron.h"

namespace haptic {
namespace {

constexpr double kGamma = 1 - M_SQRT1_2;  ///< of SDIRK2

/// Newton ends when its step is this small against the speeds of the step (relative), plus what rounding of
/// coordinates amounts to: kRounding of the distance from W's origin, per step. Larger lets resting bodies creep;
/// smaller iterates on rounding.
constexpr double kTolerance = 1e-13;
constexpr double kRounding = 4 * 2.2e-16;
/// Steps that shrink no more, but are this small already, are rounding in a stiff contact.
constexpr double kStagnation = 1e-9;
constexpr int kMaxIterations = 15;    ///< before stiffness is built up in steps
constexpr int kMaxContinuation = 60;  ///< Newton steps at one stiffness of the continuation
/// The acceleration jumps when it changes within a step by more than this share of the speed (and of h g).
constexpr double kJump = 0.5;
/// A patch that grows or shrinks by more than this factor within a step is not smooth.
constexpr double kGrowth = 2;
constexpr int kMaxLineSearch = 10;   ///< evaluations; each halves the bracket at least
constexpr double kSufficient = 0.5;  ///< a step is good when |φ(α)| falls to this share of |φ(0)|

using JacobianMap = Eigen::Map<Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>>;

}  // namespace

ImplicitStep::ImplicitStep(const Plan& plan, const WorldSettings& settings)
    : plan_(plan),
      settings_(settings),
      joints_(plan),
      matrix_(static_cast<int>(plan.trees.size()), plan.pair_capacity,
              // The dense factor, but no more than 64 MB: beyond, a step falls back to more, smaller solves.
              std::min<std::size_t>(static_cast<std::size_t>(plan.nv) * (plan.nv + 1), std::size_t{8} << 20)),
      joint_normals_(plan) {
  const int trees = static_cast<int>(plan.trees.size());
  node_of_tree_.resize(trees);
  tree_of_node_.resize(trees);
  node_size_.resize(trees);
  int largest = 1;
  for (const PlanTree& tree : plan.trees) largest = std::max(largest, tree.model->nv());
  q_base_.resize(plan.nq);
  q_.resize(plan.nq);
  for (auto* v : {&v_base_, &v_, &trial_, &residual_, &step_, &v_dot_, &acceleration_, &rows_}) v->resize(plan.nv);
  memory_base_.resize(plan.pair_capacity);
  work_.resize(plan.links.size());
  held_by_.resize(plan.links.size());
  X_WS_.resize(plan.shapes.size());
  contacts_.reserve(plan.pair_capacity);
  edges_.reserve(plan.pair_capacity);
  if (!joints_.empty()) matrix_.reserveKept();
  plan.reserve(workspace_);
  mass_matrix_.resize(static_cast<std::size_t>(largest) * largest);
  block_.resize(mass_matrix_.size());
  for (auto* J : {&jacobian_a_, &jacobian_b_, &weighted_}) J->resize(6 * static_cast<std::size_t>(largest));
  placeFixed();
}

/// What never moves: `evaluate` leaves it where it is.
void ImplicitStep::placeFixed() {
  for (const PlanTree& tree : plan_.trees) {
    if (tree.model->isStatic()) forwardKinematics(*tree.model, nullptr, nullptr, work_.data() + tree.link);
  }
  for (std::size_t s = 0; s < plan_.shapes.size(); ++s) {
    X_WS_[s] = work_[plan_.shapes[s].link].X_WL * plan_.shapes[s].X_LS;
  }
}

void ImplicitStep::findNodes(const std::vector<int>& held_by) noexcept {
  std::copy(held_by.begin(), held_by.end(), held_by_.begin());
  nodes_ = 0;
  for (int t = 0; t < static_cast<int>(plan_.trees.size()); ++t) {
    const PlanTree& tree = plan_.trees[t];
    const bool moves = !tree.model->isStatic() && held_by_[tree.link] < 0;
    node_of_tree_[t] = moves ? nodes_ : -1;
    if (!moves) continue;
    node_size_[nodes_] = tree.model->nv();
    tree_of_node_[nodes_++] = t;
  }
  if (!joints_.empty()) joints_.setNodes(node_of_tree_, nodes_);
}

const ImplicitReport& ImplicitStep::advance(WorldState& state, const std::vector<int>& held_by,
                                            const std::vector<Wrench>& applied, double h) noexcept {
  state_ = &state;
  applied_ = &applied;
  report_ = ImplicitReport{};
  findNodes(held_by);
  const bool second_order = settings_.integrator == Integrator::kSdirk2;
  if (!second_order || !sdirk2(h)) {
    report_.fell_back = second_order;
    implicitEuler(h);
  }
  joints_.closeAccount(state);
  return report_;
}

void ImplicitStep::implicitEuler(double h) noexcept {
  setBase(state_->q.data(), state_->v.data());
  for (int i = 0; i < state_->pair_count; ++i) memory_base_[i] = state_->pairs[i].friction;
  v_ = v_base_;
  report_.converged = solveStage(h);
  joints_.startAccount();
  joints_.account(v_base_.data(), v_.data(), h);  // force × mean velocity is the change of kinetic energy
  commit(h);
}

/// False, and nothing done, where the step is not smooth.
bool ImplicitStep::sdirk2(double h) noexcept {
  const double g = kGamma * h, rest = (1 - kGamma) * h;
  setBase(state_->q.data(), state_->v.data());
  for (int i = 0; i < state_->pair_count; ++i) memory_base_[i] = state_->pairs[i].friction;
  v_ = v_base_;
  if (!solveStage(g) || !sameContacts() || !joints_.isSmooth(state_->v.data())) return false;
  for (const ImplicitContact& c : contacts_) {
    const FrictionMemory &s0 = state_->pairs[c.pair].friction, &s1 = c.force.memory;
    FrictionMemory& base = memory_base_[c.pair];
    base.slip_A = s0.slip_A + (1 - kGamma) / kGamma * (s1.slip_A - s0.slip_A);
    base.twist = s0.twist + (1 - kGamma) / kGamma * (s1.twist - s0.twist);
    base.area = std::max(0.0, s0.area + (1 - kGamma) / kGamma * (s1.area - s0.area));
    base.torsion = std::max(0.0, s0.torsion + (1 - kGamma) / kGamma * (s1.torsion - s0.torsion));
  }
  joints_.startAccount();
  joints_.account(v_.data(), v_.data(), rest);
  for (int i = 0; i < plan_.nv; ++i) {
    acceleration_[i] = (v_[i] - v_base_[i]) / g;
    v_base_[i] += rest * acceleration_[i];
  }
  for (int n = 0; n < nodes_; ++n) {
    const PlanTree& tree = plan_.trees[tree_of_node_[n]];
    integratePositions(*tree.model, q_base_.data() + tree.q, v_.data() + tree.v, rest);
  }
  for (int i = 0; i < plan_.nv; ++i) v_[i] = v_base_[i] + g * acceleration_[i];
  if (!solveStage(g) || !sameContacts() || !joints_.isSmooth(state_->v.data())) return false;
  for (int i = 0; i < plan_.nv; ++i) step_[i] = (v_[i] - v_base_[i]) / g - acceleration_[i];
  if (h * speed(step_) > kJump * (speed(v_) + h * settings_.gravity.norm())) return false;
  joints_.account(v_.data(), v_.data(), g);
  commit(g);
  return true;
}

/// Whether the contacts of the last evaluation are those of the step's start, sliding where these slide, and their
/// patches about as large: an edge that becomes a face is an impact.
bool ImplicitStep::sameContacts() const noexcept {
  int next = 0;
  for (int i = 0; i < state_->pair_count; ++i) {
    const bool now = next < contacts_.size() && contacts_[next].pair == i;
    const ActivePair& before = state_->pairs[i];
    if (now != (before.area > 0)) return false;
    if (!now) continue;
    const ImplicitContact& contact = contacts_[next++];
    if (contact.force.memory.sliding != before.friction.sliding) return false;
    if (contact.volume.A0 > kGrowth * before.area || before.area > kGrowth * contact.volume.A0) return false;
  }
  return true;
}

void ImplicitStep::setBase(const double* q, const double* v) noexcept {
  std::copy(q, q + plan_.nq, q_base_.begin());
  std::copy(v, v + plan_.nv, v_base_.begin());
}

/// Newton from the guess in v_; when that fails, with the stiffness built up.
bool ImplicitStep::solveStage(double g) noexcept {
  softness_ = 1;
  joints_.startStage(*state_, q_base_.data(), g, v_.data());
  if (newton(g, kMaxIterations)) return true;
  // From where g² k_eff equals a tenth of the inertia; the contacts of the last evaluation tell how stiff they are.
  double stiffest = 0;
  for (const ImplicitContact& c : contacts_) {
    const PairLaw law = plan_.law(c.shape_a, c.shape_b, false, false);
    stiffest = std::max(stiffest, g * g * law.material.stiffness * c.volume.A0 / law.reduced_mass);
  }
  int decades = stiffest > 0.1 ? static_cast<int>(std::ceil(std::log10(stiffest / 0.1))) : 1;
  v_ = v_base_;
  joints_.startStage(*state_, q_base_.data(), g, v_.data());
  bool converged = false;
  for (; decades >= 0; --decades) {
    softness_ = std::pow(10.0, -decades);
    converged = newton(g, kMaxContinuation);
  }
  return converged;
}

bool ImplicitStep::newton(double g, int max_iterations) noexcept {
  const double floor = settings_.gravity.norm() * g;
  double last = 1e300;
  evaluate(v_, g);
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    if (!assemble() || !findDirection()) return false;
    const double phi_0 = slope(v_);
    ++report_.iterations;
    report_.residual = speed(step_);
    const double scale = speed(v_) + floor;
    const double rounding = kRounding * farthest() / g;
    if (report_.residual <= kTolerance * scale + rounding ||
        (report_.residual >= 0.5 * last && report_.residual <= kStagnation * scale)) {
      // The step is rounding: taken without looking again, the forces are those of the evaluation before it.
      for (int i = 0; i < plan_.nv; ++i) v_[i] += step_[i];
      joints_.settle(v_.data());
      return true;
    }
    last = report_.residual;
    const double alpha = lineSearch(g, phi_0);
    for (int i = 0; i < plan_.nv; ++i) v_[i] += alpha * step_[i];
    if (alpha == 1) joints_.settle(v_.data());
  }
  return false;
}

/// Newton's step p into step_: A p = −R, with what the joints do by themselves.
bool ImplicitStep::findDirection() noexcept {
  if (!joints_.empty()) {
    return joints_.solve(matrix_, work_.data(), q_.data(), v_.data(), residual_.data(), step_.data());
  }
  if (!matrix_.factor()) return false;
  for (int n = 0, row = 0; n < nodes_; ++n) {
    const PlanTree& tree = plan_.trees[tree_of_node_[n]];
    for (int i = 0; i < tree.model->nv(); ++i) rows_[row++] = -residual_[tree.v + i];
  }
  matrix_.solve(rows_.data());
  for (int n = 0, row = 0; n < nodes_; ++n) {
    const PlanTree& tree = plan_.trees[tree_of_node_[n]];
    for (int i = 0; i < tree.model->nv(); ++i) step_[tree.v + i] = rows_[row++];
  }
  return true;
}

/// φ = R(v)·p at the last evaluation, which was at v.
double ImplicitStep::slope(const std::vector<double>& v) const noexcept {
  double phi = 0;
  for (int n = 0; n < nodes_; ++n) {
    const PlanTree& tree = plan_.trees[tree_of_node_[n]];
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) phi += step_[i] * residual_[i];
  }
  return joints_.empty() ? phi : phi + joints_.slope(v.data(), step_.data());
}

/// The α whose φ(α) = R(v + α p)·p is small against φ(0); leaves R and the contacts of v + α p behind.
double ImplicitStep::lineSearch(double g, double phi_0) noexcept {
  double low = 0, phi_low = phi_0, high = 0, phi_high = 0, alpha = 1;
  for (int i = 0; i < kMaxLineSearch; ++i) {
    for (int k = 0; k < plan_.nv; ++k) trial_[k] = v_[k] + alpha * step_[k];
    if (alpha == 1) joints_.settle(trial_.data());
    evaluate(trial_, g);
    const double phi = slope(trial_);
    // With loops that do not close yet φ may start upwards: closing them comes first.
    if (std::abs(phi) <= kSufficient * std::abs(phi_0) || !(phi_0 < 0)) return alpha;
    if (phi < 0) {
      low = alpha;
      phi_low = phi;
      if (high == 0) return alpha;  // not far enough at the full step: the next direction will see
    } else {
      high = alpha;
      phi_high = phi;
    }
    // Regula falsi, kept within the middle of the bracket so that it shrinks at least by a fifth.
    const double secant = low + (high - low) * phi_low / (phi_low - phi_high);
    alpha = std::clamp(secant, low + 0.2 * (high - low), high - 0.2 * (high - low));
  }
  return alpha;
}

/// Largest speed of any node [m/s]; rotations count at the reach of the body.
double ImplicitStep::speed(const std::vector<double>& v) const noexcept {
  double largest = 0;
  for (int n = 0; n < nodes_; ++n) {
    const PlanTree& tree = plan_.trees[tree_of_node_[n]];
    if (tree.model->isFreeBody()) {
      const double size = plan_.links[tree.link].size;
      const Vector3 w(v.data() + tree.v), u(v.data() + tree.v + 3);
      largest = std::max(largest, std::sqrt(u.squaredNorm() + size * size * w.squaredNorm()));
    } else {
      const double size = plan_.links[tree.link].size;
      for (int i = 0; i < tree.model->nv(); ++i) largest = std::max(largest, size * std::abs(v[tree.v + i]));
    }
  }
  return largest;
}

/// Largest distance of a moving body's parts from W's origin [m].
double ImplicitStep::farthest() const noexcept {
  double largest = 0;
  for (int n = 0; n < nodes_; ++n) {
    const int link = plan_.trees[tree_of_node_[n]].link;
    largest = std::max(largest, work_[link].p_WO.norm() + plan_.links[link].size);
  }
  return largest;
}

/// Contacts and residual at velocity v: poses at the end of the stage.
void ImplicitStep::evaluate(const std::vector<double>& v, double g) noexcept {
  ++report_.evaluations;
  std::copy(q_base_.begin(), q_base_.end(), q_.begin());
  for (const int t : plan_.updated_trees) {
    const PlanTree& tree = plan_.trees[t];
    const bool moves = node_of_tree_[t] >= 0;
    if (moves) integratePositions(*tree.model, q_.data() + tree.q, v.data() + tree.v, g);
    forwardKinematics(*tree.model, q_.data() + tree.q, moves ? v.data() + tree.v : state_->v.data() + tree.v,
                      work_.data() + tree.link);
  }
  for (std::size_t l = 0; l < work_.size(); ++l) work_[l].addWrench((*applied_)[l], work_[l].X_WL.p);
  for (const int s : plan_.updated_shapes) X_WS_[s] = work_[plan_.shapes[s].link].X_WL * plan_.shapes[s].X_LS;
  contacts_.clear();
  if (joint_normals_.any()) joint_normals_.find(state_->pairs.data(), state_->pair_count, X_WS_.data(), workspace_);
  for (int i = 0; i < state_->pair_count; ++i) evaluatePair(i, g);
  for (int n = 0; n < nodes_; ++n) {
    const PlanTree& tree = plan_.trees[tree_of_node_[n]];
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) v_dot_[i] = (v[i] - v_base_[i]) / g;
    inverseDynamics(*tree.model, settings_.gravity, v_dot_.data() + tree.v, work_.data() + tree.link,
                    residual_.data() + tree.v);
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) residual_[i] *= g;
  }
}

void ImplicitStep::evaluatePair(int index, double g) noexcept {
  ActivePair& pair = state_->pairs[index];
  ImplicitContact contact;
  contact.pair = index;
  contact.shape_a = pair.shapeA();
  contact.shape_b = pair.shapeB();
  const PlanShape &A = plan_.shapes[contact.shape_a], &B = plan_.shapes[contact.shape_b];
  const Pose& X_WA = X_WS_[contact.shape_a];
  const NormalRule rule = joint_normals_.ruleFor(index, settings_.normal_rule, X_WA, pair.cache);
  contactVolume(*A.shape, *B.shape, relativePose(X_WA, X_WS_[contact.shape_b]), pair.cache, workspace_,
                contact.volume, rule);
  if (contact.volume.status != ContactVolume::Status::kOverlap) return;
  LinkWork &a = work_[A.link], &b = work_[B.link];
  contact.X_WP = X_WS_[contact.shape_a] * contact.volume.X_AP;
  const Twist V_AB_P = (b.twistAt(contact.X_WP.p) - a.twistAt(contact.X_WP.p)).rotated(contact.X_WP.R.transpose());
  PairLaw law = plan_.law(contact.shape_a, contact.shape_b, held_by_[A.link] >= 0, held_by_[B.link] >= 0);
  law.material.stiffness *= softness_;
  law.material.damping *= softness_;
  law.material.tangential_stiffness *= softness_;
  Advance advance;
  advance.time = g;
  advance.keep_limit = true;
  contact.force = locatedForce(contact.volume, workspace_, V_AB_P, memory_base_[index], law, advance);
  contact.G_P = contact.force.tangent.combined(g * g, g);
  if (settings_.energy_ledger) {
    contact.elastic = 0.5 * law.material.stiffness * thicknessSquared(workspace_, contact.volume);
  }
  const Wrench F_BP_W = contact.force.F_BP_P.rotated(contact.X_WP.R);
  b.addWrench(F_BP_W, contact.X_WP.p);
  a.addWrench(-F_BP_W, contact.X_WP.p);
  contacts_.push_back(contact);
}

bool ImplicitStep::assemble() noexcept {
  edges_.clear();
  for (const ImplicitContact& c : contacts_) {
    const int a = node_of_tree_[plan_.links[plan_.shapes[c.shape_a].link].articulation];
    const int b = node_of_tree_[plan_.links[plan_.shapes[c.shape_b].link].articulation];
    if (a >= 0 && b >= 0 && a != b) edges_.push_back({a, b});
  }
  if (!matrix_.analyze(node_size_.data(), nodes_, edges_.begin(), edges_.size())) return false;
  for (int n = 0; n < nodes_; ++n) {
    const PlanTree& tree = plan_.trees[tree_of_node_[n]];
    if (tree.model->isFreeBody()) {  // block diagonal: (R I Rᵀ, m)
      const LinkModel& body = tree.model->link(0);
      const Matrix3& R_WL = work_[tree.link].X_WL.R;
      Matrix6 M = Matrix6::Zero();
      M.topLeftCorner<3, 3>() = R_WL * body.I_O * R_WL.transpose();
      M(3, 3) = M(4, 4) = M(5, 5) = body.mass;
      matrix_.add(n, n, M.data());
    } else {
      massMatrix(*tree.model, work_.data() + tree.link, mass_matrix_.data());
      matrix_.add(n, n, mass_matrix_.data());
    }
  }
  for (const ImplicitContact& c : contacts_) assembleContact(c);
  return true;
}

/// Rows: the twist at P in P's axes, angular first; columns: ω and v of the free body.
Matrix6 ImplicitStep::freeJacobian(int link, const Pose& X_WP) const noexcept {
  const Matrix3 R_PW = X_WP.R.transpose();
  Matrix6 J;
  J.topLeftCorner<3, 3>() = R_PW;
  J.topRightCorner<3, 3>().setZero();
  J.bottomLeftCorner<3, 3>() = -R_PW * crossMatrix(X_WP.p - work_[link].p_WO);
  J.bottomRightCorner<3, 3>() = R_PW;
  return J;
}

/// The same for a link of a tree; columns: the tree's degrees.
void ImplicitStep::treeJacobian(int link, const Pose& X_WP, double* J) noexcept {
  const PlanLink& plan_link = plan_.links[link];
  const PlanTree& tree = plan_.trees[plan_link.articulation];
  const int nv = tree.model->nv();
  const Matrix3 R_PW = X_WP.R.transpose();
  JacobianMap map(J, 6, nv);
  map.setZero();
  pointJacobian(*tree.model, work_.data() + tree.link, plan_link.local, X_WP.p, J, nv);
  for (int c = 0; c < nv; ++c) {
    map.col(c).head<3>() = Vector3(R_PW * Vector3(map.col(c).head<3>()));
    map.col(c).tail<3>() = Vector3(R_PW * Vector3(map.col(c).tail<3>()));
  }
}

void ImplicitStep::assembleContact(const ImplicitContact& contact) noexcept {
  const int link_a = plan_.shapes[contact.shape_a].link, link_b = plan_.shapes[contact.shape_b].link;
  const int tree_a = plan_.links[link_a].articulation, tree_b = plan_.links[link_b].articulation;
  const int a = node_of_tree_[tree_a], b = node_of_tree_[tree_b];
  const bool free_a = a < 0 || plan_.trees[tree_a].model->isFreeBody();
  const bool free_b = b < 0 || plan_.trees[tree_b].model->isFreeBody();
  if (!free_a || !free_b) {
    assembleTreeContact(contact);
    return;
  }
  Matrix6 J_a, block;
  if (a >= 0) {
    J_a = freeJacobian(link_a, contact.X_WP);
    block.noalias() = J_a.transpose() * (contact.G_P * J_a);
    matrix_.add(a, a, block.data());
  }
  if (b < 0) return;
  const Matrix6 J_b = freeJacobian(link_b, contact.X_WP);
  const Matrix6 weighted = contact.G_P * J_b;
  block.noalias() = J_b.transpose() * weighted;
  matrix_.add(b, b, block.data());
  if (a < 0) return;
  block.noalias() = -J_a.transpose() * weighted;
  matrix_.add(a, b, block.data());
}

void ImplicitStep::assembleTreeContact(const ImplicitContact& contact) noexcept {
  const int link[2] = {plan_.shapes[contact.shape_a].link, plan_.shapes[contact.shape_b].link};
  double* J[2] = {jacobian_a_.data(), jacobian_b_.data()};
  int node[2], size[2];
  for (int s = 0; s < 2; ++s) {
    node[s] = node_of_tree_[plan_.links[link[s]].articulation];
    size[s] = node[s] >= 0 ? node_size_[node[s]] : 0;
    if (node[s] >= 0) treeJacobian(link[s], contact.X_WP, J[s]);
  }
  if (node[0] >= 0 && node[0] == node[1]) {  // two links of one tree: J = J_b - J_a
    for (int i = 0; i < 6 * size[0]; ++i) J[1][i] -= J[0][i];
    node[0] = -1;
  }
  for (int s = 0; s < 2; ++s) {
    if (node[s] < 0) continue;
    JacobianMap Js(J[s], 6, size[s]), weighted(weighted_.data(), 6, size[s]);
    weighted.noalias() = contact.G_P.lazyProduct(Js);
    for (int t = 0; t <= s; ++t) {
      if (node[t] < 0) continue;
      JacobianMap Jt(J[t], 6, size[t]);
      Eigen::Map<Eigen::MatrixXd> block(block_.data(), size[t], size[s]);
      block.noalias() = Jt.transpose().lazyProduct(weighted);
      if (s != t) block = -block;
      matrix_.add(node[t], node[s], block_.data());
    }
  }
}

void ImplicitStep::commit(double g) noexcept {
  // The last Newton step was not evaluated: q follows from v, forces and friction from the evaluation before.
  for (int n = 0; n < nodes_; ++n) {
    const PlanTree& tree = plan_.trees[tree_of_node_[n]];
    std::copy(q_base_.begin() + tree.q, q_base_.begin() + tree.q + tree.model->nq(), state_->q.begin() + tree.q);
    integratePositions(*tree.model, state_->q.data() + tree.q, v_.data() + tree.v, g);
    std::copy(v_.begin() + tree.v, v_.begin() + tree.v + tree.model->nv(), state_->v.begin() + tree.v);
  }
  for (int i = 0; i < state_->pair_count; ++i) {
    state_->pairs[i].friction = FrictionMemory{};
    state_->pairs[i].area = 0;
  }
  for (const ImplicitContact& c : contacts_) {
    state_->pairs[c.pair].friction = c.force.memory;
    state_->pairs[c.pair].area = c.volume.A0;
  }
}

}  // namespace haptic
