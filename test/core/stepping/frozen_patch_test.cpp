// Oracles: the exact force of the contact volume at the reference, finite differences, and monotony, which is what makes
// the frozen law the gradient of a convex function.
#include "haptic_core/stepping/frozen_patch.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_integrals.h"

namespace haptic {
namespace frozen_patch_test {

constexpr double kStep = 1e-3;

/// A box on another one in a random pose, frozen at a random relative motion.
struct Sample {
  ContactVolume volume;
  LocatedForce exact;
  PairLaw law;
  Vector6 V;
  FrozenPatch patch;
  double size = 0;  ///< of the force [N]
};

class FrozenPatchTest : public testing::TestWithParam<PressureLaw> {
 protected:
  /// False: the poses do not overlap. `speed`: of the relative motion [m/s]; fast ones clip the pressure.
  bool draw(double speed, Sample& s, double mu = 0.4) {
    std::uniform_real_distribution<double> u(-1, 1);
    const auto vector = [&] { return Vector3(u(random_), u(random_), u(random_)); };
    const Quaternion turn = rotationFromVector(0.3 * vector());
    const Pose X_AB(turn, Vector3(0.03 * u(random_), 0.03 * u(random_), 0.098 + 0.006 * u(random_)));
    PairCache cache;
    workspace_.reserve(box_, box_);
    contactVolume(box_, box_, X_AB, cache, workspace_, s.volume);
    if (s.volume.status != ContactVolume::Status::kOverlap) return false;
    s.law.pressure = GetParam();
    s.law.reduced_mass = 0.1;
    ContactMaterial& m = s.law.material;
    m.stiffness = 1e8;
    m.dissipation = 5;
    m.damping = 2e3;
    m.tangential_stiffness = 5e7;
    m.mu_static = m.mu_dynamic = mu;
    s.V << 10 * speed * vector(), speed * vector();
    const double squares = thicknessSquared(workspace_, s.volume);
    Advance advance;
    advance.time = kStep;
    advance.yielding = Yielding::kKeepsLimit;
    const Twist V{s.V.head<3>(), s.V.tail<3>()};
    s.exact = locatedForce(s.volume, X_AB, workspace_, V, FrictionMemory{}, s.law, advance);
    s.patch.freeze(s.volume, squares, s.exact, s.law, s.V, kStep);
    s.size = s.law.material.stiffness * s.volume.volume + s.exact.normal_force;
    return true;
  }

  Vector6 forceAt(const Sample& s, const Vector6& V) const {
    FrozenPatch::Force force;
    s.patch.evaluate(V, force);
    return force.F;
  }

  std::mt19937 random_{7};
  ConvexPolyhedron box_ = makeBox(Vector3::Constant(0.1));
  ContactWorkspace workspace_;
};

INSTANTIATE_TEST_SUITE_P(Laws, FrozenPatchTest, testing::Values(PressureLaw::kHuntCrossley, PressureLaw::kLinear));

TEST_P(FrozenPatchTest, HasTheExactForceAtItsReference) {
  for (double speed : {0.0, 1e-3, 0.3}) {
    int overlaps = 0;
    for (int i = 0; i < 300; ++i) {
      Sample s;
      if (!draw(speed, s)) continue;
      ++overlaps;
      const Vector6 difference = forceAt(s, s.V) - s.exact.F_BP_P.vector();
      EXPECT_LE(difference.tail<3>().norm(), 1e-12 * s.size);
      EXPECT_LE(difference.head<3>().norm(), 1e-12 * s.size * 0.1);
    }
    EXPECT_GT(overlaps, 50);
  }
}

/// While friction's limit stays the tangent is symmetric and positive; what the limit adds has rank one.
TEST_P(FrozenPatchTest, ItsTangentAndLoadAreItsDerivative) {
  const double step = 1e-7;  // of a twist: the error of central differences is some 1e-9 of the tangent
  int sliding = 0;
  for (int i = 0; i < 2000; ++i) {
    Sample s;
    if (!draw(1e-3, s, i % 2 ? 1e3 : 1e-3)) continue;  // sticks, or slides: no kink nearby
    FrozenPatch::Force force;
    s.patch.evaluate(s.V, force);
    sliding += force.friction.outside;
    const Matrix6 G = s.patch.tangent(s.V, force);
    const Vector6 b = s.patch.perLoad(s.V, force);
    EXPECT_EQ(b.isZero(0), !force.friction.outside);
    Matrix6 numeric;
    for (int c = 0; c < 6; ++c) {
      const Vector6 d = step * Vector6::Unit(c);
      numeric.col(c) = -kStep * (forceAt(s, s.V + d) - forceAt(s, s.V - d)) / (2 * step);
    }
    EXPECT_LE((numeric - G - b * G.row(5)).norm(), 1e-6 * G.norm());
    EXPECT_LE((G - G.transpose()).norm(), 1e-14 * G.norm());
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Matrix6>(G).eigenvalues()[0], -1e-14 * G.norm());
  }
  EXPECT_GT(sliding, 20);
}

/// Without friction the gradient of a convex function g ΣF: (F(U) - F(V))·(U - V) ≤ 0, across touch and parting alike. Friction under
/// a limit that stays: FrictionTest.LayerFallsWithTheSlip.
TEST_P(FrozenPatchTest, ItsForceFallsWithTheTwist) {
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 500; ++i) {
    Sample s;
    if (!draw(0.1, s, 0)) continue;
    if (i % 2) s.patch.part(s.V);
    const auto other = [&](double speed) -> Vector6 {
      Vector6 V;
      for (int k = 0; k < 6; ++k) V[k] = s.V[k] + (k < 3 ? 10 : 1) * speed * u(random_);
      return V;
    };
    for (double speed : {1e-3, 1.0, 30.0}) {
      const Vector6 U = other(speed), W = other(speed);
      const Vector6 F = forceAt(s, U), H = forceAt(s, W);
      EXPECT_LE((F - H).dot(U - W), 1e-12 * (F.norm() + H.norm()) * (U - W).norm());
    }
  }
}

