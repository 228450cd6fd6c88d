#include "haptic_core/stepping/implicit_stage.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/dynamics/joint_space_inertia.h"
#include "haptic_core/geometry/contact_integrals.h"
#include "haptic_core/geometry/convex_polyhedron.h"

namespace haptic {
namespace {

/// Newton ends when its step is this small against the speeds of the step (relative), plus what rounding of
/// coordinates amounts to: kRounding of the distance from W's origin, per step. Larger lets resting bodies creep;
/// smaller iterates on rounding.
constexpr double kTolerance = 1e-13;
constexpr double kRounding = 4 * 2.2e-16;
/// Steps that shrink no more, but are this small already, are rounding in a stiff contact.
constexpr double kStagnation = 1e-9;
/// Roundings that the normal speed of a contact may still have where friction's end Newton.
constexpr double kSlack = 8;
constexpr int kMaxIterations = 15;    ///< before stiffness is built up in steps
constexpr int kMaxContinuation = 60;  ///< Newton steps at one stiffness of the continuation
constexpr int kMaxLineSearch = 10;   ///< evaluations; each halves the bracket at least
constexpr double kSufficient = 0.5;  ///< a step is good when |φ(α)| falls to this share of |φ(0)|

using JacobianMap = Eigen::Map<Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>>;

}  // namespace

ImplicitStage::ImplicitStage(const Model& model)
    : model_(model),
      settings_(model.settings),
      joints_(model),
      matrix_(static_cast<int>(model.trees.size()), model.pair_capacity,
              // The dense factor, but no more than 64 MB: beyond, a step falls back to more, smaller solves.
              std::min<std::size_t>(static_cast<std::size_t>(model.nv) * (model.nv + 1), std::size_t{8} << 20)),
      seams_(model) {
  const int trees = static_cast<int>(model.trees.size());
  node_of_tree_.assign(trees, -1);
  node_size_.resize(trees);
  int largest = 1;
  for (const ModelTree& tree : model.trees) largest = std::max(largest, tree.model->nv());
  q_base.resize(model.nq);
  q_.resize(model.nq);
  for (auto* vector : {&v_base, &v, &trial_, &residual_, &step_, &v_dot_, &rows_}) vector->resize(model.nv);
  memory_base.resize(model.pair_capacity);
  yielding.resize(model.pair_capacity);
  work_.resize(model.links.size());
  held_by_.resize(model.links.size());
  X_WS_.resize(model.shapes.size());
  for (const ModelTree& tree : model.trees) {
    const auto first = std::find_if(model.shapes.begin(), model.shapes.end(),
                                    [&](const ModelShape& shape) { return shape.link >= tree.link; });
    first_shape_.push_back(static_cast<int>(first - model.shapes.begin()));
  }
  first_shape_.push_back(static_cast<int>(model.shapes.size()));
  contacts_.reserve(model.pair_capacity);
  edges_.reserve(model.pair_capacity);
  if (!joints_.empty()) matrix_.reserveKept();
  model.reserve(workspace_);
  mass_matrix_.resize(static_cast<std::size_t>(largest) * largest);
  block_.resize(mass_matrix_.size());
  for (auto* J : {&jacobian_a_, &jacobian_b_, &weighted_}) J->resize(6 * static_cast<std::size_t>(largest));
}

void ImplicitStage::begin(State& state, const std::vector<int>& held_by) noexcept {
  state_ = &state;
  std::copy(held_by.begin(), held_by.end(), held_by_.begin());
  std::copy(state.q.begin(), state.q.end(), q_.begin());
  for (std::size_t t = 0; t < model_.trees.size(); ++t) place(static_cast<int>(t), state.v);
  iterations = evaluations = 0;
  residual = 0;
  island_ = Island{};  // its arrays may have been filled anew
  std::fill(node_of_tree_.begin(), node_of_tree_.end(), -1);
}

void ImplicitStage::select(const Island& island) noexcept {
  for (int n = 0; n < island_.tree_count; ++n) node_of_tree_[island_.trees[n]] = -1;
  island_ = island;
  has_joints_ = false;
  for (int n = 0; n < island.tree_count; ++n) {
    node_of_tree_[island.trees[n]] = n;
    node_size_[n] = model_.trees[island.trees[n]].model->nv();
    has_joints_ |= model_.trees[island.trees[n]].has_laws;
  }
  if (has_joints_) joints_.setNodes(node_of_tree_, island.tree_count);
  contacts_.clear();
}

void ImplicitStage::start(double g) noexcept {
  if (has_joints_) joints_.startStage(*state_, q_base.data(), g, v.data());
}

/// Newton from the guess in v; when that fails, with the stiffness built up.
bool ImplicitStage::solve(double g, double left) noexcept {
  left_ = left;
  softness_ = 1;
  start(g);
  if (newton(g, kMaxIterations)) return true;
  // From where g² k_eff equals a tenth of the inertia; the contacts of the last evaluation tell how stiff they are.
  double stiffest = 0;
  for (const ImplicitContact& c : contacts_) {
    const PairLaw law = model_.law(c.shape_a, c.shape_b, false, false);
    stiffest = std::max(stiffest, g * g * law.material.stiffness * c.volume.A0 / law.reduced_mass);
  }
  int decades = stiffest > 0.1 ? static_cast<int>(std::ceil(std::log10(stiffest / 0.1))) : 1;
  move(0, v_base, v);
  start(g);
  bool converged = false;
  for (; decades >= 0; --decades) {
    softness_ = std::pow(10.0, -decades);
    converged = newton(g, kMaxContinuation);
  }
  return converged;
}

/// to = from + α p over the island.
void ImplicitStage::move(double alpha, const std::vector<double>& from, std::vector<double>& to) noexcept {
  for (int n = 0; n < island_.tree_count; ++n) {
    const int first = model_.trees[island_.trees[n]].v;
    for (int i = first; i < first + node_size_[n]; ++i) to[i] = from[i] + (alpha != 0 ? alpha * step_[i] : 0.0);
  }
  if (alpha == 1 && has_joints_) joints_.settle(to.data());
}

bool ImplicitStage::newton(double g, int max_iterations) noexcept {
  double last = 1e300;
  evaluate(v, g);
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    if (!assemble(g) || !findDirection()) return false;
    const double phi_0 = slope(v);
    ++iterations;
    residual = speed(step_);
    if (converges(g, last)) {
      // The step is rounding: taken without looking again, the forces are those of the evaluation before it.
      move(1, v, v);
      return true;
    }
    last = residual;
    const double alpha = lineSearch(g, phi_0);
    move(alpha, v, v);
  }
  return false;
}

