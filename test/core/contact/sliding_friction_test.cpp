#include "haptic_core/contact/sliding_friction.h"

#include <gtest/gtest.h>

#include "../../scenes/motions.h"
#include "haptic_core/contact/pressure_law.h"

namespace haptic {
namespace sliding_friction_test {

using namespace scenes;

/// A cube tilted in a floor, so that the pressure is linear over the square patch.
class TiltedPatch : public ::testing::Test {
 protected:
  TiltedPatch() : floor_(makeBox(Vector3(1, 1, 0.2))), cube_(makeBox(Vector3::Constant(0.1))) {
    workspace_.reserve(floor_, cube_);
    X_AB_ = Pose(rotationY(2e-4), Vector3(0.02, -0.01, 0.15 - 2e-4));
    PairCache cache;
    contactVolume(floor_, cube_, X_AB_, cache, workspace_, contact_);
  }

  /// Sum over n × n cells of the cube's lower face of cell(r, d dA), r in P.
  template <class Cell>
  void overPatch(int n, Cell cell) const {
    for (int ix = 0; ix < n; ++ix) {
      for (int iy = 0; iy < n; ++iy) {
        const Vector3 p_A = X_AB_ * Vector3((ix + 0.5) / n * 0.1 - 0.05, (iy + 0.5) / n * 0.1 - 0.05, -0.05);
        const Vector2 r = (contact_.X_AP.R.transpose() * (p_A - contact_.X_AP.p)).head<2>();
        cell(r, 0.1 - p_A.z(), 0.01 / n / n);
      }
    }
  }