/// What lies apart does not press at the reference, and presses once its gap has closed.
TEST_P(FrozenPatchTest, WhatIsNearBarsTheWay) {
  const double gap = 1e-4, closer = 1.5e-4;
  workspace_.reserve(box_, box_);
  PairCache cache;
  ContactVolume near;
  contactVolume(box_, box_, Pose(Vector3(0, 0, 0.1 + gap - closer)), cache, workspace_, near);
  ASSERT_EQ(near.status, ContactVolume::Status::kOverlap);
  PairLaw law;
  law.pressure = GetParam();
  law.material.stiffness = 1e8;
  law.material.dissipation = law.material.damping = 0;
  FrozenPatch patch;
  patch.freezeNear(near, closer, law, Vector6::Zero(), kStep);
  FrozenPatch::Force force;
  patch.evaluate(Vector6::Zero(), force);
  EXPECT_EQ(force.normal, 0);
  const double deep = 2e-5;
  patch.evaluate(-(gap + deep) / kStep * Vector6::Unit(5), force);
  EXPECT_NEAR(force.normal, law.material.stiffness * 0.01 * deep, 1e-9 * law.material.stiffness * 0.01 * closer);
}

/// What another patch stands in for has no force, whatever of its exact one the samples had left over.
TEST_P(FrozenPatchTest, WhatIsForgottenPressesNothing) {
  for (int i = 0; i < 100; ++i) {
    Sample s;
    if (!draw(0.3, s)) continue;
    s.patch.forget();
    EXPECT_TRUE(forceAt(s, s.V).isZero(0)) << i;
  }
}

/// A box that rocks from one edge of its face to the other: frozen at the first, faces have the exact force over the second.
TEST_P(FrozenPatchTest, FacesFollowATurnFromEdgeToEdge) {
  const double tilt = 1e-6, depth = 2e-8;
  const ConvexPolyhedron floor = makeBox(Vector3(0.4, 0.4, 0.1));
  workspace_.reserve(floor, box_);
  PairLaw law;
  law.pressure = GetParam();
  law.reduced_mass = 0.1;
  law.material.stiffness = 1e12;
  law.material.dissipation = law.material.damping = law.material.mu_static = law.material.mu_dynamic = 0;
  Advance advance;
  advance.time = kStep;
  const auto evaluate = [&](double angle, ContactVolume& volume) {
    const Pose X_AB(rotationFromVector(Vector3(0, angle, 0)), Vector3(0, 0, 0.1 + 0.05 * std::abs(angle) - depth));
    PairCache cache;
    contactVolume(floor, box_, X_AB, cache, workspace_, volume);
    return X_AB;
  };
  ContactVolume first, second;
  const Pose X_AB = evaluate(tilt, first);
  ASSERT_EQ(first.status, ContactVolume::Status::kOverlap);
  const Vector6 rest = Vector6::Zero();
  const double squares = thicknessSquared(workspace_, first);
  const LocatedForce force = locatedForce(first, X_AB, workspace_, Twist{}, FrictionMemory{}, law, advance);
  FrozenPatch patch;
  patch.freeze(first, squares, force, law, rest, kStep);
  FaceOverlay faces;
  ASSERT_TRUE(faces.find(floor, box_, X_AB, first.X_AP));
  EXPECT_NEAR(faces.area(), 0.01, 1e-13);
  ASSERT_TRUE(patch.spread(faces, rest));
  const Pose X_second = evaluate(-tilt, second);
  const LocatedForce exact = locatedForce(second, X_second, workspace_, Twist{}, FrictionMemory{}, law, advance);
  // The motion between: half a turn of 2 tilt about the box's centre, at P of the first.
  Vector6 V = Vector6::Zero();
  V[1] = -2 * tilt / kStep;
  const Vector3 arm = first.X_AP.p - X_AB.p;
  Vector6 in_P = Vector6::Zero();
  in_P.head<3>() = first.X_AP.R.transpose() * V.head<3>();
  in_P.tail<3>() = first.X_AP.R.transpose() * Vector3(V.head<3>()).cross(arm);
  FrozenPatch::Force frozen;
  patch.evaluate(in_P, frozen);
  // The patch is (depth/tilt) wide; turns of second order are 1e-12 of the size, 1e-10/2e-8 of the depth.
  EXPECT_NEAR(frozen.normal, exact.normal_force, 1e-2 * exact.normal_force);
  const Vector3 centre = first.X_AP * Vector3(frozen.first[1] / frozen.normal, frozen.first[2] / frozen.normal, 0);
  EXPECT_NEAR(centre.x(), second.X_AP.p.x(), 1e-4);
  EXPECT_LT(first.X_AP.p.x() * second.X_AP.p.x(), 0) << "the patch did not change sides";
}

}  // namespace frozen_patch_test
}  // namespace haptic
