// Oracles: hard limits on the work of a step, and conservation: whatever is thrown together, no step may create energy.
#include <gtest/gtest.h>

#include <cmath>

#include "../../scenes/heap.h"

namespace haptic {
namespace bounded_step_test {

using scenes::HeapParameters;

WorldSettings settings(Attempts attempts, double h = 1e-3) {
  WorldSettings s;
  s.attempts = attempts;
  s.step = h;
  return s;
}

constexpr Attempts kImplicit[] = {Attempts::kImplicitEuler, Attempts::kSdirk2, Attempts::kAll};

/// Steps a world and judges every step.
void expectBounded(const WorldDef& def, int steps, double most_energy) {
  World world(def);
  for (int i = 0; i < steps; ++i) {
    world.step();
    const StepReport& r = world.report();
    ASSERT_TRUE(r.finite) << def.name << " step " << i;
    ASSERT_LE(r.budget_used, 1) << def.name << " step " << i;
    ASSERT_LE(r.evaluations, 64) << def.name << " step " << i;
    ASSERT_LE(r.factorisations, 8 * r.evaluations) << def.name << " step " << i;  // a pass has eight Newton steps at most
    ASSERT_LE(r.energy.total(), most_energy) << def.name << " step " << i;
  }
}

/// Energy before anything moves, overlaps included: after a step too short to move anything.
double startEnergy(WorldDef def) {
  def.settings.step = 1e-7;
  World world(def);
  world.step();
  return world.report().energy.total();
}

/// Room for what implicit steps may give back of the kinetic energy that a step turns into springs: a share of all.
double withRoom(double energy) { return energy + 1e-3 * std::abs(energy); }

TEST(BoundedStep, AHeapFallsIntoABin) {
  for (Attempts attempts : kImplicit) {
    for (double k : {1e7, 1e8, 1e10}) {
      HeapParameters p;
      p.stiffness = k;
      const WorldDef def = scenes::heap(p, settings(attempts));
      SCOPED_TRACE(testing::Message() << "k " << k << ", integrator " << static_cast<int>(attempts));
      expectBounded(def, 600, withRoom(startEnergy(def)));
    }
  }
}

/// A cube that lands flat upon another rocks on; the damping of Hunt and Crossley fades with its speed, and 5 mm/s were left
/// after 4 s. What is slower than gravity makes it in a step settles.
TEST(BoundedStep, AHeapSettlesAtSecondOrderToo) {
  for (Attempts attempts : kImplicit) {
    const HeapParameters p;
    World world(scenes::heap(p, settings(attempts)));
    for (int i = 0; i < 4000; ++i) world.step();
    double fastest = 0;
    for (int i = 0; i < world.linkCount(); ++i) fastest = std::max(fastest, world.linkTwist(i).linear.norm());
    EXPECT_LT(fastest, 1e-6) << "integrator " << static_cast<int>(attempts);
  }
}

/// Passes of a step of 10 ms that do not contract do so in halves and quarters of it; it has the time for them.
TEST(BoundedStep, LongStepsThatDoNotConvergeAreHalved) {
  for (double h : {3e-3, 1e-2}) {
    const HeapParameters p;
    const WorldDef def = scenes::heap(p, settings(Attempts::kAll, h));
    SCOPED_TRACE(testing::Message() << "step " << h);
    const double most = withRoom(startEnergy(def));
    World world(def);
    for (int i = 0; i * h < 2; ++i) {
      world.step();
      const StepReport& r = world.report();
      ASSERT_EQ(r.flags & kNotConverged, 0u) << "step " << i;
      ASSERT_LE(r.budget_used, 1) << "step " << i;
      ASSERT_LE(r.energy.total(), most) << "step " << i;
    }
  }
}

/// At 1e12 N/m³ steps are left unfinished; their work is bounded all the same, and nothing runs away: what a fold between
/// two passes hides is less than the heap has to give.
TEST(BoundedStep, TheStiffestHeapIsBoundedToo) {
  for (Attempts attempts : kImplicit) {
    HeapParameters p;
    p.stiffness = 1e12;
    const WorldDef def = scenes::heap(p, settings(attempts));
    expectBounded(def, 600, 2 * startEnergy(def));
  }
}

/// Steps that did not converge leave forces out of balance, whose power slowed nobody down. Booked as a loss it was up to two thirds
/// of all that the heap has to give, in one step.
TEST(BoundedStep, AStepOutOfBalanceBooksNoMoreThanItLost) {
  HeapParameters p;
  p.count = 30;
  p.stiffness = 1e6;
  const double falls = startEnergy(scenes::heap(p, settings(Attempts::kImplicitEuler)));  // what overlaps at the start holds little
  p.stiffness = 1e15;
  World world(scenes::heap(p, settings(Attempts::kImplicitEuler)));
  double last = 0, most = 0;
  int unconverged = 0;
  for (int i = 0; i < 600; ++i) {
    world.step();
    const StepReport& r = world.report();
    unconverged += (r.flags & kNotConverged) != 0;
    const double balance = r.energy.total() + r.energy.damping + r.energy.friction;
    if (i > 10) most = std::max(most, balance - last);  // before, cubes that start inside the floor are pushed out
    last = balance;
  }
  EXPECT_GT(unconverged, 100);
  EXPECT_LT(most, 0.01 * falls);
}

/// A plate in a hand squeezes a heap. With a tolerance that no number of passes reaches every step ends out of balance by next to
/// nothing, with more energy than it began with, since the hand works on it: it has to leave the force that a step in balance has.
/// While the start's energy was the bound, the heap was stopped under the hand that went on, and the force rose to twice and more.
TEST(BoundedStep, WhatAHandSqueezesIsNotStoppedUnderIt) {
  HeapParameters p;
  p.stiffness = 1e8;
  WorldDef def = scenes::heap(p, settings(Attempts::kImplicitEuler));
  const double thickness = 0.02, from = 0.4, speed = 0.5;
  def.articulations.push_back(scenes::freeBox("plate", Vector3(0.15, 0.15, thickness), 0.1, Pose(Vector3(0, 0, from))));
  PointerDef hand;
  hand.articulation = static_cast<int>(def.articulations.size()) - 1;
  hand.link = 0;
  def.pointers.push_back(hand);
  World world(def);
  def.settings.tolerance = 1e-15;
  World strict(def);
  int out_of_balance = 0;
  for (int i = 0; i < 700; ++i) {
    const double z = from - speed * 1e-3 * (i + 1);
    const auto aim = [&](World& w) { w.setPointerTarget(0, Pose(Vector3(0, 0, z)), {Vector3::Zero(), Vector3(0, 0, -speed)}); };
    const std::vector<double> start = world.save();
    aim(world);
    world.step();
    const double force = world.pointerWrench(0).force.z();
    if (force < 500) continue;  // it has them all under it, and no other way to go
    strict.restore(start);
    aim(strict);
    strict.step();
    out_of_balance += (strict.report().flags & kNotConverged) != 0 && (world.report().flags & kNotConverged) == 0;
    EXPECT_NEAR(strict.pointerWrench(0).force.z(), force, 0.02 * force) << i;
    if (force > 5000) break;
  }
  EXPECT_GT(out_of_balance, 40);
}

TEST(BoundedStep, HeavyCubesFallAmongLightOnes) {
  for (double k : {1e8, 1e10}) {
    HeapParameters p;
    p.stiffness = k;
    p.mass_ratio = 1000;
    const WorldDef def = scenes::heap(p, settings(Attempts::kImplicitEuler));
    expectBounded(def, 500, withRoom(startEnergy(def)));
  }
}

/// Rods of 20:1 and plates of 1:40 fall across each other.
TEST(BoundedStep, RodsAndPlatesFallAcrossEachOther) {
  for (Attempts attempts : {Attempts::kImplicitEuler, Attempts::kSdirk2}) {
    WorldDef def = scenes::heap({}, settings(attempts));
    def.name = "rods and plates";
    def.articulations.resize(5);
    const Vector3 sizes[] = {{0.1, 0.005, 0.005}, {0.08, 0.08, 0.002}};
    for (int i = 0; i < 10; ++i) {
      const double* turn = scenes::kHeapTurns[i];
      const Quaternion q = rotationFromVector(Vector3(turn[0], turn[1], turn[2]));
      def.articulations.push_back(
          scenes::freeBox("b" + std::to_string(i), sizes[i % 2], 0.02, Pose(q, Vector3(0, 0, 0.1 + 0.11 * i))));
    }
    expectBounded(def, 600, withRoom(startEnergy(def)));
  }
}

/// A tower of ten cubes, shot by a ball (a hull of 60 points) at 10 m/s.
TEST(BoundedStep, ABallShootsATower) {
  scenes::CubeParameters c;
  c.stiffness = 1e9;
  for (Attempts attempts : {Attempts::kImplicitEuler, Attempts::kSdirk2}) {
    WorldDef def = scenes::stack(10, c, settings(attempts));
    def.name = "tower";
    std::vector<Vector3> points;
    for (int i = 0; i < 60; ++i) {  // a spiral of even area
      const double z = 1 - (2 * i + 1) / 60.0, angle = 2.399963 * i, r = std::sqrt(1 - z * z);
      points.push_back(0.05 * Vector3(r * std::cos(angle), r * std::sin(angle), z));
    }
    const auto ball = std::make_shared<ConvexPolyhedron>(ConvexPolyhedron::hull(points));
    def.articulations.push_back(scenes::freeBody("ball", ball, 0.5, 5e-4 * Matrix3::Identity(),
                                                 Pose(Vector3(-0.3, 0.01, 0.55)), {Vector3::Zero(), Vector3(10, 0, 0)}));
    expectBounded(def, 500, withRoom(startEnergy(def)));
  }
}

/// Two tolerances, one motion: a cube that slides slows down by μ g t; what the default may add is its share of that.
TEST(BoundedStep, TheToleranceIsAShareOfTheChange) {
  const auto slide = [](double tolerance) {
    scenes::CubeParameters c;
    c.stiffness = 1e9;
    WorldDef def = scenes::cubeOnFloor(c, settings(Attempts::kImplicitEuler));
    def.settings.tolerance = tolerance;
    def.articulations[1].V_WA.linear.x() = 1;
    World world(def);
    for (int i = 0; i < 100; ++i) world.step();
    return world.linkTwist(1).linear.x();
  };
  const double reference = slide(0), normal = slide(WorldSettings{}.tolerance);
  const double change = 0.5 * scenes::kGravity * 0.1;
  EXPECT_NEAR(reference, 1 - change, 1e-8);
  // Of every step a kept patch and the limit of friction may be wrong by half of the tolerance's share of its change.
  EXPECT_NEAR(normal, reference, 0.5 * WorldSettings{}.tolerance * change);
}

/// A cube that begins to slide in the step in which it touches: its first prediction is ten thousand times as deep as it comes to lie, and
/// there friction can hold anything. Of its way v²/(2 μ g) the first order loses v h/2. (About 1e12 N/m³ one stiffness of five leaves a
/// step unconverged, and loses 2 % of the way.)
TEST(BoundedStep, FrictionStopsNothingByADepthThatIsOnlyPredicted) {
  for (const double k : {1e9, 1e10, 1e11, 1e14}) {
    for (const double h : {1e-2, 1e-3}) {
      scenes::CubeParameters c;
      c.stiffness = k;
      WorldDef def = scenes::cubeOnFloor(c, settings(Attempts::kAll), c.restDepth());
      def.settings.step = h;
      def.articulations[1].V_WA.linear.x() = 1;
      World world(def);
      for (int i = 0; i < std::lround(0.25 / h); ++i) world.step();
      EXPECT_LT(world.linkTwist(1).linear.norm(), 1e-6) << k << " " << h;
      EXPECT_NEAR(world.linkPose(1).p.x(), 1 / scenes::kGravity, 0.5 * h) << k << " " << h;
    }
  }
}

}  // namespace bounded_step_test
}  // namespace haptic
