// Friction of a patch whose integrals are closed forms: the elastic layer, the limit, sliding, sticking again, events.
#include "haptic_core/contact/friction.h"

#include <random>

#include "flush_cube.h"

namespace haptic::test {
namespace friction_test {

// 20 roundings of numbers of the size of the load; the volume's area and depth carry the pose's rounding, eps 0.15/1e-4.
constexpr double kRounding = 1e-11;

class Friction : public FlushCube {};

TEST_F(Friction, AStuckPatchIsAnElasticLayerWithItsDamper) {
  const double h = 1e-3;
  for (const Vector3& rate : {Vector3(2e-3, -1e-3, 0), Vector3(0, 0, 0.05), Vector3(-1e-3, 2e-3, 0.03)}) {
    const Twist V{Vector3(0, 0, rate.z()), Vector3(rate.x(), rate.y(), 0)};
    const LocatedForce F = force(V, {}, {h});
    const double layer = law_.material.tangential_stiffness * h + law_.material.tangential_damping;  // k_t s + b_t v
    EXPECT_TRUE(F.sticking);
    EXPECT_NEAR((F.F_BP_P.force.head<2>() + kArea * layer * rate.head<2>()).norm(), 0, kRounding * load());
    EXPECT_NEAR(F.F_BP_P.torque.z(), -kTorsion * layer * rate.z(), kRounding * load() * kSide);
    EXPECT_NEAR(F.memory.energy,
                0.5 * law_.material.tangential_stiffness * h * h *
                    (kArea * rate.head<2>().squaredNorm() + kTorsion * rate.z() * rate.z()),
                kRounding * load() * h);
  }
}

TEST_F(Friction, SlidesWithMuOnceItHadToHoldMoreThanMuStatic) {
  law_.material.tangential_damping = 0;
  const double h = 1e-3, kt = law_.material.tangential_stiffness;
  const Vector3 direction = Vector3(0.8, -0.6, 0);
  const double yields_at = law_.material.mu_static * load() / (kt * kArea * h);  // speed whose slip in h is the limit
  for (const double share : {0.5, 0.99, 1.01, 1.5, 30.0}) {
    const Twist V{Vector3::Zero(), share * yields_at * direction};
    const LocatedForce F = force(V, {}, {h});
    EXPECT_EQ(F.sticking, share < 1) << share;
    const double expected = share < 1 ? share * law_.material.mu_static : law_.material.mu_dynamic;
    EXPECT_NEAR((F.F_BP_P.force.head<2>() + expected * load() * direction.head<2>()).norm(), 0, 1e-9 * load()) << share;
    // The springs hold what slides, no more.
    EXPECT_NEAR(F.memory.slip_M.norm(), expected * load() / (kt * kArea), 1e-9 * h);
  }
}

TEST_F(Friction, ASolveKeepsTheStaticLimitAndANeverYieldingOneIsElastic) {
  law_.material.tangential_damping = 0;
  const double h = 1e-3, speed = 3 * law_.material.mu_static * load() / (law_.material.tangential_stiffness * kArea * h);
  const Twist V{Vector3::Zero(), Vector3(speed, 0, 0)};
  const LocatedForce keeps = force(V, {}, {h, Yielding::kKeepsLimit}), never = force(V, {}, {h, Yielding::kNever});
  EXPECT_NEAR(keeps.F_BP_P.force.head<2>().norm(), law_.material.mu_static * load(), 1e-9 * load());
  EXPECT_NEAR(never.F_BP_P.force.head<2>().norm(), 3 * law_.material.mu_static * load(), 1e-9 * load());
  EXPECT_TRUE(never.sticking);
}

TEST_F(Friction, NeverGivesEnergyWhileItSlides) {
  // Any path of slip and spin: what the bodies lose is at least what the springs gain. Without the damper: where that alone
  // makes a patch yield, the springs are set to the limit at once, ahead of the slip, once per beginning of sliding.
  law_.material.tangential_damping = 0;
  const double h = 1e-3;
  FrictionMemory memory;
  double taken = 0;
  for (int i = 0; i < 400; ++i) {
    const double a = 0.05 * i;
    const Twist V{Vector3(0, 0, 0.4 * std::sin(1.7 * a)), Vector3(0.02 * std::cos(a), 0.03 * std::sin(2 * a), 0)};
    const LocatedForce F = force(V, memory, {h});
    EXPECT_LE(F.F_BP_P.force.head<2>().norm(), law_.material.mu_static * load() * (1 + 1e-9));
    taken -= h * (F.F_BP_P.force.head<2>().dot(V.linear.head<2>()) + F.F_BP_P.torque.z() * V.angular.z());
    memory = F.memory;
    EXPECT_GE(taken - memory.energy, -1e-12);
  }
  EXPECT_GT(taken, 10 * memory.energy);  // it did slide
}

/// A damper that turns hard clips the pressure to a part of the patch, and slip turns over the rest: no pressure ≥ 0 of load N
/// rubs with more than μ N, nor twists with more than μ N R. Two hundredths more are the ellipsoid's, which stands off the integral
/// for the slip of one direction and may be met in another; without a bound it was a hundred times as much.
TEST_F(Friction, NeverExceedsWhatAPressureThatIsClippedCanGive) {
  law_.pressure = PressureLaw::kHuntCrossley;
  law_.material.dissipation = 3e3;
  const double mu = law_.material.mu_dynamic, reach = std::sqrt(kArea / 2);  // half of the face's diagonal
  FrictionMemory slid;
  slid.touching = slid.sliding = 1;
  int clipped = 0;
  for (const double turn : {0.1, 1.0, 10.0, 100.0}) {
    for (const double lift : {-0.01, 0.0, 0.05, 0.5, 4.0}) {
      for (const double spin : {0.0, 20.0, -300.0}) {
        const LocatedForce F = force({Vector3(0.3 * turn, turn, spin), Vector3(1, -0.2, lift)}, slid, {1e-3});
        clipped += F.clipped;
        const Vector2 f = F.F_BP_P.force.head<2>();
        EXPECT_LE(f.norm(), 1.02 * mu * F.normal_force) << turn << " " << lift << " " << spin;
        EXPECT_LE(std::abs(F.F_BP_P.torque.z()), 1.02 * mu * F.normal_force * reach) << turn << " " << lift << " " << spin;
      }
    }
  }
  EXPECT_GT(clipped, 20);
}

TEST_F(Friction, PointsAgainstTheSlipInWhateverAxesThePatchIsGiven) {
  // The cube turned about its normal by quarters is the same cube: the force in the floor's axes must not change.
  const Vector3 v_A(0.03, 0.01, 0);
  for (int quarter = 0; quarter < 4; ++quarter) {
    PairCache cache;
    const Matrix3 R = Eigen::AngleAxisd(quarter * M_PI / 2, Vector3::UnitZ()).toRotationMatrix();
    contactVolume(floor_, cube_, Pose(R, Vector3(0.02, -0.01, 0.15 - depth_)), cache, workspace_, contact_);
    const LocatedForce F = force({Vector3::Zero(), inP(v_A)}, {}, {1});
    const Vector3 f_A = contact_.X_AP.R * Vector3(F.F_BP_P.force.x(), F.F_BP_P.force.y(), 0);
    EXPECT_NEAR((f_A + law_.material.mu_dynamic * load() * v_A.normalized()).norm(), 0, 1e-9 * load());
  }
}

TEST_F(Friction, WithoutTorsionThePatchDoesNotResistSpinning) {
  law_.torsion = false;
  const LocatedForce F = force({Vector3(0, 0, 5), Vector3::Zero()}, {}, {1e-3});
  EXPECT_EQ(F.F_BP_P.torque.z(), 0);
}

/// A patch that grows holds what its old area held; its springs gain nothing by it. One that shrinks loses what the lost area held.
TEST_F(Friction, AreaThatComesIsUnstrained) {
  const double h = 1e-3;
  const Twist V{Vector3(0, 0, 0.05), Vector3(2e-3, -1e-3, 0)};
  FrictionMemory memory = force(V, {}, {h}).memory;
  law_.material.tangential_damping = 0;
  const double k = law_.material.tangential_stiffness, slip = memory.slip_M.norm(), twist = memory.twist;
  for (const double grown : {1.0, 1.5, 4.0, 0.5}) {  // since the last evaluation
    FrictionMemory smaller = memory;
    smaller.area = kArea / grown, smaller.torsion = kTorsion / grown;
    const double held = std::min(1.0, 1 / grown);
    for (int step = 0; step < 3; ++step) {  // it stands: the anchor has kept it
      const LocatedForce F = force({}, smaller, {h});
      EXPECT_NEAR(F.F_BP_P.force.head<2>().norm(), k * kArea * held * slip, kRounding * load()) << grown;
      EXPECT_NEAR(std::abs(F.F_BP_P.torque.z()), k * kTorsion * held * twist, kRounding * load() * kSide) << grown;
      const double before = 0.5 * k * (smaller.area * smaller.slip_M.squaredNorm() + smaller.torsion * smaller.twist * smaller.twist);
      EXPECT_LE(F.memory.energy, before * (1 + 1e-9)) << grown;
      smaller = F.memory;
    }
  }
}

/// While N stays a layer's force falls with the slip, stuck or not, and N adds to it by `perLoad`.
TEST(FrictionLayer, FallsWithTheSlipAndFollowsItsLoad) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1, 1);
  const auto vector = [&](double size) { return Vector3(size * u(random), size * u(random), size * u(random) / 0.05); };
  const double h = 1e-3, load = 10;
  int sliding = 0;
  for (int i = 0; i < 500; ++i) {
    FrictionLayer layer;
    layer.area << 2.5e-3, 2.5e-3, 1e-6;
    layer.stiffness = 1e8;
    layer.damping = 1e4;
    layer.before = vector(1e-5);
    layer.rest = vector(1e-2);
    layer.offset = Vector3(0.05 * u(random), 0.05 * u(random), 1e-3 * u(random));
    layer.mu = 0.5;
    layer.radius = 0.03;
    const Vector3 rate = vector(i % 2 ? 1e-3 : 0.1), other = vector(0.1);
    const FrictionLayer::Hold held = layer.hold(rate, h, load);
    EXPECT_LE((held.force - layer.hold(other, h, load).force).dot(rate - other), 1e-12 * load);
    const double more = 1e-6 * load;  // central differences: 1e-12 of the curvature, 1e-10 of rounding
    const FrictionLayer::Hold above = layer.hold(rate, h, load + more), below = layer.hold(rate, h, load - more);
    if (above.outside != held.outside || below.outside != held.outside) continue;
    sliding += held.outside;
    EXPECT_LE(((above.force - below.force) / (2 * more) - layer.perLoad(held, rate, h, load)).norm(), 1e-8);
  }
  EXPECT_GT(sliding, 100);
}

}  // namespace friction_test
}  // namespace haptic::test
