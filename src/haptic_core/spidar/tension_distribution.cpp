#include "haptic_core/spidar/tension_distribution.h"

#include <cmath>

#include "haptic_core/spidar/tension_solver.h"

namespace haptic {
namespace {

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
      corrections_(def.corrections),
      radius_(kinematics.knotRadius()),
      lambda_(0),
      min_(strings_),
      max_(strings_),
      solver_(makeSolver(dof_, strings_)) {
  for (int i = 0; i < strings_; ++i) {
    min_[i] = def.strings[i].min_tension;
    max_[i] = def.strings[i].max_tension;
  }
  setLambda(def.lambda);
  report_.tension = min_;
  forgetActiveSet();
  setStructure(kinematics.scaledStructure(GripPose{}));
}

TensionDistribution::~TensionDistribution() = default;

void TensionDistribution::setLambda(double lambda) noexcept {
  const double least = 1e-9;  // below, 1 + M Mᵀ/λ loses more than half of the digits
  const double value = lambda > least ? lambda : least;
  if (value == lambda_) return;
  lambda_ = value;
  solver_->setBounds(min_, max_, lambda_);
}

void TensionDistribution::setStructure(const StructureMatrix& scaled) noexcept {
  solver_->setStructure(scaled);
}

void TensionDistribution::forgetActiveSet() noexcept {
  solver_->forgetActiveSet();
}

const TensionReport& TensionDistribution::solve(const Wrench& F_G_B, double grasp_force) noexcept {
  return solveCorrected(F_G_B, grasp_force, 0);
}

const TensionReport& TensionDistribution::present(const Wrench& F_G_B, double grasp_force) noexcept {
  return solveCorrected(F_G_B, grasp_force, corrections_);
}

const TensionReport& TensionDistribution::solveCorrected(const Wrench& F_G_B, double grasp_force,
                                                         int corrections) noexcept {
  Scaled wanted, achieved{};
  const double per_radius = 1 / radius_;
  for (int c = 0; c < 3; ++c) {
    wanted[c] = F_G_B.force[c];
    wanted[3 + c] = F_G_B.torque[c] * per_radius;
  }
  wanted[6] = grasp_force;
  double sum = 0;
  for (int c = 0; c < dof_; ++c) sum += wanted[c] * wanted[c];
  const bool finite = std::isfinite(sum);
  if (!finite) {
    wanted.fill(0);
    forgetActiveSet();
  }
  solver_->solve(wanted.data(), achieved.data(), report_);
  if (corrections > 0) {
    Scaled asked = wanted;
    for (int k = 0; k < corrections; ++k) {
      for (int c = 0; c < dof_; ++c) asked[c] += wanted[c] - achieved[c];
      solver_->solve(asked.data(), achieved.data(), report_);
    }
    double error = 0;
    for (int c = 0; c < dof_; ++c) error += (achieved[c] - wanted[c]) * (achieved[c] - wanted[c]);
    report_.error = std::sqrt(error);
  }
  report_.F_G_B.force = Vector3(achieved[0], achieved[1], achieved[2]);
  report_.F_G_B.torque = radius_ * Vector3(achieved[3], achieved[4], achieved[5]);
  report_.grasp_force = achieved[6];
  if (!finite) {
    report_.tension = min_;
    report_.status = TensionStatus::kNotFinite;
  }
  return report_;
}

}  // namespace haptic
