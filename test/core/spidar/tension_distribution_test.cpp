#include "haptic_core/spidar/tension_distribution.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace haptic {
namespace tension_distribution_test {

DeviceDef device(const std::string& name) {
  return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + name + ".yaml");
}

Vector3 randomVector(std::mt19937& generator, double size) {
  std::uniform_real_distribution<double> u(-size, size);
  return {u(generator), u(generator), u(generator)};
}

GripPose randomPose(std::mt19937& generator, int dof) {
  GripPose x;
  x.X_BG.p = randomVector(generator, 0.017);
  if (dof >= 6) x.X_BG.R = rotationFromVector(randomVector(generator, 0.28)).toRotationMatrix();
  return x;
}

/// Oracle by another algorithm: every one of the 3ⁿ active sets is solved densely in the tensions themselves,
/// and the feasible one with the least objective is kept.
double leastObjective(const Eigen::MatrixXd& M, const Eigen::VectorXd& w, double lambda,
                      const Eigen::VectorXd& low, const Eigen::VectorXd& high) {
  const int n = static_cast<int>(M.cols());
  double best = std::numeric_limits<double>::infinity();
  int sets = 1;
  for (int i = 0; i < n; ++i) sets *= 3;
  for (int set = 0; set < sets; ++set) {
    Eigen::VectorXd t(n);
    std::vector<int> free;
    for (int i = 0, code = set; i < n; ++i, code /= 3) {
      if (code % 3 == 2) free.push_back(i);
      t[i] = code % 3 == 2 ? 0 : code % 3 == 1 ? high[i] : low[i];
    }
    const int f = static_cast<int>(free.size());
    Eigen::MatrixXd F(M.rows(), f);
    for (int k = 0; k < f; ++k) F.col(k) = M.col(free[k]);
    const Eigen::MatrixXd H = F.transpose() * F + lambda * Eigen::MatrixXd::Identity(f, f);
    const Eigen::VectorXd solved = H.ldlt().solve(F.transpose() * (w - M * t));
    bool feasible = true;
    for (int k = 0; k < f; ++k) {
      t[free[k]] = solved[k];
      feasible = feasible && solved[k] >= low[free[k]] - 1e-9 && solved[k] <= high[free[k]] + 1e-9;
    }
    if (feasible) best = std::min(best, (M * t - w).squaredNorm() + lambda * t.squaredNorm());
  }
  return best;
}

TEST(TensionDistribution, FindsTheLeastObjectiveOfAllActiveSets) {
  DeviceDef def = device("spidar_g6x3r");
  def.strings[2].min_tension = 0.7;  // bounds that differ: a solver that takes one for all fails here
  def.strings[5].max_tension = 9;
  const StringKinematics kinematics(def);
  TensionDistribution distribution(def, kinematics);
  std::mt19937 generator(7);
  for (int trial = 0; trial < 30; ++trial) {
    const StructureMatrix A = kinematics.scaledStructure(randomPose(generator, 6));
    distribution.setStructure(A);
    const Wrench F{randomVector(generator, 0.4), randomVector(generator, 15)};
    const TensionReport& report = distribution.solve(F);
    ASSERT_EQ(report.status, TensionStatus::kSolved);
    Eigen::VectorXd w(6), low(8), high(8);
    w << F.force, F.torque / kinematics.knotRadius();
    for (int i = 0; i < 8; ++i) {
      low[i] = def.strings[i].min_tension;
      high[i] = def.strings[i].max_tension;
      ASSERT_GE(report.tension[i], low[i]);
      ASSERT_LE(report.tension[i], high[i]);
    }
    const Eigen::MatrixXd M = A.transpose();
    const double objective =
        (M * report.tension - w).squaredNorm() + def.lambda * report.tension.squaredNorm();
    const double least = leastObjective(M, w, def.lambda, low, high);
    EXPECT_NEAR(objective, least, 1e-9 * (1 + least));  // the oracle admits tensions 1e-9 N outside
  }
}

class TensionOfDevice : public ::testing::TestWithParam<const char*> {};

TEST_P(TensionOfDevice, SatisfiesTheOptimalityConditionsInAndOutOfRange) {
  const DeviceDef def = device(GetParam());
  const StringKinematics kinematics(def);
  TensionDistribution distribution(def, kinematics);
  std::mt19937 generator(3);
  for (int trial = 0; trial < 5000; ++trial) {
    distribution.setStructure(kinematics.scaledStructure(randomPose(generator, def.dof)));
    const double size = std::pow(10.0, trial % 5 - 1);  // 0.1 N to 1000 N
    if (trial % 3 == 0) distribution.forgetActiveSet();
    const TensionReport& report = distribution.solve(
        {randomVector(generator, 0.02 * size), randomVector(generator, size)}, trial % 7 - 3.0);
    ASSERT_EQ(report.status, TensionStatus::kSolved);
    ASSERT_LE(report.kkt_residual, 1e-12);
    ASSERT_LE(report.iterations, 30);
  }
}

