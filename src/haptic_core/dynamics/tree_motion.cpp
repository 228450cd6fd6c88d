#include "haptic_core/dynamics/tree_motion.h"

#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/dynamics/articulated_body.h"

namespace haptic {
namespace {

// Passes in which every misplaced joint moves, before one at a time; above, only time is lost [1].
constexpr int kBlockPasses = 8;
// Passes per joint law after that; Murty's rule needs fewer in practice, its worst case is out of reach [1].
constexpr int kSinglePasses = 4;
// Newton steps that put positions on the rings [1]; each gains 3 digits or more at a turn of 0.1 rad a step.
constexpr int kNewtonSteps = 5;
// Largest change of a degree in one of them [rad, m]: further, the linear model of the gap is no guide.
constexpr double kLongestMove = 0.3;
// Newton steps for an initial state, which may be far off [1].
constexpr int kClosingSteps = 200;
// Gap at which those stop [m, rad]: a thousandth of the bound that users see (1 µm).
constexpr double kGap = 1e-10;
// Rows whose pivot falls below this share of the largest are redundant [1]. Larger: real constraints are
// lost; smaller: rounding of a redundant row is inverted.
constexpr double kRedundant = 1e-9;
// Slack of a stuck joint's force, relative: keeps rounding from moving it back and forth [1].
constexpr double kForceSlack = 1e-12;

JointDef lawOf(const TreeDef& def, int link) {
  JointDef joint = def.links[link].joint;
  if (joint.mimic_joint < 0) return joint;
  // The followed joint has limits, friction and drive for both; a second set would contradict them.
  const double kInfinity = std::numeric_limits<double>::infinity();
  joint.lower = -kInfinity;
  joint.upper = kInfinity;
  joint.friction = 0;
  joint.drive = JointDef::Drive::kNone;
  return joint;
}

}  // namespace

TreeMotion::TreeMotion(const Articulation& articulation, std::vector<RingDef> rings)
    : articulation_(articulation), rings_(articulation, std::move(rings)) {
  const int n = articulation.linkCount(), nv = articulation.nv(), rows = rings_.rows();
  for (int i = 0; i < n; ++i) {
    const LinkModel& link = articulation.link(i);
    joints_.push_back(lawOf(articulation.def(), i));
    const JointDef& joint = joints_.back();
    JointCommand command;
    command.position = joint.position;
    commands_.push_back(command);
    if (link.dof == 1 && hasLaw(joint)) laws_.push_back({i, link.v, link.q});
    if (link.dof != 3) continue;
    if (joint.damping > 0)
      for (int k = 0; k < 3; ++k) damped_.emplace_back(link.v + k, joint.damping);
    JointDef rest = joint;
    rest.damping = 0;
    if (hasLaw(rest))
      unsupported_.push_back(articulation.def().name + "/" + joint.name +
                             ": friction, limits and drives of joints of three degrees are not simulated");
  }
  graphs_.resize(laws_.size());
  piece_.resize(laws_.size());
  tau_.resize(nv);
  law_tau_.resize(nv);
  diag_.resize(nv);
  v_dot_.resize(nv);
  v_target_.resize(nv);
  G_.resize(rows * nv);
  Y_.resize(rows * nv);
  S_.resize(rows * rows);
  phi_.resize(rows);
  lambda_.resize(rows);
  response_.resize(12 * n);
  pivot_.resize(rows);
}

bool TreeMotion::setCommand(int link, const JointCommand& command) noexcept {
  if (!std::isfinite(command.position) || !std::isfinite(command.velocity) || !std::isfinite(command.effort))
    return false;
  commands_[link] = command;
  return true;
}

/// τ, diag and prescribed v̇ of the pieces the joints are on.
void TreeMotion::holdPieces(const double* v, double h, double* v_dot) noexcept {
  for (std::size_t k = 0; k < tau_.size(); ++k) law_tau_[k] = diag_[k] = 0;
  for (const auto& [dof, damping] : damped_) {
    law_tau_[dof] = -damping * v[dof];
    diag_[dof] = h * damping;
  }
  for (std::size_t k = 0; k < laws_.size(); ++k) {
    const ForcePiece& piece = graphs_[k].pieces[piece_[k]];
    const int dof = laws_[k].v;
    if (piece.vertical) {
      diag_[dof] = std::numeric_limits<double>::infinity();
      v_dot[dof] = (piece.from - v[dof]) / h;
    } else {
      law_tau_[dof] = piece.offset - piece.slope * v[dof];
      diag_[dof] = h * piece.slope;
    }
  }
}

/// S = G M̃⁻¹ Gᵀ and its Cholesky factor with pivoting; rows beyond the rank are redundant.
void TreeMotion::factorRings(const LinkWork* work) noexcept {
  const int nv = articulation_.nv(), rows = rings_.rows();
  rings_.jacobian(work, G_.data());
  for (int r = 0; r < rows; ++r)
    accelerationResponse(articulation_, &G_[r * nv], work, response_.data(), &Y_[r * nv]);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < rows; ++c) {
      double sum = 0;
      for (int k = 0; k < nv; ++k) sum += G_[r * nv + k] * Y_[c * nv + k];
      S_[r * rows + c] = sum;
    }
  // Rows of length and of angle differ in unit: each is compared with its own size.
  for (int r = 0; r < rows; ++r) {
    pivot_[r] = r;
    phi_[r] = S_[r * rows + r];  // its own size, for the moment
  }
  rank_ = 0;
  for (; rank_ < rows; ++rank_) {
    int best = rank_;
    double best_share = -1;
    for (int r = rank_; r < rows; ++r) {
      const double share = phi_[pivot_[r]] > 0 ? S_[pivot_[r] * rows + pivot_[r]] / phi_[pivot_[r]] : 0;
      if (share > best_share) {
        best_share = share;
        best = r;
      }
    }
    if (!(best_share > kRedundant)) break;
    std::swap(pivot_[rank_], pivot_[best]);
    const int p = pivot_[rank_];
    const double root = std::sqrt(S_[p * rows + p]);
    S_[p * rows + p] = root;
    for (int r = rank_ + 1; r < rows; ++r) S_[pivot_[r] * rows + p] /= root;
    for (int r = rank_ + 1; r < rows; ++r)
      for (int c = rank_ + 1; c < rows; ++c)
        S_[pivot_[r] * rows + pivot_[c]] -= S_[pivot_[r] * rows + p] * S_[pivot_[c] * rows + p];
  }
}