  ConvexPolyhedron floor_, cube_;
  ContactWorkspace workspace_;
  ContactVolume contact_;
  Pose X_AB_;
};

// Cells of 0.5 mm: where the slip turns over within a cell the direction is wrong in one cell of 40 000, and the
// midpoint rule errs by (cell/distance)²/24 elsewhere: together below 1e-3 of the normal force.
TEST_F(TiltedPatch, ClosedFormAgreesWithFineQuadratureForAnyRatioOfSpinToSlip) {
  const PressureField field{1e6, Vector2::Zero(), 0, Vector2::Zero()};
  const PressureMoments moments{1e6 * contact_.volume, Vector2::Zero(), 1e6 * contact_.V2};
  for (int i = 0; i <= 20; ++i) {
    const double w = (i % 2 ? -1 : 1) * std::pow(10, -3 + 0.3 * i);
    const Vector2 v = 0.05 * Vector2(std::cos(0.7 * i), std::sin(0.7 * i));
    const SlidingIntegral closed = slidingIntegral(workspace_, contact_, field, moments, v, w, 0.075);
    Vector2 force = Vector2::Zero();
    double torque = 0;
    overPatch(1000, [&](const Vector2& r, double d, double dA) {
      const Vector2 t = (v + w * Vector2(-r.y(), r.x())).normalized();
      force += 1e6 * d * dA * t;
      torque += 1e6 * d * dA * (r.x() * t.y() - r.y() * t.x());
    });
    EXPECT_NEAR((closed.force - force).norm(), 0, 1e-3 * moments.force) << "spin " << w;
    EXPECT_NEAR(closed.torque, torque, 1e-3 * moments.force * 0.04) << "spin " << w;
  }
}

// Three ways to integrate, by the distance of the instant centre: each must be smooth to rounding, or an implicit solve
// does not converge. Over a step of 1e-6 of the spin the second difference of a smooth integral is (1e-6)² N; the
// closed form carried beyond kNearCentre loses eps |c|³ and fails at thirty radii with 1e-10.
TEST_F(TiltedPatch, SlidingIntegralIsSmoothInTheSpinAtAnyDistanceOfTheCentre) {
  const PressureField field{1e6, Vector2(3e5, -2e5), 10, Vector2(50, 80)};
  const PressureMoments moments{1e6 * contact_.volume, Vector2::Zero(), 1e6 * contact_.V2};
  const double radius = 0.075;
  for (double distance = 0.7; distance < 900; distance *= 1.21) {
    for (const double angle : {0.3, 1.9, 4.0}) {
      const Vector2 v = distance * radius * Vector2(std::cos(angle), std::sin(angle));
      SlidingIntegral s[3];
      for (int i : {0, 1, 2}) s[i] = slidingIntegral(workspace_, contact_, field, moments, v, 1 + 1e-7 * (i - 1), radius);
      EXPECT_NEAR((s[0].force - 2 * s[1].force + s[2].force).norm(), 0, 2e-13 * moments.force) << distance << " radii";
      EXPECT_NEAR(s[0].torque - 2 * s[1].torque + s[2].torque, 0, 2e-13 * moments.force * radius) << distance << " radii";
    }
  }
}

// p = max(0, p) - max(0, -p): the whole field's integral is that of the part that presses less that of the part that pulls, wherever the
// line between them lies and however the integral is taken. The closed form loses eps |c|³, |c| < 6, in sums of a hundred terms.
void expectWholeIsPressesLessPulls(ContactWorkspace& workspace, const ContactVolume& contact, double radius) {
  const PressureMoments moments{1e6 * contact.volume, Vector2::Zero(), 1e6 * contact.V2};
  for (const double across : {-0.03, 0.001, 0.04}) {
    for (double angle = 0.1; angle < 6; angle += 0.9) {
      const Vector2 along(std::cos(angle), std::sin(angle));
      const PressureField field{-1e6 * across, 1e6 * along, 0, Vector2::Zero()},
          opposite{1e6 * across, -1e6 * along, 0, Vector2::Zero()};
      for (const double distance : {0.2, 1.5, 5.9, 6.1, 300.0}) {
        const Vector2 v = distance * radius * Vector2(0.6, -0.8);
        const SlidingIntegral whole = slidingIntegral(workspace, contact, field, moments, v, 1, radius),
                              presses = slidingIntegral(workspace, contact, field, moments, v, 1, radius, true),
                              pulls = slidingIntegral(workspace, contact, opposite, moments, v, 1, radius, true);
        const double most = 0.07 * moments.force;
        EXPECT_NEAR((presses.force - pulls.force - whole.force).norm(), 0, (distance < kNearCentre ? 1e-11 : 1e-7) * most) << distance;
        EXPECT_NEAR(presses.torque - pulls.torque, whole.torque, (distance < kNearCentre ? 1e-11 : 1e-7) * most * radius) << distance;
      }
    }
  }
}

TEST_F(TiltedPatch, WhatPressesLessWhatPullsIsTheWholeField) { expectWholeIsPressesLessPulls(workspace_, contact_, 0.075); }

// A hundred and more faces: lists that a cut fills must not be those that the integral reads.
TEST(SlidingFriction, OfAPatchOfManyFacesAsWell) {
  const ConvexPolyhedron floor = makeBox(Vector3(1, 1, 0.2)), roller = makeCylinder(0.05, 0.1, 160);
  ContactWorkspace workspace;
  workspace.reserve(floor, roller);
  PairCache cache;
  ContactVolume contact;
  contactVolume(floor, roller, Pose(rotationY(2e-4), Vector3(0.02, -0.01, 0.15 - 2e-4)), cache, workspace, contact);
  ASSERT_GT(workspace.faces().size(), 100);
  expectWholeIsPressesLessPulls(workspace, contact, 0.05);
}

// Of a field that is clipped: cells of half a millimetre, as above.
TEST_F(TiltedPatch, TheClippedIntegralAgreesWithFineQuadrature) {
  const PressureMoments moments{1e6 * contact_.volume, Vector2::Zero(), 1e6 * contact_.V2};
  const Vector2 along(2e7, -1e7);
  const PressureField field{2e5, along, 0, Vector2::Zero()};
  for (const double w : {0.3, -4.0, 60.0}) {
    const Vector2 v(0.05, -0.02);
    const SlidingIntegral closed = slidingIntegral(workspace_, contact_, field, moments, v, w, 0.075, true);
    Vector2 force = Vector2::Zero();
    double torque = 0, normal = 0;
    overPatch(1000, [&](const Vector2& r, double d, double dA) {
      const Vector2 t = (v + w * Vector2(-r.y(), r.x())).normalized();
      const double N = std::max(0.0, d * (field.k0 + along.dot(r))) * dA;
      normal += N;
      force += N * t;
      torque += N * (r.x() * t.y() - r.y() * t.x());
    });
    EXPECT_NEAR((closed.force - force).norm(), 0, 1e-3 * normal) << "spin " << w;
    EXPECT_NEAR(closed.torque, torque, 1e-3 * normal * 0.07) << "spin " << w;
  }
}

// Where one way ends and the next begins they agree: the rule's error at kNearCentre, (size/2|c|)⁶, and the series' at
// kFarCentre, its third order, both below 1e-6 of N.
TEST_F(TiltedPatch, SlidingIntegralIsContinuousWhereTheWayOfIntegrationChanges) {
  const PressureField field{1e6, Vector2::Zero(), 0, Vector2::Zero()};
  const PressureMoments moments{1e6 * contact_.volume, Vector2::Zero(), 1e6 * contact_.V2};
  const double radius = 0.075;
  for (const double border : {kNearCentre, kFarCentre}) {
    for (const double angle : {0.0, 0.3, 1.9, 4.0}) {
      const Vector2 v = border * radius * Vector2(std::cos(angle), std::sin(angle));
      const SlidingIntegral near = slidingIntegral(workspace_, contact_, field, moments, v, 1 + 1e-9, radius);
      const SlidingIntegral far = slidingIntegral(workspace_, contact_, field, moments, v, 1 - 1e-9, radius);
      EXPECT_NEAR((near.force - far.force).norm(), 0, 1e-6 * moments.force);
      EXPECT_NEAR(near.torque, far.torque, 1e-6 * moments.force * radius);
    }
  }
}

// The linear damper pulls where the cube leaves fast enough; there the pressure is 0. Midpoint rule on a kinked
// function: cell × slope along the kink, below 1e-3 of the elastic force.
TEST_F(TiltedPatch, PressureNeverPullsAndItsIntegralIsExact) {
  ContactMaterial m;
  m.stiffness = 1e6;
  m.damping = 1e4;
  m.dissipation = 30;
  for (PressureLaw law : {PressureLaw::kLinear, PressureLaw::kHuntCrossley}) {
    for (double leaving : {-0.02, 0.0, 0.01, 0.02, 0.03, 0.2}) {
      const Twist V{Vector3(0.1, 0.3, 0), Vector3(0, 0, leaving)};
      const NormalPressure p = normalPressure(contact_, workspace_, V, law, m);
      double force = 0;
      Vector2 first = Vector2::Zero();
      overPatch(400, [&](const Vector2& r, double d, double dA) {
        const double rate = -(leaving + 0.1 * r.y() - 0.3 * r.x());
        const double pressure = law == PressureLaw::kLinear ? std::max(0.0, 1e6 * d + 1e4 * rate)
                                                            : 1e6 * d * std::max(0.0, 1 + 30 * rate);
        force += pressure * dA;
        first += pressure * dA * r;
      });
      const double scale = 1e6 * contact_.volume;
      EXPECT_GE(p.force, 0);
      EXPECT_NEAR(p.force, force, 1e-3 * scale) << "leaving at " << leaving;
      EXPECT_NEAR((p.first - first).norm(), 0, 1e-3 * scale * 0.05) << "leaving at " << leaving;
    }
  }
}

}  // namespace sliding_friction_test
}  // namespace haptic