/// Newton's step p into step_: A p = -R, with what the joints do by themselves.
bool ImplicitStage::findDirection() noexcept {
  if (has_joints_) {
    return joints_.solve(matrix_, work_.data(), q_.data(), v.data(), residual_.data(), step_.data());
  }
  if (!matrix_.factor()) return false;
  for (int n = 0, row = 0; n < island_.tree_count; ++n) {
    const int first = model_.trees[island_.trees[n]].v;
    for (int i = 0; i < node_size_[n]; ++i) rows_[row++] = -residual_[first + i];
  }
  matrix_.solve(rows_.data());
  for (int n = 0, row = 0; n < island_.tree_count; ++n) {
    const int first = model_.trees[island_.trees[n]].v;
    for (int i = first; i < first + node_size_[n]; ++i) step_[i] = rows_[row++];
  }
  return true;
}

/// φ = R(v)·p at the last evaluation, which was at `velocity`.
double ImplicitStage::slope(const std::vector<double>& velocity) const noexcept {
  double phi = 0;
  for (int n = 0; n < island_.tree_count; ++n) {
    const int first = model_.trees[island_.trees[n]].v;
    for (int i = first; i < first + node_size_[n]; ++i) phi += step_[i] * residual_[i];
  }
  return has_joints_ ? phi + joints_.slope(velocity.data(), step_.data()) : phi;
}

/// Speed along the patches that rounding of coordinates makes uncertain: the normal force is uncertain by k A0 times as
/// much, friction that slides with it, and nothing holds that back.
double ImplicitStage::slidingNoise(double g) const noexcept {
  double speed = 0;
  for (const ImplicitContact& c : contacts_) {
    if (c.force.sticking || !(c.force.normal_force > 0)) continue;
    const double mu = c.force.F_BP_P.force.head<2>().norm() / c.force.normal_force;
    const double mass = model_.law(c.shape_a, c.shape_b, false, false).reduced_mass;
    speed += g * mu * c.stiffness * std::abs(c.volume.A0) / mass * kRounding * farthest();
  }
  return speed;
}

