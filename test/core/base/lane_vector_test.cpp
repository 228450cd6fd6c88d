// Vectors in lanes against Eigen's.
#include "haptic_core/base/lane_vector.h"

#include <gtest/gtest.h>

#include <random>

namespace haptic {
namespace lane_vector_test {

constexpr double kEps = 2.2e-16;

Vector3 vectorOf(const Lanes& v) { return {v[0], v[1], v[2]}; }

TEST(LaneVector, AgreesWithEigen) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vector3(normal(random), normal(random), normal(random)); };
  for (int i = 0; i < 1000; ++i) {
    const Vector3 a = vector(), b = vector();
    const Lanes la = laneVector(a.x(), a.y(), a.z()), lb = laneVector(b.x(), b.y(), b.z());
    const double size = a.norm() * b.norm();
    EXPECT_LE((vectorOf(cross(la, lb)) - a.cross(b)).norm(), 4 * kEps * size);
    EXPECT_NEAR(dot(la, lb), a.dot(b), 4 * kEps * size);
    Matrix3 M;
    M << vector(), vector(), vector();
    EXPECT_LE((vectorOf(LaneMatrix(M) * la) - M * a).norm(), 4 * kEps * M.norm() * a.norm());
    EXPECT_EQ(vectorOf(pick(la, lb, la)), Vector3(a.x(), b.y(), a.z()));
  }
}

TEST(LaneVector, TurnsAsEigensQuaternionsDo) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  const auto quaternion = [&] {
    return Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized();
  };
  const auto inLanes = [](const Quaternion& q) { return LaneQuaternion{q.w(), laneVector(q.x(), q.y(), q.z())}; };
  for (int i = 0; i < 1000; ++i) {
    const Quaternion p = quaternion(), q = quaternion(), product = p * q;
    const LaneQuaternion r = inLanes(p) * inLanes(q);
    EXPECT_NEAR(r.w, product.w(), 4 * kEps);
    EXPECT_LE((vectorOf(r.u) - product.vec()).norm(), 8 * kEps);
    const LaneRotation R = rotation(inLanes(q));
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE((vectorOf(R.there.column[k]) - q.toRotationMatrix().col(k)).norm(), 8 * kEps);
      EXPECT_LE((vectorOf(R.back.column[k]) - q.toRotationMatrix().row(k).transpose()).norm(), 8 * kEps);
    }
  }
}

}  // namespace lane_vector_test
}  // namespace haptic
