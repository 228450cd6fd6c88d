// Instants within a step of velocity Verlet against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "../../comparators/located_events.h"
#include "contact/flush_cube.h"

namespace haptic::test {
namespace located_events_test {

class LocatedEvents : public FlushCube {
 protected:
  /// After a step of h [s] from one twist to another, where the memory knows of one.
  LocatedForce forceAfter(const Twist& before, const Twist& V, const FrictionMemory& memory, double h) {
    if (memory.touching != 0) move({0.5 * (before.angular + V.angular), 0.5 * (before.linear + V.linear)}, h);
    return comparators::forceWithEvents(contact_, X_AB_, workspace_, V, memory, law_, {h}, event_);
  }
  comparators::LocatedEvent event_;
};

TEST_F(LocatedEvents, SticksAgainWhenTheSlipTurnsBack) {
  const double h = 1e-3;
  FrictionMemory memory;
  const Twist fast{Vector3::Zero(), Vector3(0.1, 0, 0)};
  for (int i = 0; i < 5; ++i) memory = forceAfter(fast, fast, memory, h).memory;
  ASSERT_EQ(memory.sliding, 1);
  const double slow = -1e-5;  // less than the springs could drive
  const LocatedForce F = forceAfter(fast, {Vector3::Zero(), Vector3(slow, 0, 0)}, memory, h);
  EXPECT_TRUE(F.sticking);
  // From 0.1 m/s to -1e-5 m/s at a constant rate: it stops just before the end.
  EXPECT_NEAR(event_.at, 0.1 / (0.1 - slow), 1e-12);
}

/// ∫f dt of a patch that is dragged at a constant rate and yields on its way: the springs' triangle up to the limit, then what slides.
TEST_F(LocatedEvents, TheTrapezoidalRuleAndTheImpulseGiveTheWholeYield) {
  const double h = 1e-3, v = 0.2;
  law_.material.tangential_damping = 0;
  const Twist V{Vector3::Zero(), Vector3(v, 0, 0)};
  FrictionMemory memory;
  memory = forceAfter(V, Twist{}, memory, h).memory;
  ASSERT_EQ(memory.load, 0);
  const double slope = law_.material.tangential_stiffness * kArea * v, limit = law_.material.mu_static * load();
  const LocatedForce F = forceAfter(V, V, memory, h);
  ASSERT_EQ(F.memory.sliding, 1);
  const double yields = limit / slope;
  ASSERT_LT(yields, h);
  EXPECT_NEAR(event_.at, yields / h, 1e-9);
  const double expected = -(0.5 * limit * yields + law_.material.mu_dynamic * load() * (h - yields));
  EXPECT_NEAR(F.F_BP_P.force.x() * h / 2 + event_.impulse_P.force.x(), expected, 1e-9 * std::abs(expected));
}

TEST_F(LocatedEvents, TheTrapezoidalRuleAndTheImpulseGiveTheWholeTouch) {
  // A level face that came down at v for the time s < h: ∫F dt is k A v s²/2 and that of the damper.
  const double h = 1e-3, v = 0.2;
  const ContactMaterial& m = law_.material;
  law_.material.mu_static = law_.material.mu_dynamic = 0;
  for (const PressureKind& kind : kPressureKinds) {
    law_.pressure = kind.law;
    for (const double s : {0.1e-3, 0.5e-3, 0.9e-3}) {
      sinkTo(v * s);
      const LocatedForce F = forceAfter({}, {Vector3::Zero(), Vector3(0, 0, -v)}, {}, h);
      const double spring = m.stiffness * kArea * v * s * s / 2;
      const double damping = kind.damping(m);
      const double expected = jumpsAtTouch(kind.law) ? spring + damping * kArea * v * s : spring * (1 + damping * v);
      // Of the volume's depth, eps 0.15 m, against v s ≥ 2e-5 m.
      EXPECT_NEAR(F.F_BP_P.force.z() * h / 2 + event_.impulse_P.force.z(), expected, 1e-10 * expected) << kind.name << " " << s;
      EXPECT_NEAR(event_.at, 1 - s / h, 1e-9);
    }
  }
}

TEST_F(LocatedEvents, ADamperThatBeganInsideTheStepHasSlowedTheBody) {
  // m v' = -b A v since the touch: b A v e⁻ˣ at the end, m v (1 - e⁻ˣ) in all, x = b A s/m.
  const double h = 1e-3, v = 0.2, s = 0.6e-3;
  const ContactMaterial& m = law_.material;
  law_.material.mu_static = law_.material.mu_dynamic = 0;
  law_.pressure = PressureLaw::kLinear;
  law_.reduced_mass = m.damping * kArea * s / 0.4;
  sinkTo(v * s);
  const LocatedForce F = forceAfter({}, {Vector3::Zero(), Vector3(0, 0, -v)}, {}, h);
  const double spring = m.stiffness * kArea * v * s;
  EXPECT_NEAR(F.F_BP_P.force.z(), spring + m.damping * kArea * v * std::exp(-0.4), 1e-10 * F.F_BP_P.force.z());
  const double impulse = spring * s / 2 + law_.reduced_mass * v * (1 - std::exp(-0.4));
  EXPECT_NEAR(F.F_BP_P.force.z() * h / 2 + event_.impulse_P.force.z(), impulse, 1e-10 * impulse);
}

}  // namespace located_events_test
}  // namespace haptic::test
