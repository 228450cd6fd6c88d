#include "haptic_core/dynamics/tree_motion.h"

#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/dynamics/articulated_body.h"

namespace haptic {
namespace {

// Newton steps that put positions on the rings [1]; each gains 3 digits or more at a turn of 0.1 rad a step.
constexpr int kNewtonSteps = 5;
// Largest change of a degree in one of them [rad, m]: further, the linear model of the gap is no guide.
constexpr double kLongestMove = 0.3;
// Newton steps for an initial state, which may be far off [1].
constexpr int kClosingSteps = 200;
// Gap at which those stop [m, rad]: a thousandth of the bound that users see (1 µm).
constexpr double kGap = 1e-10;

}  // namespace

TreeMotion::TreeMotion(const Articulation& articulation, std::vector<RingDef> rings)
    : articulation_(articulation), rings_(articulation, std::move(rings)) {
  const int n = articulation.linkCount(), nv = articulation.nv(), rows = rings_.rows();
  for (int i = 0; i < n; ++i) {
    const LinkModel& link = articulation.link(i);
    joints_.push_back(ownLaw(articulation.def().links[i].joint));
    const JointDef& joint = joints_.back();
    if (link.dof == 1 && hasLaw(joint)) laws_.push_back({i, link.v, link.q});
    if (link.dof < 2 || link.floating) continue;
    if (joint.damping > 0)
      for (int k = 0; k < link.dof; ++k) damped_.emplace_back(link.v + k, joint.damping);
    JointDef rest = joint;
    rest.damping = 0;
    if (hasLaw(rest))
      unsupported_.push_back(articulation.def().name + "/" + joint.name +
                             ": friction, limits and drives of joints of several degrees are not simulated");
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
  S_ = PivotedCholesky(rows);
  phi_.resize(rows);
  lambda_.resize(rows);
  response_.resize(12 * n);
  drive_force_.resize(n);
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

/// S = G M̃⁻¹ Gᵀ and its factor.
void TreeMotion::factorRings(const LinkWork* work) noexcept {
  const int nv = articulation_.nv(), rows = rings_.rows();
  rings_.jacobian(work, G_.data());
  for (int r = 0; r < rows; ++r)
    accelerationResponse(articulation_, &G_[r * nv], work, response_.data(), &Y_[r * nv]);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < rows; ++c) {
      double sum = 0;
      for (int k = 0; k < nv; ++k) sum += G_[r * nv + k] * Y_[c * nv + k];
      S_.matrix()[r * rows + c] = sum;
    }
  S_.factor(rows);
}

/// One pass: v̇ with every joint on its piece and the rings closed at the end of the step. `lambda_` holds
/// −φ/h.
void TreeMotion::solveOnce(const Vector3& gravity, double h, const double* v, LinkWork* work,
                           double* v_dot) noexcept {
  const int nv = articulation_.nv(), rows = rings_.rows();
  holdPieces(v, h, v_dot);
  for (int k = 0; k < nv; ++k) tau_[k] = law_tau_[k] + (tau_given_ ? tau_given_[k] : 0);
  accelerations(articulation_, gravity, tau_.data(), diag_.data(), work, v_dot);
  ++report_.passes;
  if (rows == 0) return;
  factorRings(work);
  for (int r = 0; r < rows; ++r) {
    double rate = 0;
    for (int k = 0; k < nv; ++k) rate += G_[r * nv + k] * (v[k] + h * v_dot[k]);
    phi_[r] = (lambda_[r] - rate) / h;
  }
  S_.solve(phi_.data());
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
  const double others = tau_[law.v] - law_tau_[law.v];  // rings and what the caller gave
  return axis.dot(articulation_.link(law.link).slides ? F.force : F.torque) - others;
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
    const double force = piece.vertical ? forceOf(law, piece, gravity, work, v1) : 0;
    moved |= graphs_[k].follow(v1, force, piece_[k]);
  }
  return moved;
}

const JointReport& TreeMotion::accelerate(const Vector3& gravity, double h, const JointCommand* commands,
                                          const double* q, const double* v, LinkWork* work, double* v_dot,
                                          const double* tau) noexcept {
  report_ = {};
  tau_given_ = tau;
  if (isPlain()) {
    accelerations(articulation_, gravity, tau, nullptr, work, v_dot);
    report_.passes = 1;
    return report_;
  }
  for (std::size_t k = 0; k < laws_.size(); ++k) {
    const Law& law = laws_[k];
    buildForceGraph(joints_[law.link], commands[law.link], q[law.q], h, graphs_[k]);
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
  account(commands, q, v, h, gravity, work, v_dot_.data());
  for (int k = 0; k < articulation_.nv(); ++k) v_dot[k] = v_dot_[k];
  return report_;
}

void TreeMotion::account(const JointCommand* commands, const double* q, const double* v, double h,
                         const Vector3& gravity, const LinkWork* work, const double* v_dot) noexcept {
  for (std::size_t k = 0; k < laws_.size(); ++k) {
    const Law& law = laws_[k];
    const JointDef& joint = joints_[law.link];
    const double v1 = v[law.v] + h * v_dot[law.v];
    const double way = 0.5 * h * (v[law.v] + v1);  // force × way is exactly the change of kinetic energy
    const double total = forceOf(law, graphs_[k].pieces[piece_[k]], gravity, work, v1);
    const double drive = driveForce(joint, commands[law.link], q[law.q], h, v1);
    drive_force_[law.link] = drive;
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
    S_.solve(phi_.data());
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

const JointReport& TreeMotion::step(const Vector3& gravity, double h, const JointCommand* commands, double* q,
                                    double* v, LinkWork* work, const double* tau) noexcept {
  accelerate(gravity, h, commands, q, v, work, v_dot_.data(), tau);
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
