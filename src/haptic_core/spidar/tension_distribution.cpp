#include "haptic_core/spidar/tension_distribution.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/spidar/tension_solver.h"

namespace haptic {
namespace {

/// λ where nothing is missing [1]: a share λ/σ² of the wrench is lost, 1e-3 in the weakest directions (σ² = 0.01).
/// Smaller costs digits and iterations, larger torque.
constexpr double kInsideLambda = 1e-5;
/// λ = c|y|^⅘ is met to this share; tensions follow to about the same share of themselves.
constexpr double kLambdaTolerance = 1e-9;
/// Secants need four or five; after twelve the tensions are still a solution, for a λ that is a little off.
constexpr int kLambdaSteps = 12;
/// Of the missing newtons in λ; see the header for what others cost.
constexpr double kBorderPower = 0.8;
/// A flatter secant is rounding; steps longer than twenty times the gap would overshoot.
constexpr double kLeastSlope = 0.05;

template <int kDof>
std::unique_ptr<TensionSolver> makeSolver(int strings) {
  switch (laneCapacity(strings)) {
    case 4:
      return std::make_unique<TensionNewton<kDof, 4>>();
    case 8:
      return std::make_unique<TensionNewton<kDof, 8>>();
    default:
      return std::make_unique<TensionNewton<kDof, 16>>();
  }
}

std::unique_ptr<TensionSolver> makeSolver(int dof, int strings) {
  switch (dof) {
    case 3:
      return makeSolver<3>(strings);
    case 7:
      return makeSolver<7>(strings);
    default:
      return makeSolver<6>(strings);
  }
}

}  // namespace

TensionDistribution::TensionDistribution(const DeviceDef& def, const StringKinematics& kinematics)
    : strings_(kinematics.strings()),
      dof_(kinematics.dof()),
      radius_(kinematics.knotRadius()),
      lambda_(0),
      border_lambda_(def.border_lambda),
      min_(strings_),
      max_(strings_),
      solver_(makeSolver(dof_, strings_)) {
  for (int i = 0; i < strings_; ++i) {
    min_[i] = def.strings[i].min_tension;
    max_[i] = def.strings[i].max_tension;
  }
  solver_->setBounds(min_, max_);
  setLambda(def.lambda);
  report_.tension = min_;
  forgetActiveSet();
  solver_->setLambda(lambda_);
  lambda_used_ = lambda_;
  setStructure(kinematics.scaledStructure(GripPose{}));
}

TensionDistribution::~TensionDistribution() = default;
TensionDistribution::TensionDistribution(TensionDistribution&&) noexcept = default;
TensionDistribution& TensionDistribution::operator=(TensionDistribution&&) noexcept = default;

void TensionDistribution::setLambda(double lambda) noexcept {
  const double least = 1e-9;  // below, 1 + M Mᵀ/λ loses more than half of the digits
  lambda_ = lambda > least ? lambda : least;
}

void TensionDistribution::setRuleLambda(double lambda) noexcept {
  if (border_lambda_ > 0) {
    border_lambda_ = lambda;
  } else {
    setLambda(lambda);
  }
}

void TensionDistribution::setStructure(const StructureMatrix& scaled) noexcept {
  solver_->setStructure(scaled);
}

void TensionDistribution::forgetActiveSet() noexcept {
  solver_->forgetActiveSet();
}

void TensionDistribution::saveActiveSet(double* out) const noexcept { solver_->saveActiveSet(out); }
void TensionDistribution::restoreActiveSet(const double* in) noexcept { solver_->restoreActiveSet(in); }

const TensionReport& TensionDistribution::solve(const Wrench& F_G_B, double grasp_force) noexcept {
  const bool finite = scale(F_G_B, grasp_force);
  solveWith(lambda_);
  return finish(finite);
}

const TensionReport& TensionDistribution::present(const Wrench& F_G_B, double grasp_force) noexcept {
  if (border_lambda_ == 0) return solve(F_G_B, grasp_force);
  const bool finite = scale(F_G_B, grasp_force);
  double lambda = kInsideLambda;
  double ratio = lambdaFor(solveWith(lambda)) / lambda;
  if (ratio <= 1) return finish(finite);
  // ln(c|y|^⅘/λ) falls with ln λ, by less than one per one, as |y| grows: secants for its slope, within those bounds.
  double slope = 1;
  for (int i = 0; i < kLambdaSteps; ++i) {
    const double gap = elementary::log(ratio), step = gap / slope;
    lambda *= elementary::exp(step);
    ratio = lambdaFor(solveWith(lambda)) / lambda;
    const double left = elementary::log(ratio);
    if (std::fabs(left) <= kLambdaTolerance) break;
    slope = std::min(1.0, std::max(kLeastSlope, (gap - left) / step));
  }
  return finish(finite);
}

double TensionDistribution::lambdaFor(double missing) const noexcept {
  return border_lambda_ * elementary::exp(kBorderPower * elementary::log(missing));
}

/// False: not finite, and taken as zero.
bool TensionDistribution::scale(const Wrench& F_G_B, double grasp_force) noexcept {
  const double per_radius = 1 / radius_;
  for (int c = 0; c < 3; ++c) {
    wanted_[c] = F_G_B.force[c];
    wanted_[3 + c] = F_G_B.torque[c] * per_radius;
  }
  wanted_[6] = grasp_force;
  double sum = 0;
  for (int c = 0; c < dof_; ++c) sum += wanted_[c] * wanted_[c];
  if (std::isfinite(sum)) return true;
  wanted_.fill(0);
  forgetActiveSet();
  return false;
}

/// |y|, the missing force [N].
double TensionDistribution::solveWith(double lambda) noexcept {
  if (lambda != lambda_used_) {
    solver_->setLambda(lambda);
    lambda_used_ = lambda;
  }
  solver_->solve(wanted_.data(), achieved_.data(), report_);
  report_.lambda = lambda;
  return report_.error;
}

const TensionReport& TensionDistribution::finish(bool finite) noexcept {
  report_.F_G_B.force = Vector3(achieved_[0], achieved_[1], achieved_[2]);
  report_.F_G_B.torque = radius_ * Vector3(achieved_[3], achieved_[4], achieved_[5]);
  report_.grasp_force = achieved_[6];
  if (!finite) {
    report_.tension = min_;
    report_.status = TensionStatus::kNotFinite;
  }
  return report_;
}

}  // namespace haptic
