// The bounds against independent accounts: the spectral radius of the exact sampled system with one period of delay; of couplings a search
// over worlds and frequencies, and sampled systems of random worlds in time.
#include "haptic_core/spidar/wall_bound.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <cmath>
#include <complex>
#include <random>

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

TEST(WallBound, ACountMovesNoForceByMoreThanIsFelt) {
  EXPECT_EQ(stiffestWall(4571, 1.67e-5), 4571);  // at 1 kHz the delay is what counts
  EXPECT_DOUBLE_EQ(stiffestWall(14545, 2e-5) * 2e-5, kCountForce);
}

// At 10 kHz counts lower the spring of a coupling, and leave the damper that keeps its tool from swinging.
TEST(WallBound, CountsLowerTheSpringOfACouplingAndKeepItsDamper) {
  const double T = 1e-4, B = 8;
  LoopPort port{B, 1.5 * T, T, 0, 1 / (2 * M_PI * 200)};
  const CouplingBound whole = stiffestCoupling(port);
  port.count = 1.67e-5;
  const CouplingBound bound = stiffestCoupling(port);
  EXPECT_GT(whole.stiffness * port.count, 2 * kCountForce);
  EXPECT_DOUBLE_EQ(bound.stiffness * port.count, kSpringShare * kCountForce);
  EXPECT_EQ(bound.damping, whole.damping);
  port.count = 1e-4;  // coarse: one of them is a speed of 1 m/s for a tick
  EXPECT_NEAR(stiffestCoupling(port).damping * (1 - std::exp(-T / port.filter)) * port.count / T, kCountForce, 1e-12);
}

using Complex = std::complex<double>;

/// Least Re(Z e^{-jωL}) over B [1], Z what the hand meets of a coupling in front of a world of admittance Y, over all ω below half the
/// rate and all Y that only store: a passive Y that loses as well gives less. `times`: on K.
double leastOverDamping(const LoopPort& port, double times) {
  const CouplingBound bound = stiffestCoupling(port);
  const double K = times * bound.stiffness, b = bound.damping, lag = port.lag + 0.5 * port.period;
  double least = 0;
  for (double omega = 5; omega < M_PI / port.period; omega *= 1.01) {
    const Complex s(0, omega), on_hand = K / s + b / (1.0 + s * port.filter), on_tool = K / s + b;
    for (int i = -180; i < 180; ++i) {
      const Complex Y(0, std::tan((i + 0.5) / 180 * M_PI / 2) / std::abs(on_tool));
      least = std::min(least, std::real(on_hand / (1.0 + on_tool * Y) * std::exp(-s * lag)));
    }
  }
  return least / port.damping;
}

TEST(WallBound, ACouplingTakesNoMoreThanTheDampingWhateverIsBehindIt) {
  for (const double T : {1e-3, 5e-4, 2e-4, 1e-4}) {
    for (const double wire : {0.0, 2.5e-4, 2e-3}) {
      const LoopPort port{8, 1.5 * T + wire, T, 0, 1 / (2 * M_PI * 200)};
      EXPECT_GE(leastOverDamping(port, 1), -1) << T << " " << wire;
      EXPECT_LT(leastOverDamping(port, 1.25), -1) << T << " " << wire;  // and not much stiffer
    }
  }
}

/// Two masses on springs and dampers behind a coupling, implicit Euler steps as the world's: work of the held force on a driven grip less
/// that of its damper B, largest over time, over all that the damper took [1]. Starts at rest, so passive means ≤ 0.
double mostGiven(unsigned seed, double T, double times) {
  std::mt19937 random(seed);
  const auto among = [&](double low, double high) { return low * std::pow(high / low, random() / 4294967296.0); };
  const double B = 8, sigma = 1 / (2 * M_PI * 200);
  const CouplingBound bound = stiffestCoupling({B, 1.5 * T, T, 0, sigma});
  const double K = times * bound.stiffness, b = bound.damping, m0 = among(5e-3, 1), m1 = among(5e-3, 10), k = among(1e2, 1e7),
               d = random() % 2 ? 0 : among(0.1, 100), k1 = among(1e2, 1e7), wall = random() % 2 ? 0 : among(1e3, 1e7),
               grip = among(0.03, 0.5), omega = 2 * M_PI * among(1, 200), gain = 1 - std::exp(-T / sigma);
  double x = 0, v = 0, z0 = 0, z1 = 0, u0 = 0, u1 = 0, slow = 0, x_last = 0, held = 0, next = 0, energy = 0, taken = 0, most = 0;
  for (int i = 0; i * T < 0.3; ++i) {
    const double sample = x;
    slow += gain * ((sample - x_last) / T - slow);
    x_last = sample;
    held = next;
    constexpr int kParts = 20;
    for (int j = 0; j < kParts; ++j) {
      const double dt = T / kParts, t = (i + double(j) / kParts) * T;
      v += dt / grip * (held + std::sin(omega * t) - B * v);
      x += dt * v;
      energy += (held - B * v) * v * dt;
      taken += B * v * v * dt;
    }
    most = std::max(most, energy);
    Eigen::Matrix2d A;
    A << m0 / T + (K + k + wall) * T + b + d, -k * T - d, -k * T - d, m1 / T + (k + k1) * T + d;
    const Eigen::Vector2d r(m0 / T * u0 + K * (sample - z0) + b * slow - k * (z0 - z1) - wall * z0, m1 / T * u1 + k * (z0 - z1) - k1 * z1);
    const Eigen::Vector2d u = A.ldlt().solve(r);
    u0 = u[0], u1 = u[1];
    z0 += T * u0, z1 += T * u1;
    next = -(K * (sample - z0) + b * (slow - u0));
  }
  return most / taken;
}

TEST(WallBound, ASampledCouplingGivesADampedHandNothing) {
  for (const double T : {1e-3, 2e-4}) {
    double given = 0, given_stiffer = 0;
    for (unsigned seed = 0; seed < 60; ++seed) {
      given = std::max(given, mostGiven(seed, T, 1));
      given_stiffer = std::max(given_stiffer, mostGiven(seed, T, 3));
    }
    EXPECT_LE(given, 1e-3) << T;  // the grip's own steps: dt B/m of the damper's work, at both ends of a part
    EXPECT_GT(given_stiffer, 1e-2) << T;
  }
}

}  // namespace wall_bound_test
}  // namespace haptic