/// Largest speed along a patch's normal in the last Newton step.
double ImplicitStage::normalStep() const noexcept {
  double largest = 0;
  for (const ImplicitContact& c : contacts_) {
    double speed = 0;
    for (const int shape : {c.shape_a, c.shape_b}) {
      const ModelLink& link = model_.links[model_.shapes[shape].link];
      if (nodeOf(model_.shapes[shape].link) < 0) continue;
      const ModelTree& tree = model_.trees[link.articulation];
      const Twist step = pointTwist(*tree.model, work_.data() + tree.link, link.local, c.X_WP.p, step_.data() + tree.v);
      speed += (shape == c.shape_b ? 1 : -1) * c.X_WP.R.col(2).dot(step.linear);
    }
    largest = std::max(largest, std::abs(speed));
  }
  return largest;
}

bool ImplicitStage::converges(double g, double last) const noexcept {
  const double scale = speed(v) + settings_.gravity.norm() * g, finest = kTolerance * scale + kRounding * farthest() / g;
  if (residual <= finest) return true;
  // What shrinks no more is rounding, if it is as small. What slides is uncertain along its patch alone.
  if (residual < 0.5 * last) return false;
  return residual <= kStagnation * scale || (residual <= slidingNoise(g) && normalStep() <= kSlack * finest);
}

