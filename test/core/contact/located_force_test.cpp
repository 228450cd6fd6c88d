// The wrench of a contact: power, tangent, what the trapezoidal rule misses of a touch inside the step; pressure laws.
#include "haptic_core/contact/located_force.h"

#include <random>

#include "flush_cube.h"

namespace haptic::test {
namespace located_force_test {

class LocatedForces : public FlushCube {};

TEST(PressureKinds, StandInTheOrderOfTheirValues) {
  ContactMaterial m;
  m.damping = 2;
  m.dissipation = 3;
  EXPECT_EQ(kindOf(PressureLaw::kLinear).damping(m), 2);
  EXPECT_EQ(kindOf(PressureLaw::kHuntCrossley).damping(m), 3);
  for (std::size_t i = 0; i < std::size(kPressureKinds); ++i) EXPECT_EQ(static_cast<std::size_t>(kPressureKinds[i].law), i);
}

TEST_F(LocatedForces, PressureIsTheLawsClosedFormAtAnyRate) {
  const ContactMaterial& m = law_.material;
  for (const PressureKind& kind : kPressureKinds) {
    law_.pressure = kind.law;
    for (const double approach : {-0.5, -0.1, -0.01, 0.0, 0.01, 0.3}) {
      const LocatedForce F = force({Vector3::Zero(), Vector3(0, 0, -approach)}, {}, {});
      const double d = depth_, damping = kind.damping(m);
      const double p = jumpsAtTouch(kind.law) ? std::max(0.0, m.stiffness * d + damping * approach)
                                              : m.stiffness * d * std::max(0.0, 1 + damping * approach);
      EXPECT_NEAR(F.normal_force, p * kArea, 1e-10 * load()) << kind.name << " at " << approach;
      EXPECT_NEAR(F.elastic_force, load(), 1e-10 * load());
    }
  }
}

TEST_F(LocatedForces, PowerIsWhatTheWrenchTakes) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 50; ++i) {
    Twist V;
    for (int k = 0; k < 3; ++k) {
      V.angular[k] = normal(random);
      V.linear[k] = 0.1 * normal(random);
    }
    const LocatedForce F = force(V, {}, {1e-3});
    const ContactPower taken = contactPower(F.F_BP_P, F.elastic(), V);
    EXPECT_NEAR(taken.elastic + taken.damping + taken.friction, -power(F.F_BP_P, V), 1e-12 * load());
    EXPECT_NEAR(taken.elastic, -F.elastic_force * V.linear.z(), 1e-12 * load());
  }
}

TEST_F(LocatedForces, TangentIsTheDerivativeByTheTwist) {
  // At rest, stuck: -∂F/∂V = D, and h K + D where the slip of the step loads the springs.
  const double h = 1e-3, small = 1e-7;
  for (const PressureKind& kind : kPressureKinds) {
    law_.pressure = kind.law;
    const PatchTangent tangent = force({}, {}, {h}).tangent;
    const Matrix6 D = tangent.combined(0, 1), with_springs = tangent.combined(h, 1);
    for (int k = 0; k < 6; ++k) {
      Vector6 v = Vector6::Zero();
      v[k] = small;
      const Twist V{v.head<3>(), v.tail<3>()};
      const Vector6 slope = (force(V, {}, {h}).F_BP_P.vector() - force(Twist{} - V, {}, {h}).F_BP_P.vector()) / (2 * small);
      const bool tangential = k == 2 || k == 3 || k == 4;
      const Vector6 expected = -(tangential ? with_springs : D).col(k);
      // The force is linear there: rounding of the difference, 1e-16 N/1e-7.
      EXPECT_NEAR((slope - expected).norm(), 0, 1e-7 * (1 + expected.norm())) << kind.name << " column " << k;
    }
  }
}

}  // namespace located_force_test
}  // namespace haptic::test
