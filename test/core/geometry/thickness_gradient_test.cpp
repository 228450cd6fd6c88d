#include "haptic_core/geometry/volume/thickness_gradient.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_integrals.h"

namespace haptic {
namespace thickness_gradient_test {

struct Pair {
  const ConvexPolyhedron &A, &B;
  NormalRule rule = NormalRule::kAreaVector;

  double energy(const Pose& X_AB, const PairCache& from) const {
    ContactWorkspace workspace;
    workspace.reserve(A, B);
    PairCache cache = from;
    ContactVolume contact;
    contactVolume(A, B, X_AB, cache, workspace, contact, {rule, {}, Vector3::Zero()});
    return contact.status == ContactVolume::Status::kOverlap ? 0.5 * thicknessSquared(workspace, contact) : 0.0;
  }
};

/// Largest difference between the gradient and central differences of ½ ∫ d² dA, over the force; torques over `size`.
double errorOf(const Pair& pair, const Pose& X_AB, double size, double step, const PairCache& from = {}) {
  ContactWorkspace workspace;
  workspace.reserve(pair.A, pair.B);
  PairCache cache = from;
  ContactVolume contact;
  contactVolume(pair.A, pair.B, X_AB, cache, workspace, contact, {pair.rule, {}, Vector3::Zero()});
  if (contact.status != ContactVolume::Status::kOverlap) return 0;
  const Wrench F_P = thicknessGradient(workspace, contact);
  const Wrench F = F_P.rotated(contact.X_AP.R);  // about P, in A's axes
  double worst = 0;
  for (int axis = 0; axis < 6; ++axis) {
    const Vector3 unit = Vector3::Unit(axis % 3);
    const auto moved = [&](double by) {
      if (axis >= 3) return Pose(X_AB.R, X_AB.p + by * unit);
      const Matrix3 R = Eigen::AngleAxisd(by / size, unit).toRotationMatrix();
      return Pose(R * X_AB.R, contact.X_AP.p + R * (X_AB.p - contact.X_AP.p));
    };
    const double expected = -(pair.energy(moved(step), from) - pair.energy(moved(-step), from)) / (2 * step);
    const double found = axis < 3 ? F.torque[axis] / size : F.force[axis - 3];
    worst = std::max(worst, std::abs(found - expected));
  }
  return worst / contact.volume;
}

Pose randomPose(std::mt19937& random, double distance) {
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vector3(normal(random), normal(random), normal(random)); };
  const Quaternion q = Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized();
  return {q.toRotationMatrix(), distance * vector().normalized()};
}

constexpr double kStep = 1e-6;  // [m]
// thicknessSquared leaves out shares of 1e-10, at d up to 5 cm: a few may come or go within the step.
constexpr double kSlivers = 4 * 1e-10 * 0.05 / kStep;
constexpr double kCurved = 1e-7;  // (step/size)²; size: of the smallest face that counts, 3 mm

TEST(ThicknessGradient, IsThatOfTheEnergy) {
  std::mt19937 random(3);
  const ConvexPolyhedron a = makeBox(Vector3(0.1, 0.12, 0.14)), b = makeBox(Vector3(0.06, 0.1, 0.08)), c = makeSphere(0.05, 2);
  int contacts = 0;
  for (int i = 0; i < 400; ++i) {
    const ConvexPolyhedron &A = i % 3 == 2 ? c : a, &B = i % 3 == 0 ? b : c;
    const Pose X = randomPose(random, 0.04 + 0.07 * (i % 17) / 17);
    const double error = errorOf({A, B}, X, 0.05, kStep);
    contacts += error > 0;
    EXPECT_LT(error, kSlivers + kCurved) << i;
  }
  EXPECT_GT(contacts, 200);
}

/// Of a cube on a floor, edges and corners down, and exactly aligned, where faces stand along n.
TEST(ThicknessGradient, OfFlatPatchesIsVolumeAlongNormal) {
  const ConvexPolyhedron floor = makeBox(Vector3(1, 1, 0.2)), cube = makeBox(Vector3::Constant(0.1));
  const double depth = 1e-3;
  for (bool swapped : {false, true}) {
    const Pose X_AB = swapped ? Pose(Vector3(0.02, 0.01, 0.15 - depth)).inverse() : Pose(Vector3(0.02, 0.01, 0.15 - depth));
    const ConvexPolyhedron &A = swapped ? cube : floor, &B = swapped ? floor : cube;
    ContactWorkspace workspace;
    workspace.reserve(A, B);
    ContactVolume contact;
    PairCache cache;
    contactVolume(A, B, X_AB, cache, workspace, contact);
    const Wrench F = thicknessGradient(workspace, contact);
    // Walls along n press on one another alike. Rounding of sums of the volume's size.
    EXPECT_NEAR((F.force - Vector3(0, 0, contact.volume)).norm(), 0, 1e-13 * contact.volume);
    EXPECT_NEAR(F.torque.norm(), 0, 1e-13 * contact.volume * 0.1);
  }
}

/// Two cubes of a stack, walls over walls but for a yaw: their edge moves by 1/yaw times what the cube moves.
TEST(ThicknessGradient, OfAlignedWallsStaysFinite) {
  const double size = 0.03, depth = 3e-5;
  const ConvexPolyhedron cube = makeBox(Vector3::Constant(size));
  ContactWorkspace workspace;
  workspace.reserve(cube, cube);
  for (double yaw = 1e-14; yaw < 1e-2; yaw *= 3) {
    for (const double across : {0.0, 1e-12, 1e-9, 1e-6}) {
      const Matrix3 R = (Eigen::AngleAxisd(0.2 * depth / size, Vector3::UnitY()) *
                         Eigen::AngleAxisd(yaw, Vector3(1, 0.5, 1).normalized())).toRotationMatrix();
      ContactVolume contact;
      PairCache cache;
      contactVolume(cube, cube, Pose(R, Vector3(across, 0.5 * across, size - depth)), cache, workspace, contact);
      ASSERT_EQ(contact.status, ContactVolume::Status::kOverlap);
      // Far below what presses: |m| l/(A d) is the tilt of the load, 0.2, times depth/size.
      const Wrench F = thicknessGradient(workspace, contact);
      EXPECT_LT(F.force.head<2>().norm(), 8 * 0.2 * depth / size / 1e-2 * contact.volume) << yaw << " " << across;
    }
  }
}

TEST(ThicknessGradient, HasItsPotentialWithTheNormalOfThePast) {
  std::mt19937 random(5);
  const ConvexPolyhedron a = makeBox(Vector3(0.1, 0.12, 0.14)), b = makeBox(Vector3(0.06, 0.1, 0.08));
  for (int i = 0; i < 100; ++i) {
    PairCache past;
    const Pose X = randomPose(random, 0.06);
    past.normal = (X.p.normalized() + 0.2 * Vector3(1, -1, 0.5)).normalized();
    EXPECT_LT(errorOf({a, b, NormalRule::kHistory}, X, 0.05, kStep, past), kSlivers + kCurved) << i;
  }
}

/// Corner over corner, around a closed way: k V n nets work there, the gradient none.
TEST(ThicknessGradient, DoesNoWorkAroundAClosedWay) {
  const ConvexPolyhedron a = makeBox(Vector3::Constant(0.1));
  const Matrix3 R = Eigen::AngleAxisd(0.9, Vector3(1, 0.6, 0.2).normalized()).toRotationMatrix();
  ContactWorkspace workspace;
  workspace.reserve(a, a);
  PairCache cache;
  double work = 0, plain = 0, forth = 0;
  const int steps = 20000;
  const auto place = [&](double t) { return Vector3(0.05 + 0.01 * std::cos(t), 0.052 + 0.012 * std::sin(t), 0.08 + 0.008 * std::sin(t)); };
  for (int i = 0; i < steps; ++i) {
    const double t = 2 * M_PI * (i + 0.5) / steps, half = M_PI / steps;
    ContactVolume contact;
    contactVolume(a, a, Pose(R, place(t)), cache, workspace, contact);
    ASSERT_EQ(contact.status, ContactVolume::Status::kOverlap);
    const Vector3 way = place(t + half) - place(t - half);
    const double done = (contact.X_AP.R * thicknessGradient(workspace, contact).force).dot(way);
    work += done;
    forth += std::abs(done);
    plain += contact.volume * contact.normal().dot(way);
  }
  // The midpoint rule over a periodic way with kinks: (2π/steps)².
  EXPECT_LT(std::abs(work), 1e-7 * forth);
  EXPECT_GT(std::abs(plain), 1e-3 * forth);
}

}  // namespace thickness_gradient_test
}  // namespace haptic
