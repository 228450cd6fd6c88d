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
  laws_.add(articulation);
  for (int i = 0; i < n; ++i) {
    const LinkModel& link = articulation.link(i);
    if (link.dof < 2 || link.floating) continue;
    JointDef rest = ownLaw(articulation.def().links[i].joint);
    rest.damping = 0;
    if (hasLaw(rest))
      unsupported_.push_back(articulation.def().name + "/" + rest.name +
                             ": friction, limits and drives of joints of several degrees are not simulated");
  }
  tau_.resize(nv);
  law_tau_.resize(nv);
  diag_.resize(nv);
  v_dot_.resize(nv);
  v_end_.resize(nv);
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
  for (const JointLaws::Damped& d : laws_.damped()) {
    law_tau_[d.v] = -d.damping * v[d.v];
    diag_[d.v] = h * d.damping;
  }
  for (const JointLaws::Law& law : laws_.laws()) {
    const ForcePiece& piece = law.now();
    const int dof = law.v;
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
double TreeMotion::forceOf(const JointLaws::Law& law, const Vector3& gravity, const LinkWork* work,
                           double v1) const noexcept {
  if (!law.now().vertical) return law.now().offset - law.now().slope * v1;
  const Wrench F = jointWrench(articulation_, work, law.link, gravity);
  const Vector3 axis = work[law.link].S.col(0);
  const double others = tau_[law.v] - law_tau_[law.v];  // rings and what the caller gave
  return axis.dot(articulation_.link(law.link).slides ? F.force : F.torque) - others;
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
  laws_.start(commands, q, h);
  laws_.standAt(v);
  if (!rings_.empty()) {
    rings_.residual(work, q, lambda_.data());
    for (double& l : lambda_) l /= -h;
  }
  const auto outcome = [&](std::size_t k) -> JointLaws::Outcome {
    const JointLaws::Law& law = laws_.laws()[k];
    const double v1 = v[law.v] + h * v_dot_[law.v];
    return {v[law.v], v1, forceOf(law, gravity, work, v1)};
  };
  const auto solve = [&](int) {
    solveOnce(gravity, h, v, work, v_dot_.data());
    return true;
  };
  report_.converged = laws_.search(solve, outcome) == JointLaws::Found::kAll;
  const int nv = articulation_.nv();
  for (int k = 0; k < nv; ++k) v_end_[k] = v[k] + h * v_dot_[k];
  laws_.account(commands, h, outcome, v, v_end_.data(), drive_force_.data(), report_);
  for (int k = 0; k < nv; ++k) v_dot[k] = v_dot_[k];
  return report_;
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
  laws_.settle(v);
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