/// λ ← S⁻¹ λ on the independent rows, 0 on the others.
void TreeMotion::solveRings(double* lambda) const noexcept {
  const int rows = rings_.rows();
  for (int i = 0; i < rank_; ++i) {
    const int p = pivot_[i];
    for (int j = 0; j < i; ++j) lambda[p] -= S_[p * rows + pivot_[j]] * lambda[pivot_[j]];
    lambda[p] /= S_[p * rows + p];
  }
  for (int i = rank_ - 1; i >= 0; --i) {
    const int p = pivot_[i];
    for (int j = i + 1; j < rank_; ++j) lambda[p] -= S_[pivot_[j] * rows + p] * lambda[pivot_[j]];
    lambda[p] /= S_[p * rows + p];
  }
  for (int i = rank_; i < rows; ++i) lambda[pivot_[i]] = 0;
}

/// One pass: v̇ with every joint on its piece and the rings closed at the end of the step. `lambda_` holds
/// −φ/h.
void TreeMotion::solveOnce(const Vector3& gravity, double h, const double* v, LinkWork* work,
                           double* v_dot) noexcept {
  const int nv = articulation_.nv(), rows = rings_.rows();
  holdPieces(v, h, v_dot);
  tau_ = law_tau_;
  accelerations(articulation_, gravity, tau_.data(), diag_.data(), work, v_dot);
  ++report_.passes;
  if (rows == 0) return;
  factorRings(work);
  for (int r = 0; r < rows; ++r) {
    double rate = 0;
    for (int k = 0; k < nv; ++k) rate += G_[r * nv + k] * (v[k] + h * v_dot[k]);
    phi_[r] = (lambda_[r] - rate) / h;
  }
  solveRings(phi_.data());
  for (int k = 0; k < nv; ++k)
    for (int r = 0; r < rows; ++r) tau_[k] += G_[r * nv + k] * phi_[r];
  accelerations(articulation_, gravity, tau_.data(), diag_.data(), work, v_dot);
}

/// Force of the joint's own law: read off the graph, or what it takes to move as prescribed.
double TreeMotion::forceOf(const Law& law, const ForcePiece& piece, const Vector3& gravity,
                           const LinkWork* work, double v1) const noexcept {
  if (!piece.vertical) return piece.offset - piece.slope * v1;
  const Wrench F = jointWrench(articulation_, work, law.link, gravity);
  const Vector3 axis = work[law.link].S.col(0);
  const double ring = tau_[law.v] - law_tau_[law.v];
  return axis.dot(joints_[law.link].type == JointType::kPrismatic ? F.force : F.torque) - ring;
}

/// Moves joints that left their piece to the next one: all of them, or the last. False: all are where they
/// belong.
bool TreeMotion::movePieces(const double* v, double h, const Vector3& gravity, const LinkWork* work,
                            bool all) noexcept {
  bool moved = false;
  for (int k = static_cast<int>(laws_.size()) - 1; k >= 0 && (all || !moved); --k) {
    const Law& law = laws_[k];
    const ForcePiece& piece = graphs_[k].pieces[piece_[k]];
    const double v1 = v[law.v] + h * v_dot_[law.v];
    int direction = 0;
    if (piece.vertical) {
      const double force = forceOf(law, piece, gravity, work, v1);
      const double slack = kForceSlack * std::abs(force);
      direction = force > piece.high + slack ? -1 : force < piece.low - slack ? 1 : 0;
    } else {
      direction = v1 > piece.to ? 1 : v1 < piece.from ? -1 : 0;
    }
    const int next = piece_[k] + direction;
    if (direction == 0 || next < 0 || next >= graphs_[k].count) continue;
    piece_[k] = next;
    moved = true;
  }
  return moved;
}