TEST_P(TensionOfDevice, DoesNotDependOnTheActiveSetItStartsFrom) {
  const DeviceDef def = device(GetParam());
  const StringKinematics kinematics(def);
  TensionDistribution warm(def, kinematics), cold(def, kinematics);
  std::mt19937 generator(5);
  for (int trial = 0; trial < 2000; ++trial) {
    const StructureMatrix A = kinematics.scaledStructure(randomPose(generator, def.dof));
    warm.setStructure(A);
    cold.setStructure(A);
    cold.forgetActiveSet();
    const Wrench F{randomVector(generator, 0.2), randomVector(generator, 10)};
    // The objective's curvature is λ at least: a gradient of 1e-14 · 20 N leaves 2e-13 / λ.
    ASSERT_LT((warm.solve(F).tension - cold.solve(F).tension).norm(), 1e-9);
  }
}

// A copy that starts from the saved active set takes the same steps to the same bits; one that starts cold takes others.
TEST_P(TensionOfDevice, GoesOnFromASavedActiveSetBitForBit) {
  const DeviceDef def = device(GetParam());
  const StringKinematics kinematics(def);
  TensionDistribution first(def, kinematics), again(def, kinematics), cold(def, kinematics);
  std::mt19937 generator(17);
  int other_steps = 0;
  for (int trial = 0; trial < 500; ++trial) {
    std::array<double, 2 * kMaxStrings> active;
    first.saveActiveSet(active.data());
    const StructureMatrix A = kinematics.scaledStructure(randomPose(generator, def.dof));
    for (TensionDistribution* each : {&first, &again, &cold}) each->setStructure(A);
    again.solve({randomVector(generator, 0.2), randomVector(generator, 10)});  // somewhere else before
    again.restoreActiveSet(active.data());
    cold.forgetActiveSet();
    const Wrench F{randomVector(generator, 0.2), randomVector(generator, 10)};
    const TensionReport& report = first.solve(F);
    ASSERT_EQ(again.solve(F).iterations, report.iterations);
    ASSERT_EQ(again.report().tension, report.tension);
    other_steps += cold.solve(F).iterations != report.iterations;
  }
  EXPECT_GT(other_steps, 50);  // the active set makes a difference
}

TEST_P(TensionOfDevice, LambdaFollowsWhatIsMissing) {
  // The optimality conditions of min ⅚|W(Aᵀt - w)|^(6/5) + ½c|t|²: those of the quadratic program at λ, and λ = c|y|^⅘.
  const DeviceDef def = device(GetParam());
  const StringKinematics kinematics(def);
  TensionDistribution distribution(def, kinematics), exact(def, kinematics), constant(def, kinematics);
  exact.setLambda(1e-9);
  constant.setLambda(0.01);  // the constant λ whose tensions step as far (bench_spidar)
  const double least = 1e-5;  // of TensionDistribution: λ where the wrench can be presented
  std::mt19937 generator(11);
  int inside = 0;
  double lost = 0, lost_by_constant = 0;
  for (int i = 0; i < 3000; ++i) {
    const StructureMatrix A = kinematics.scaledStructure(randomPose(generator, def.dof));
    distribution.setStructure(A);
    exact.setStructure(A);
    constant.setStructure(A);
    Wrench F{randomVector(generator, 0.1), randomVector(generator, 8)};
    if (def.dof == 3) F.torque.setZero();
    const TensionReport& report = distribution.present(F);
    ASSERT_EQ(report.status, TensionStatus::kSolved);
    ASSERT_LT(report.kkt_residual, 1e-12);
    const double wanted = std::max(least, def.border_lambda * std::pow(report.error, 0.8));
    ASSERT_NEAR(report.lambda, wanted, 1e-8 * wanted);
    const double missing = exact.solve(F).error;
    ASSERT_GE(report.error, missing * (1 - 1e-9) - 1e-9) << "better than the bounds allow";
    if (missing > 1e-6) continue;
    ++inside;
    lost += report.error * report.error;
    lost_by_constant += std::pow(constant.solve(F).error, 2);
  }
  EXPECT_GT(inside, 200);
  EXPECT_LT(std::sqrt(lost), std::sqrt(lost_by_constant) / 3);
}

INSTANTIATE_TEST_SUITE_P(Devices, TensionOfDevice,
                         ::testing::Values("spidar_g6x3r", "spidar_g6x4", "spidar_g6x5r", "spidar_4",
                                           "spidar_g7"));

TEST(TensionDistribution, IgnoresWhatIsNotFinite) {
  const DeviceDef def = device("spidar_g6x3r");
  const StringKinematics kinematics(def);
  TensionDistribution distribution(def, kinematics);
  Wrench F;
  F.force.x() = std::nan("");
  EXPECT_EQ(distribution.solve(F).status, TensionStatus::kNotFinite);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(distribution.report().tension[i], def.strings[i].min_tension);
  F.force.x() = 1;
  EXPECT_EQ(distribution.solve(F).status, TensionStatus::kSolved);
}

}  // namespace tension_distribution_test
}  // namespace haptic
