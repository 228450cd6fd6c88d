// The bound against an independent account: the spectral radius of the exact sampled system with one period of delay.
#include "haptic_core/spidar/wall_bound.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

namespace haptic {
namespace wall_bound_test {

/// Mass m with damping B on a spring K whose force is held over T and one period old: x'' = -(B/m) x' - (K/m) x_{n-1}.
/// Largest eigenvalue of the map from one sample to the next.
double spectralRadius(double m, double B, double K, double T) {
  const double a = B / m, decay = std::exp(-a * T), reach = (1 - decay) / a, drop = (T - reach) / a;
  Eigen::Matrix3d A;  // x, v, x of the sample before
  A << 1, reach, -K / m * drop, 0, decay, -K / m * reach, 1, 0, 0;
  return A.eigenvalues().cwiseAbs().maxCoeff();
}

TEST(WallBound, IsWhereTheSampledSystemBeginsToGrow) {
  for (const double T : {1e-3, 1e-4}) {
    for (const double B : {0.5, 1.0, 2.0}) {
      const double bound = largestWallStiffness(B, 0, T, loopDelay(T, 0)), m = 0.1;
      // Exact for B T / m → 0: the next terms are of that order.
      EXPECT_LT(spectralRadius(m, B, bound * (1 - 3 * B * T / m), T), 1) << "T " << T << " B " << B;
      EXPECT_GT(spectralRadius(m, B, bound * (1 + 3 * B * T / m), T), 1) << "T " << T << " B " << B;
    }
  }
}

TEST(WallBound, WallDampingAndDelayTakeTheirShare) {
  EXPECT_DOUBLE_EQ(largestWallStiffness(2, 0, 1e-3, 0), 2 * 2 / 1e-3);  // without delay: 2B/T
  EXPECT_LT(largestWallStiffness(2, 0, 1e-3, 1e-3), largestWallStiffness(2, 0, 1e-3, 0));
  EXPECT_EQ(largestWallStiffness(2, -0.5, 1e-3, 0), largestWallStiffness(2, 0.5, 1e-3, 0));
  EXPECT_EQ(largestWallStiffness(0.1, 0.5, 1e-3, 0), 0);
}

}  // namespace wall_bound_test
}  // namespace haptic