const JointReport& TreeMotion::accelerate(const Vector3& gravity, double h, const double* q, const double* v,
                                          LinkWork* work, double* v_dot) noexcept {
  report_ = {};
  if (isPlain()) {
    accelerations(articulation_, gravity, nullptr, nullptr, work, v_dot);
    report_.passes = 1;
    return report_;
  }
  for (std::size_t k = 0; k < laws_.size(); ++k) {
    const Law& law = laws_[k];
    buildForceGraph(joints_[law.link], commands_[law.link], q[law.q], h, graphs_[k]);
    piece_[k] = graphs_[k].at(v[law.v]);
  }
  if (!rings_.empty()) {
    rings_.residual(work, q, lambda_.data());
    for (double& l : lambda_) l /= -h;
  }
  const int most = kBlockPasses + kSinglePasses * static_cast<int>(laws_.size());
  for (int pass = 0;; ++pass) {
    solveOnce(gravity, h, v, work, v_dot_.data());
    if (!movePieces(v, h, gravity, work, pass < kBlockPasses)) break;
    if (pass == most) {
      report_.converged = false;
      break;
    }
  }
  account(q, v, h, gravity, work, v_dot_.data());
  for (int k = 0; k < articulation_.nv(); ++k) v_dot[k] = v_dot_[k];
  return report_;
}

void TreeMotion::account(const double* q, const double* v, double h, const Vector3& gravity,
                         const LinkWork* work, const double* v_dot) noexcept {
  for (std::size_t k = 0; k < laws_.size(); ++k) {
    const Law& law = laws_[k];
    const JointDef& joint = joints_[law.link];
    const double v1 = v[law.v] + h * v_dot[law.v];
    const double way = 0.5 * h * (v[law.v] + v1);  // force × way is exactly the change of kinetic energy
    const double total = forceOf(law, graphs_[k].pieces[piece_[k]], gravity, work, v1);
    const double drive = driveForce(joint, commands_[law.link], q[law.q], h, v1);
    report_.damping += joint.damping * v1 * way;
    report_.drives += drive * way;
    report_.friction -= (total - drive + joint.damping * v1) * way;
  }
  for (const auto& [dof, damping] : damped_) {
    const double v1 = v[dof] + h * v_dot[dof];
    report_.damping += damping * v1 * 0.5 * h * (v[dof] + v1);
  }
}

/// Chord Newton: q on φ = 0 with the factors of the last pass; the gap of the mimics and rings left [m, rad].
double TreeMotion::correct(int steps, double* q, const double* v, LinkWork* work) noexcept {
  const int nv = articulation_.nv(), rows = rings_.rows();
  double gap = 0;
  for (int pass = 0; pass <= steps; ++pass) {
    forwardKinematics(articulation_, q, v, work);
    rings_.residual(work, q, phi_.data());
    gap = 0;
    for (int r = 0; r < rows; ++r) gap = std::max(gap, std::abs(phi_[r]));
    if (gap < kGap || pass == steps) break;
    solveRings(phi_.data());
    double longest = kLongestMove;
    for (int k = 0; k < nv; ++k) {
      v_target_[k] = 0;
      for (int r = 0; r < rows; ++r) v_target_[k] -= Y_[r * nv + k] * phi_[r];
      longest = std::max(longest, std::abs(v_target_[k]));
    }
    integratePositions(articulation_, q, v_target_.data(), kLongestMove / longest);
  }
  return gap;
}

const JointReport& TreeMotion::step(const Vector3& gravity, double h, double* q, double* v,
                                    LinkWork* work) noexcept {
  accelerate(gravity, h, q, v, work, v_dot_.data());
  for (int k = 0; k < articulation_.nv(); ++k) v[k] += h * v_dot_[k];
  // A prescribed velocity is met exactly, so that a joint that sticks stays where it is to the last bit.
  for (std::size_t k = 0; k < laws_.size(); ++k) {
    const ForcePiece& piece = graphs_[k].pieces[piece_[k]];
    if (piece.vertical) v[laws_[k].v] = piece.from;
  }
  integratePositions(articulation_, q, v, h);
  if (!rings_.empty()) {
    correct(kNewtonSteps, q, v, work);
    report_.closure = rings_.closure(work);
  }
  return report_;
}

bool TreeMotion::close(double* q, double* v, LinkWork* work) noexcept {
  if (rings_.empty()) return true;
  for (std::size_t k = 0; k < diag_.size(); ++k) diag_[k] = tau_[k] = 0;
  for (int pass = 0; pass < kClosingSteps; ++pass) {
    forwardKinematics(articulation_, q, v, work);
    accelerations(articulation_, Vector3::Zero(), tau_.data(), diag_.data(), work, v_dot_.data());
    factorRings(work);
    if (correct(1, q, v, work) < 1e-9) return true;
  }
  return false;
}

}  // namespace haptic
