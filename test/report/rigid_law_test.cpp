// Residuals of the rigid law against closed forms and a second algorithm; the force of a contact from a motion that is integrated
// otherwise; the exact solutions of ContactBench's scenes against the law.
#include "rigid_law.h"

#include <gtest/gtest.h>

#include "../scenes/contactbench.h"
#include "../scenes/offsets.h"

namespace haptic::report {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();
const Vector3 kUp = Vector3::UnitZ();

Vector3 randomVector(scenes::Offsets& offsets) {
  const double x = offsets.next(), y = offsets.next();
  return {x, y, offsets.next()};
}

TEST(RigidLaw, aBlockThatSlidesUnderFullFrictionHasNoResidual) {
  const RigidResiduals exact = rigidResiduals(kUp, {-4, 0, 8}, {2, 0, 0}, 0, 0.5);
  EXPECT_EQ(exact.signorini, 0);
  EXPECT_EQ(exact.gap_work, 0);
  EXPECT_EQ(exact.coulomb, 0);
  EXPECT_EQ(exact.dissipation, 0);
  scenes::Offsets offsets;
  for (int i = 0; i < 100; ++i) {  // in any direction, up to roundings of N u
    const Vector3 n = randomVector(offsets).normalized(), u = n.cross(randomVector(offsets));
    const double N = 2 + offsets.next(), mu = 1 + offsets.next();
    const RigidResiduals r = rigidResiduals(n, N * n - mu * N * u.normalized(), u, 0, mu);
    const double scale = (1 + mu) * N * u.norm();
    EXPECT_LE(r.dissipation, 10 * kEps * scale);
    EXPECT_LE(r.signorini, 10 * kEps * scale);
    EXPECT_LE(r.coulomb, 10 * kEps * (1 + mu) * N);
  }
}

TEST(RigidLaw, aBlockThatSticksHasNoResidualInsideOfTheCone) {
  for (const double share : {0.0, 0.5, 1.0}) {
    const RigidResiduals r = rigidResiduals(kUp, {0, 4 * share, 8}, Vector3::Zero(), 0, 0.5);
    EXPECT_EQ(r.signorini + r.gap_work + r.coulomb + r.dissipation, 0);
  }
}

TEST(RigidLaw, frictionOfAWrongDirectionLacksPower) {
  // Turned by φ from -u: μ N |u| (1 - cos φ).
  constexpr double kMu = 0.5, N = 8, u = 2;
  for (const double angle : {0.1, 1.0, M_PI / 2, M_PI}) {
    const Vector3 T(-kMu * N * std::cos(angle), kMu * N * std::sin(angle), 0);
    EXPECT_NEAR(rigidResiduals(kUp, T + N * kUp, {u, 0, 0}, 0, kMu).dissipation, kMu * N * u * (1 - std::cos(angle)), 10 * kEps * N * u);
  }
  // A pyramid of four edges at 45 degrees to its slip reaches |T| = √2 μ N: outside of the cone by (√2 - 1) μ N/√(1 + μ²).
  const double over = (std::sqrt(2) - 1) * kMu * N / std::hypot(1, kMu);
  EXPECT_NEAR(rigidResiduals(kUp, {-kMu * N, -kMu * N, N}, {1, 1, 0}, 0, kMu).coulomb, over, 10 * kEps * N);
}

TEST(RigidLaw, aForceAtAGapOrWhileBodiesPartIsNoContact) {
  EXPECT_EQ(rigidResiduals(kUp, {0, 0, 8}, Vector3::Zero(), 0.25, 0.5).gap_work, 2);
  EXPECT_EQ(rigidResiduals(kUp, {0, 0, 8}, Vector3::Zero(), -0.25, 0.5).gap_work, 2);
  EXPECT_EQ(rigidResiduals(kUp, {0, 0, 8}, {0, 0, 0.5}, 0, 0.5).signorini, 4);
  EXPECT_EQ(rigidResiduals(kUp, Vector3::Zero(), {1, 2, 3}, 0.25, 0.5).signorini, 0);  // in flight
  EXPECT_EQ(rigidResiduals(kUp, {0, 0, -8}, Vector3::Zero(), 0, 0.5).coulomb, 8);       // glue
}

TEST(RigidLaw, distanceFromTheConeIsThatOfTheNearestOfItsPoints) {
  // Second algorithm: the least distance over the cone's axis and edge, by samples of spacing h: at most h too far.
  constexpr double kSpacing = 1e-3;
  scenes::Offsets offsets;
  for (int i = 0; i < 200; ++i) {
    const double N = 2 * offsets.next(), T = 1 + offsets.next(), mu = 1 + offsets.next();
    double nearest = std::hypot(N, T);
    for (double x = 0; x < 4; x += kSpacing) {
      const double within = std::min(T, mu * x);  // the nearest point at this height
      nearest = std::min(nearest, std::hypot(N - x, T - within));
    }
    const double distance = distanceFromCone(N, T, mu);
    EXPECT_LE(distance, nearest + 10 * kEps);
    EXPECT_GE(distance, nearest - kSpacing * std::hypot(1, mu));
  }
}

TEST(RigidLaw, motionTellsForceAndPlaceOfAContact) {
  // A ball with its centre of mass aside of its frame, from a force at a point: v' = F/m + g, I ω' = (p - c) × F, by the trapezoid.
  scenes::Offsets offsets;
  LinkInertia m;
  m.mass = 0.7;
  m.I_C = 0.02 * Matrix3::Identity();
  const Vector3 gravity(0, 0, -9.81);
  for (int i = 0; i < 100; ++i) {
    const double h = 1e-3;
    m.p_LC = 0.1 * randomVector(offsets);
    const Vector3 F(offsets.next(), offsets.next(), 5 + offsets.next()), p(offsets.next(), offsets.next(), 0);
    const Matrix3 R0 = Eigen::AngleAxisd(offsets.next(), randomVector(offsets).normalized()).toRotationMatrix(),
                  R1 = Eigen::AngleAxisd(offsets.next(), randomVector(offsets).normalized()).toRotationMatrix();
    const Vector3 c0 = randomVector(offsets), v0 = randomVector(offsets), w0 = randomVector(offsets);
    const Vector3 v1 = v0 + h * (F / m.mass + gravity), c1 = c0 + 0.5 * h * (v0 + v1);
    const Vector3 w1 = w0 + h * m.I_C.inverse() * (p - 0.5 * (c0 + c1)).cross(F);
    const auto state = [&m](const Matrix3& R, const Vector3& c, const Vector3& v, const Vector3& w) {
      const Vector3 arm = R * m.p_LC;
      return BodyState{Pose(R, Vector3(c - arm)), Twist{w, v - w.cross(arm)}};
    };
    const Wrench found = beyondWeight(m, state(R0, c0, v0, w0), state(R1, c1, v1, w1), gravity, h);
    // Momenta of up to 5 N s, divided by the step.
    const double rounding = 100 * kEps * 5 / h;
    EXPECT_LE((found.force - F).norm(), rounding);
    const Vector3 q = Vector3(3, -2, 0), place = centreOfPush(found, kUp, q, 1e-3);
    EXPECT_LE((place - p).norm(), 10 * rounding / 4);  // arms of up to 10 m, N of at least 4 N
    EXPECT_EQ(centreOfPush(found, kUp, q, 100), q);
  }
}

/// Residuals of a body over the plane z = 0 at the middle of a short time h, of an exact solution that is given by its place and speed.
template <class Solution>
RigidResiduals atMiddle(const Solution& solution, double mass, double mu, double t, double h, const Vector3& hand) {
  LinkInertia m;
  m.mass = mass;
  const auto state = [&](double time) {
    const scenes::Along along = solution(time);
    const Vector3 d = scenes::dragDirection();
    return BodyState{Pose(Vector3(along.way * d)), Twist{Vector3::Zero(), along.speed * d}};
  };
  const Wrench F = beyondWeight(m, state(t - h / 2), state(t + h / 2), {0, 0, -scenes::kBallGravity}, h);
  return rigidResiduals(kUp, F.force - hand, state(t).V_WL.linear, 0, mu);
}

TEST(RigidLaw, exactSolutionsOfTheScenesObeyIt) {
  using scenes::DraggedCube;
  using scenes::Finger;
  const double h = 1e-5, rounding = 100 * kEps / h;
  for (const DraggedCube& cube : {DraggedCube{1.5, 0, 0}, DraggedCube{0.9, 0, 0}, DraggedCube{0, 0.02, 1}}) {
    const auto along = [&cube](double t) { return cube.along(t); };
    const Vector3 hand = cube.force() * scenes::dragDirection();
    for (const double t : {0.1, 0.2, 0.25, 0.4}) {
      const RigidResiduals r = atMiddle(along, DraggedCube::kMass, DraggedCube::kMu, t, h, hand);
      EXPECT_LE(r.coulomb, rounding);
      EXPECT_LE(r.dissipation, rounding);
    }
  }
  EXPECT_GT(DraggedCube({0, 0.02, 1}).along(0.2).speed, 0.1);  // it still slides, and lies at the end
  EXPECT_EQ(DraggedCube({0, 0.02, 1}).along(0.5).speed, 0);
  // Of the finger the change of speed over h errs by h² x'''''/24, at most h² v ω⁴/24; the hand's force is that at the middle.
  const double w = Finger::rate(), bound = Finger::kMass * h * h * Finger::kSpeed * std::pow(w, 4) + rounding;
  for (double t = 0.01; t < 0.5; t += 0.01) {
    if (std::abs(t - Finger::slips()) < h) continue;
    const scenes::Along now = Finger::along(t);
    const double pull = Finger::kSpring * (Finger::kSpeed * t - now.way) + Finger::damping() * (Finger::kSpeed - now.speed);
    const double lift = Finger::kMass * scenes::kBallGravity - Finger::kPress;
    const RigidResiduals r =
        atMiddle(Finger::along, Finger::kMass, Finger::kMu, t, h, pull * scenes::dragDirection() + lift * Vector3::UnitZ());
    EXPECT_LE(r.coulomb, bound) << t;
    EXPECT_LE(r.dissipation, bound) << t;
  }
  EXPECT_LT(Finger::slips(), 0.25);
  EXPECT_GT(Finger::slips(), 0.05);
}

}  // namespace
}  // namespace haptic::report