/// The α whose φ(α) = R(v + α p)·p is small against φ(0); leaves R and the contacts of v + α p behind.
double ImplicitStage::lineSearch(double g, double phi_0) noexcept {
  double low = 0, phi_low = phi_0, high = 0, phi_high = 0, alpha = 1;
  for (int i = 0; i < kMaxLineSearch; ++i) {
    move(alpha, v, trial_);
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

double ImplicitStage::speed(const std::vector<double>& velocity) const noexcept {
  double largest2 = 0;
  for (int n = 0; n < island_.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island_.trees[n]];
    const double size = model_.links[tree.link].size;
    const double* u = velocity.data() + tree.v;
    if (tree.model->isFreeBody()) {
      const double turn2 = u[0] * u[0] + u[1] * u[1] + u[2] * u[2], way2 = u[3] * u[3] + u[4] * u[4] + u[5] * u[5];
      largest2 = std::max(largest2, way2 + size * size * turn2);
    } else {
      for (int i = 0; i < tree.model->nv(); ++i) largest2 = std::max(largest2, size * size * u[i] * u[i]);
    }
  }
  return std::sqrt(largest2);
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

/// Contacts and residual at a velocity: poses at the end of the stage.
void ImplicitStage::evaluate(const std::vector<double>& velocity, double g) noexcept {
  ++evaluations;
  for (int n = 0; n < island_.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island_.trees[n]];
    std::copy_n(q_base.begin() + tree.q, tree.model->nq(), q_.begin() + tree.q);
    integratePositions(*tree.model, q_.data() + tree.q, velocity.data() + tree.v, g);
    place(island_.trees[n], velocity);
  }
  for (ImplicitCoupling& coupling : couplings) pull(coupling);
  contacts_.clear();
  if (seams_.any()) {
    seams_.find(state_->pairs.data(), island_.pairs, island_.pair_count, X_WS_.data(), workspace_);
  }
  for (int i = 0; i < island_.pair_count; ++i) evaluatePair(island_.pairs[i], g);
  for (int n = 0; n < island_.tree_count; ++n) {
    const ModelTree& tree = model_.trees[island_.trees[n]];
    for (int i = tree.v; i < tree.v + node_size_[n]; ++i) v_dot_[i] = (velocity[i] - v_base[i]) / g;
    inverseDynamics(*tree.model, settings_.gravity, v_dot_.data() + tree.v, work_.data() + tree.link,
                    residual_.data() + tree.v);
    for (int i = tree.v; i < tree.v + node_size_[n]; ++i) residual_[i] *= g;
  }
}

/// Of a pair at the poses of the last evaluation; leaves it in the workspace.
void ImplicitStage::findVolume(int index, ContactVolume& volume) noexcept {
  ActivePair& pair = state_->pairs[index];
  const int a = pair.shapeA(), b = pair.shapeB();
  const NormalRule rule = seams_.ruleFor(index, settings_.normal_rule, X_WS_[a], pair.cache);
  in_workspace_ = -1;
  contactVolume(*model_.shapes[a].shape, *model_.shapes[b].shape, relativePose(X_WS_[a], X_WS_[b]), pair.cache, workspace_,
                volume, rule, rule == NormalRule::kAreaVector ? model_.inner(a, b) : InnerSides{});
}

void ImplicitStage::measureElastic() noexcept {
  for (int i = contacts_.size() - 1; i >= 0; --i) {
    if (i == in_workspace_) {
      contacts_[i].elastic = 0.5 * contacts_[i].stiffness * thicknessSquared(workspace_, contacts_[i].volume);
      continue;
    }
    ContactVolume volume;
    findVolume(contacts_[i].pair, volume);
    if (volume.status != ContactVolume::Status::kOverlap) continue;
    contacts_[i].elastic = 0.5 * contacts_[i].stiffness * thicknessSquared(workspace_, volume);
  }
}

void ImplicitStage::evaluatePair(int index, double g) noexcept {
  const ActivePair& pair = state_->pairs[index];
  const int shape_a = pair.shapeA(), shape_b = pair.shapeB();
  const ModelShape &A = model_.shapes[shape_a], &B = model_.shapes[shape_b];
  ContactVolume volume;
  findVolume(index, volume);
  if (volume.status != ContactVolume::Status::kOverlap) return;
  contacts_.resize(contacts_.size() + 1);  // in place: a contact is 1.5 kB
  in_workspace_ = contacts_.size() - 1;
  ImplicitContact& contact = contacts_[contacts_.size() - 1];
  contact.pair = index;
  contact.shape_a = shape_a;
  contact.shape_b = shape_b;
  contact.volume = volume;
  LinkWork &a = work_[A.link], &b = work_[B.link];
  contact.X_WP = X_WS_[shape_a] * volume.X_AP;
  const Twist V_AB_P = (b.twistAt(contact.X_WP.p) - a.twistAt(contact.X_WP.p)).rotated(contact.X_WP.R.transpose());
  PairLaw law = model_.law(shape_a, shape_b, held_by_[A.link] >= 0, held_by_[B.link] >= 0);
  if (pair.buried != 0) law = model_.recoveryLaw(law, shape_a, shape_b, volume);
  law.material.stiffness *= softness_;
  law.material.damping *= softness_;
  law.material.tangential_stiffness *= softness_;
  Advance advance;
  advance.time = g;
  advance.yielding = yielding[index];
  contact.force = locatedForce(volume, workspace_, V_AB_P, memory_base[index], law, advance);
  contact.G_P = contact.force.tangent.combined(g * g, g);
  contact.stiffness = law.material.stiffness;
  contact.elastic = 0;
  const Wrench F_BP_W = contact.force.F_BP_P.rotated(contact.X_WP.R);
  b.addWrench(F_BP_W, contact.X_WP.p);
  a.addWrench(-F_BP_W, contact.X_WP.p);
}

/// The target moves at its own velocity, so that a stage inside the step sees it where it is then.
void ImplicitStage::pull(ImplicitCoupling& coupling) noexcept {
  if (coupling.link < 0 || nodeOf(coupling.link) < 0) return;
  LinkWork& link = work_[coupling.link];
  const PointerCoupling& c = coupling.law;
  const Vector3 p = coupling.X_WL.p - left_ * coupling.V_WL.linear;
  const Quaternion back = rotationFromVector(-left_ * coupling.V_WL.angular);
  const Vector3 turn = vectorFromRotation(back * Quaternion(coupling.X_WL.R) * Quaternion(link.X_WL.R).conjugate());
  const Twist V = link.twistAtOrigin();
  coupling.F_W.force = c.stiffness * (p - link.X_WL.p) + c.damping * (coupling.V_WL.linear - V.linear);
  coupling.F_W.torque = c.rotational_stiffness * turn + c.rotational_damping * (coupling.V_WL.angular - V.angular);
  coupling.power = power(coupling.F_W, V);
  link.addWrench(coupling.F_W, link.X_WL.p);
}

bool ImplicitStage::assemble(double g) noexcept {
  edges_.clear();
  for (const ImplicitContact& c : contacts_) {
    const int a = nodeOf(model_.shapes[c.shape_a].link), b = nodeOf(model_.shapes[c.shape_b].link);
    if (a >= 0 && b >= 0 && a != b) edges_.push_back({a, b});
  }
  if (!matrix_.analyze(node_size_.data(), island_.tree_count, edges_.begin(), edges_.size())) return false;
  for (int n = 0; n < island_.tree_count; ++n) assembleMass(n);
  for (const ImplicitContact& c : contacts_) assembleContact(c);
  for (const ImplicitCoupling& c : couplings) {
    if (c.link >= 0 && nodeOf(c.link) >= 0) assembleCoupling(c, g);
  }
  return true;
}

void ImplicitStage::assembleMass(int n) noexcept {
  const ModelTree& tree = model_.trees[island_.trees[n]];
  if (!tree.model->isFreeBody()) {
    massMatrix(*tree.model, work_.data() + tree.link, mass_matrix_.data());
    matrix_.add(n, n, mass_matrix_.data());
    return;
  }
  const LinkModel& body = tree.model->link(0);
  const Matrix3& R_WL = work_[tree.link].X_WL.R;
  Matrix6 M = Matrix6::Zero();
  M.topLeftCorner<3, 3>() = R_WL * body.I_O * R_WL.transpose();
  M(3, 3) = M(4, 4) = M(5, 5) = body.mass;
  matrix_.add(n, n, M.data());
}

/// Rows: the twist at P in P's axes, angular first; columns: ω and v of the free body.
Matrix6 ImplicitStage::freeJacobian(int link, const Pose& X_WP) const noexcept {
  const Matrix3 R_PW = X_WP.R.transpose();
  Matrix6 J;
  J.topLeftCorner<3, 3>() = R_PW;
  J.topRightCorner<3, 3>().setZero();
  J.bottomLeftCorner<3, 3>() = -R_PW * crossMatrix(X_WP.p - work_[link].p_WO);
  J.bottomRightCorner<3, 3>() = R_PW;
  return J;
}

/// The same for a link of a tree; columns: the tree's degrees.
void ImplicitStage::treeJacobian(int link, const Pose& X_WP, double* J) noexcept {
  const ModelLink& entry = model_.links[link];
  const ModelTree& tree = model_.trees[entry.articulation];
  const int nv = tree.model->nv();
  const Matrix3 R_PW = X_WP.R.transpose();
  JacobianMap map(J, 6, nv);
  map.setZero();
  pointJacobian(*tree.model, work_.data() + tree.link, entry.local, X_WP.p, J, nv);
  for (int c = 0; c < nv; ++c) {
    map.col(c).head<3>() = Vector3(R_PW * Vector3(map.col(c).head<3>()));
    map.col(c).tail<3>() = Vector3(R_PW * Vector3(map.col(c).tail<3>()));
  }
}

void ImplicitStage::assembleContact(const ImplicitContact& contact) noexcept {
  const int link_a = model_.shapes[contact.shape_a].link, link_b = model_.shapes[contact.shape_b].link;
  const int a = nodeOf(link_a), b = nodeOf(link_b);
  if ((a >= 0 && !isFree(link_a)) || (b >= 0 && !isFree(link_b))) {
    assembleTrees(link_a, link_b, contact.X_WP, contact.G_P);
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

/// The coupling's springs and dampers, at the origin of the link's frame in W's axes.
void ImplicitStage::assembleCoupling(const ImplicitCoupling& coupling, double g) noexcept {
  const PointerCoupling& c = coupling.law;
  Matrix6 G = Matrix6::Zero();
  G.diagonal().head<3>().setConstant(g * g * c.rotational_stiffness + g * c.rotational_damping);
  G.diagonal().tail<3>().setConstant(g * g * c.stiffness + g * c.damping);
  const Pose X_WP(work_[coupling.link].X_WL.p);
  if (!isFree(coupling.link)) {
    assembleTrees(-1, coupling.link, X_WP, G);
    return;
  }
  const Matrix6 J = freeJacobian(coupling.link, X_WP);
  const Matrix6 block = J.transpose() * (G * J);
  matrix_.add(nodeOf(coupling.link), nodeOf(coupling.link), block.data());
}

/// Jᵀ G J of a patch between two links, link A -1 for none; at least one of them is on joints.
void ImplicitStage::assembleTrees(int link_a, int link_b, const Pose& X_WP, const Matrix6& G_P) noexcept {
  const int link[2] = {link_a, link_b};
  double* J[2] = {jacobian_a_.data(), jacobian_b_.data()};
  int node[2], size[2];
  for (int s = 0; s < 2; ++s) {
    node[s] = link[s] >= 0 ? nodeOf(link[s]) : -1;
    size[s] = node[s] >= 0 ? node_size_[node[s]] : 0;
    if (node[s] >= 0) treeJacobian(link[s], X_WP, J[s]);
  }
  if (node[0] >= 0 && node[0] == node[1]) {  // two links of one tree: J = J_b - J_a
    for (int i = 0; i < 6 * size[0]; ++i) J[1][i] -= J[0][i];
    node[0] = -1;
  }
  for (int s = 0; s < 2; ++s) {
    if (node[s] < 0) continue;
    JacobianMap Js(J[s], 6, size[s]), weighted(weighted_.data(), 6, size[s]);
    weighted.noalias() = G_P.lazyProduct(Js);
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

}  // namespace haptic
