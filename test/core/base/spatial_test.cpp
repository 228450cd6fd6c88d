// Rotations of the project's own against Eigen's.
#include "haptic_core/base/spatial.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace haptic {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();

TEST(Spatial, RotationsAreThoseOfTheirAngles) {
  double most = 0;
  for (int i = -20; i <= 20; ++i) {
    for (int j = -10; j <= 10; ++j) {
      const double a = 0.33 * i, b = 0.29 * j, c = 0.17 * (i + j);
      const Vector3 axis = Vector3(1 + 0.1 * i, 0.2 * j, -0.5).normalized();
      most = std::max(most, (rotationAbout(axis, a) - Eigen::AngleAxisd(a, axis).toRotationMatrix()).cwiseAbs().maxCoeff());
      const Matrix3 turned = (Eigen::AngleAxisd(c, Vector3::UnitZ()) * Eigen::AngleAxisd(b, Vector3::UnitY()) *
                              Eigen::AngleAxisd(a, Vector3::UnitX()))
                                 .toRotationMatrix();
      most = std::max(most, (rotationFromRpy(Vector3(a, b, c)) - turned).cwiseAbs().maxCoeff());
    }
  }
  EXPECT_LT(most, 8 * kEps);  // three roundings of ours, five of Eigen's by way of quaternions
  EXPECT_GT(most, 0);
}

/// On its way, shortest, and of unit length; also for vectors that are nearly the same and nearly opposite.
TEST(Spatial, TheShortestTurnIsOntoTheVectorAndAboutAnAxisAcrossBoth) {
  const Vector3 a = Vector3(0.3, -0.8, 0.5).normalized(), across = a.cross(Vector3(0.2, 0.5, 0.9)).normalized();
  for (double angle : {0.0, 1e-12, 1e-7, 0.4, 1.5707963267948966, 3.0, 3.14159264, 3.14159265358, 3.141592653589793}) {
    const Vector3 b = (rotationAbout(across, angle) * a).normalized();
    const Quaternion q = shortestTurn(a, b);
    EXPECT_LT((q * a - b).norm(), 8 * kEps) << angle;
    EXPECT_LT(std::abs(q.norm() - 1), 2 * kEps) << angle;
    EXPECT_LT(std::abs(q.vec().dot(a + b)), 4 * kEps) << angle;
    EXPECT_LT(std::abs(2 * std::atan2(q.vec().norm(), q.w()) - angle), 8 * kEps) << angle;
  }
  EXPECT_LT((shortestTurn(a, -a) * a + a).norm(), 8 * kEps);
  EXPECT_EQ(shortestTurn(a, a).coeffs(), Quaternion::Identity().coeffs());
}

TEST(Spatial, NoTurnIsNoTurn) {
  EXPECT_EQ(rotationFromRpy(Vector3::Zero()), Matrix3::Identity());
  EXPECT_EQ(rotationAbout(Vector3::UnitX(), 0), Matrix3::Identity());
  EXPECT_EQ(vectorFromRotation(Quaternion::Identity()), Vector3::Zero());
}

TEST(Spatial, VectorsAndQuaternionsOfRotationsAreInverse) {
  for (double angle : {1e-9, 1e-4, 0.3, 1.0, 3.0}) {
    const Vector3 theta = angle * Vector3(0.6, -0.48, 0.64);
    EXPECT_LT((vectorFromRotation(rotationFromVector(theta)) - theta).norm(), 8 * kEps * std::max(1.0, angle)) << angle;
    EXPECT_LT((rotationFromVector(theta).toRotationMatrix() - rotationAbout(theta / angle, angle)).norm(), 16 * kEps) << angle;
  }
}

}  // namespace
}  // namespace haptic
