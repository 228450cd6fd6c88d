/// Force elements between links: springs with a limit and dampers, viscous fields; in explicit and implicit steps.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "../../scenes/actors.h"
#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/world/work.h"

namespace haptic {
namespace link_forces_test {

using namespace scenes;

constexpr double kEps = std::numeric_limits<double>::epsilon();

WorldSettings settingsFor(Attempts attempts, double h = 1e-3, double gravity = 0) {
  WorldSettings s;
  s.attempts = attempts;
  s.step = h;
  s.gravity = Vector3(0, 0, -gravity);
  return s;
}

/// A spring's numbers.
struct Spring {
  double k = 100, d = 0, rest = 0.2, most = kNoBound;  ///< [N/m], [N·s/m], [m], [N]
};

/// From a point of articulation a (−1: W) to the origin of articulation b.
ForceDef spring(const Spring& s, int a, int b, const Vector3& p_A = Vector3::Zero()) {
  ForceDef def(ForceType::kSpring);
  def.name = "spring";
  def.articulation_a = a, def.link_a = a < 0 ? -1 : 0;
  def.articulation_b = b, def.link_b = 0;
  def.p_A = p_A;
  def.set("stiffness", s.k), def.set("damping", s.d), def.set("rest_length", s.rest), def.set("most", s.most);
  return def;
}

/// On every body that moves.
ForceDef field(double viscosity) {
  ForceDef def(ForceType::kViscous);
  def.name = "oil";
  def.set("viscosity", viscosity);
  return def;
}

/// A ball without contact at x along the spring from W's origin, at rest.
constexpr double kMass = 0.5, kRadius = 0.05;
ArticulationDef ball(const std::string& name, double mass, const Vector3& p_W, const Vector3& velocity = Vector3::Zero()) {
  Twist V;
  V.linear = velocity;
  return freeBody(name, std::make_shared<Ball>(kRadius), mass, 0.4 * mass * kRadius * kRadius * Matrix3::Identity(), Pose(p_W), V);
}

WorldDef onSpring(const Spring& s, const WorldSettings& settings, double x) {
  WorldDef def;
  def.name = "on a spring";
  def.settings = settings;
  def.articulations.push_back(ball("ball", kMass, Vector3(x, 0, 0)));
  def.forces.push_back(spring(s, -1, 0));
  return def;
}

void advance(World& world, double seconds) {
  const int n = static_cast<int>(std::lround(seconds / world.settings().step));
  for (int i = 0; i < n; ++i) world.step();
}

/// Position and energy of m x'' = -k x - d x', from rest at x0.
struct Swing {
  double x = 0, energy = 0;  ///< [m], [J]
};
Swing swing(const Spring& s, double x0, double t) {
  const double b = s.d / (2 * kMass), w = std::sqrt(s.k / kMass - b * b), decay = x0 * std::exp(-b * t);
  const double x = decay * (std::cos(w * t) + b / w * std::sin(w * t)), v = -decay * s.k / (kMass * w) * std::sin(w * t);
  return {x, 0.5 * kMass * v * v + 0.5 * s.k * x * x};
}

double orderOf(double coarse, double fine) { return std::log2(std::abs(coarse / fine)); }
constexpr double kOfOrder = 0.1;  // what the next term of the error does to log2 of a quotient of two

struct Scheme {
  Attempts attempts;
  int order;
};
constexpr const char* kNames[] = {"all", "implicit_euler", "sdirk2"};
class Forces : public ::testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, Forces,
                         ::testing::Values(Scheme{Attempts::kImplicitEuler, 1}, Scheme{Attempts::kSdirk2, 2}, Scheme{Attempts::kAll, 2}),
                         [](const auto& info) { return std::string(kNames[static_cast<int>(info.param.attempts)]); });

/// Position, and what the ledger has of the energy that the damper took, converge to the closed form with the scheme's order.
TEST_P(Forces, ADampedSwingConvergesToItsClosedForm) {
  const Spring s{100, 0.5};
  const double x0 = 0.1, seconds = 0.8;
  double error[2], booked[2];
  for (int i = 0; i < 2; ++i) {
    WorldSettings settings = settingsFor(GetParam().attempts, 1e-3 / (1 << i));
    settings.accuracy = 1;  // no parts of a step
    World world(onSpring(s, settings, s.rest + x0));
    advance(world, seconds);
    const Swing closed = swing(s, x0, seconds);
    error[i] = world.linkPose(0).p.x() - s.rest - closed.x;
    booked[i] = world.report().energy.damping - (0.5 * s.k * x0 * x0 - closed.energy);
    EXPECT_NEAR(world.report().energy.balance(), 0.5 * s.k * x0 * x0 - world.report().energy.numerical, 1e3 * kEps);
  }
  EXPECT_NEAR(orderOf(error[0], error[1]), GetParam().order, kOfOrder);
  EXPECT_NEAR(orderOf(booked[0], booked[1]), GetParam().order, kOfOrder);
  const double phase = std::sqrt(s.k / kMass) * 5e-4;
  EXPECT_LT(std::abs(error[1]), x0 * std::pow(phase, GetParam().order) * phase / 5e-4 * seconds);
}

/// A light mass on a stiff spring keeps the island implicit, and follows the heavy one. Closed form: the slow mode of the two.
TEST(ForcesByBdf2, ASlowModeConvergesWithOrderTwo) {
  const double m1 = 1, m2 = 1e-3, k1 = 100, k2 = 1e4, x0 = 0.1, seconds = 0.8;
  const double a = m1 * m2, b = m1 * k2 + m2 * (k1 + k2), w2 = 2 * k1 * k2 / (b + std::sqrt(b * b - 4 * a * k1 * k2));
  double error[2];
  for (int i = 0; i < 2; ++i) {
    WorldDef def;
    def.settings = settingsFor(Attempts::kAll, 2e-3 / (1 << i));
    def.settings.accuracy = 1;
    def.articulations.push_back(ball("heavy", m1, Vector3(0.2 + x0, 0, 0)));
    def.articulations.push_back(ball("light", m2, Vector3(0.4 + x0 * k2 / (k2 - m2 * w2), 0, 0)));
    def.forces = {spring({k1}, -1, 0), spring({k2}, 0, 1)};
    World world(def);
    int one_solve = 0, steps = 0;
    for (; steps < seconds / def.settings.step - 0.5; ++steps) {
      world.step();
      EXPECT_EQ(world.report().implicit_islands, 1);
      one_solve += world.report().fallbacks == 0 && world.report().parts == 1;
    }
    EXPECT_GT(one_solve, steps - 5);
    error[i] = world.linkPose(0).p.x() - 0.2 - x0 * std::cos(std::sqrt(w2) * seconds);
  }
  EXPECT_NEAR(orderOf(error[0], error[1]), 2, kOfOrder);
}

/// Beyond its limit a spring pulls with a constant force: a parabola by the law of each scheme, at any stiffness. What is at rest is
/// asked first by implicit Euler whether it stands, so one step at most is Euler's.
TEST_P(Forces, BeyondTheLimitTheForceIsConstant) {
  const double h = 1e-3;
  for (const double k : {100.0, 1e4 * kMass / (h * h)}) {
    const Spring s{k, 0.01 * k * h, 0.2, 2};
    World world(onSpring(s, settingsFor(GetParam().attempts), s.rest + 0.3));
    const int n = 200;
    for (int i = 0; i < n; ++i) world.step();
    const double a = s.most / kMass, euler = 0.5 * a * h * h;
    const double way = euler * (GetParam().order == 1 ? n * (n + 1.0) : 1.0 * n * n), found = s.rest + 0.3 - world.linkPose(0).p.x();
    const double solves = 1e-8 * way;  // kContactFree of stage_passes.cpp
    EXPECT_GT(found, way - solves - 1e3 * kEps);
    EXPECT_LT(found, way + (GetParam().order == 1 ? 0 : euler) + solves + 1e3 * kEps);
    EXPECT_NEAR(world.linkTwist(0).linear.x(), -n * a * h, solves / h + 1e3 * kEps);
    EXPECT_EQ(world.force(0).onB().force.x(), -s.most);
    const double stored = s.most * (0.3 - found - 0.5 * s.most / k);
    EXPECT_NEAR(world.force(0).stored, stored, 1e3 * kEps);
  }
}

/// Stokes: a ball sinks with m g/(6 π μ r) at last, however thick the fluid; h c/m is 1.9e-3 and 19.
TEST_P(Forces, ABallSinksWithItsTerminalVelocity) {
  for (const double viscosity : {1.0, 1e4}) {
    const bool stiff = viscosity > 1;
    const double drag = 6 * M_PI * viscosity * kRadius, last = kMass * kGravity / drag, seconds = stiff ? 0.5 : 0.6;
    double error[2];
    for (int i = 0; i < 2; ++i) {
      WorldDef def;
      def.settings = settingsFor(GetParam().attempts, 1e-3 / (1 << i), kGravity);
      def.settings.accuracy = 1;
      def.articulations.push_back(ball("ball", kMass, Vector3::Zero()));
      def.forces.push_back(field(viscosity));
      World world(def);
      advance(world, seconds);
      error[i] = -world.linkTwist(0).linear.z() - last * (1 - std::exp(-seconds * drag / kMass));
      const EnergyLedger& e = world.report().energy;
      EXPECT_NEAR(e.balance() + e.numerical, 0, 1e4 * kEps);
    }
    if (stiff) {
      EXPECT_LT(std::abs(error[1]), 1e-8 * last);
    } else {
      EXPECT_NEAR(orderOf(error[0], error[1]), GetParam().order, kOfOrder);
    }
  }
}

/// Spin decays with 8 π μ r³ over the moment of inertia.
TEST_P(Forces, AFieldBrakesSpin) {
  const double viscosity = 1, brake = 8 * M_PI * viscosity * kRadius * kRadius * kRadius, inertia = 0.4 * kMass * kRadius * kRadius;
  double error[2];
  for (int i = 0; i < 2; ++i) {
    WorldDef def;
    def.settings = settingsFor(GetParam().attempts, 2e-3 / (1 << i));
    def.articulations.push_back(ball("ball", kMass, Vector3::Zero()));
    def.articulations[0].V_WA.angular = Vector3(1, 2, -3);
    def.forces.push_back(field(viscosity));
    World world(def);
    advance(world, 0.4);
    error[i] = world.linkTwist(0).angular.norm() - std::sqrt(14) * std::exp(-0.4 * brake / inertia);
  }
  EXPECT_NEAR(orderOf(error[0], error[1]), GetParam().order, kOfOrder);
}

/// Within a box the drag is whole, outside of it nothing, and at its rim the share of the ball's extent.
TEST(ViscousField, ActsByTheShareOfTheBallThatIsInTheBox) {
  const std::pair<double, double> cases[] = {{-0.2, 1}, {-kRadius, 1}, {0, 0.5}, {0.5 * kRadius, 0.25}, {0.2, 0}};
  for (const auto& [z, share] : cases) {
    WorldDef def;
    def.settings = settingsFor(Attempts::kAll);
    def.articulations.push_back(ball("ball", kMass, Vector3(0.3, 0, z), Vector3(1, 0, 0)));
    ForceDef pool = field(1);
    pool.set("upper_z", 0), pool.set("lower_x", -5);
    def.forces.push_back(pool);
    const World world(def);
    EXPECT_NEAR(world.force(0).onB().force.x(), -6 * M_PI * kRadius * share, 10 * kEps) << z;
  }
}

/// Two free bodies that turn, on a spring off their centres.
WorldDef pair(const WorldSettings& settings, const Spring& s) {
  WorldDef def;
  def.settings = settings;
  def.articulations.push_back(freeBox("one", Vector3(0.1, 0.2, 0.3), 0.7, Pose(), {Vector3(1, 2, -1), Vector3(0.2, 0, 0.1)}));
  const Twist V{Vector3(0, -3, 1), Vector3(0, 0.3, -0.2)};
  def.articulations.push_back(freeBox("two", Vector3(0.2, 0.1, 0.1), 0.3, Pose(Vector3(0.6, 0.1, 0)), V));
  ForceDef between = spring(s, 0, 1, Vector3(0.05, -0.1, 0.1));
  between.p_B = Vector3(-0.1, 0.05, 0);
  def.forces.push_back(between);
  return def;
}

Wrench momentumOf(const World& world) {
  Wrench sum;
  for (const ModelTree& tree : world.model().trees) {
    sum += momentum(*tree.model, world.work().placement.link.data() + tree.link, Vector3::Zero());
  }
  return sum;
}

/// Steps change the angular momentum by their own order (world/README).
TEST_P(Forces, ASpringBetweenTwoBodiesKeepsTheirMomentum) {
  for (const double k : {100.0, 1e6}) {
    double turned[2];
    for (int i = 0; i < 2; ++i) {
      World world(pair(settingsFor(GetParam().attempts, 1e-3 / (1 << i)), {k, 0.3, 0.4}));
      const Wrench before = momentumOf(world);
      advance(world, 0.5);
      const Wrench after = momentumOf(world);
      EXPECT_GT((world.linkTwist(0).linear - Vector3(0.2, 0, 0.1)).norm(), 0.1);
      // Impulses of up to k Δℓ h = 40 N·s in a thousand steps, a rounding each.
      EXPECT_LT((after.force - before.force).norm(), 2000 * kEps * (1 + 4e-7 * k));
      turned[i] = (after.torque - before.torque).norm();
    }
    if (GetParam().attempts == Attempts::kSdirk2 && k == 100) EXPECT_NEAR(orderOf(turned[0], turned[1]), 2, 0.3);
  }
}

/// k h²/m = 1e4: no energy from nothing, and the mass comes to rest where the spring bears it, to the last bit.
TEST(StiffSpring, StaysStableAndComesToRest) {
  const double h = 1e-3, k = 1e4 * kMass / (h * h);
  for (const Attempts attempts : {Attempts::kImplicitEuler, Attempts::kSdirk2, Attempts::kAll}) {
    for (const double gravity : {0.0, kGravity}) {
      for (const double d : {0.0, 1e3}) {
        WorldDef def;
        def.settings = settingsFor(attempts, h, gravity);
        def.articulations.push_back(ball("ball", kMass, Vector3(0, 0, -0.3)));
        def.forces.push_back(spring({k, d, 0.2}, -1, 0));
        World world(def);
        double highest = 0, start = 0;
        for (int i = 0; i < 1000; ++i) {
          world.step();
          const EnergyLedger& e = world.report().energy;
          highest = std::max(highest, e.total());
          if (i == 0) start = e.total();
        }
        EXPECT_LT(start, 0.5 * k * 0.01);
        EXPECT_LE(highest, start);
        EXPECT_EQ(world.linkTwist(0).linear.norm(), 0);
        EXPECT_TRUE(world.stands(0));
        // At rest to 3e-5 of its weight (world/README.md).
        EXPECT_NEAR(world.linkPose(0).p.z(), -0.2 - kMass * gravity / k, 3e-5 * kMass * gravity / k + 4 * kEps);
        const std::vector<double> q = world.q();
        advance(world, 0.1);
        EXPECT_EQ(world.q(), q);
      }
    }
  }
}

/// Twenty cubes on a floor, joined two by two by springs that friction holds stretched, one that falls on the second pair, and oil.
WorldDef joined(bool leave_out, bool ledger) {
  CubeParameters c;
  c.stiffness = 1e8;
  WorldDef def;
  def.settings.leave_out = leave_out;
  def.settings.energy_ledger = ledger;
  def.settings.default_material = c.material();
  def.articulations.push_back(floorBox());
  const double z = c.size / 2 - c.restDepth();
  for (int i = 0; i < 20; ++i) {
    def.articulations.push_back(cube("cube" + std::to_string(i), c, Pose(Vector3(0.25 * (i % 2) - 1, 0.3 * (i / 2) - 1.5, z))));
    if (i % 2 == 1) def.forces.push_back(spring({20, 0.1, 0.24}, i, i + 1));
  }
  def.articulations.push_back(cube("falls", c, Pose(Vector3(-0.96, -1.17, 2))));
  def.forces.push_back(field(0.02));
  return def;
}

TEST(SprungBodies, SameBitsWithAllLeftInAndWithoutALedger) {
  World lazy(joined(true, true)), general(joined(false, true)), unbooked(joined(true, false));
  for (int i = 0; i < 1200; ++i) {
    for (World* world : {&lazy, &general, &unbooked}) world->step();
    ASSERT_EQ(lazy.hash(), general.hash()) << i;
    ASSERT_EQ(lazy.report().energy.potential, general.report().energy.potential) << i;
    if (i == 500) EXPECT_EQ(lazy.report().standing, 20) << "pairs stand before the cube comes down";
    if (i == 500) EXPECT_GT(lazy.work().activity.trees(), 0);
  }
  EXPECT_EQ(lazy.q(), unbooked.q());
  EXPECT_EQ(lazy.v(), unbooked.v());
  // What was hit moved, and so did the body at the other end of its spring.
  const World start(joined(true, true));
  EXPECT_GT((lazy.linkPose(3).p - start.linkPose(3).p).norm(), 1e-4);
  EXPECT_NE(lazy.linkPose(4).p, start.linkPose(4).p);
  EXPECT_LT((lazy.linkPose(7).p - start.linkPose(7).p).norm(), 1e-6);
}

TEST(SprungBodies, GoOnFromASavedStateBitForBit) {
  World world(joined(true, true)), other(joined(true, true));
  advance(world, 0.65);
  other.restore(world.save());
  advance(world, 0.2), advance(other, 0.2);
  EXPECT_EQ(world.hash(), other.hash());
}

/// One body of the pair is put elsewhere: the world goes on as one that starts so, the body that stayed as well.
TEST_P(Forces, ABodyPutElsewherePullsFromThere) {
  const Spring s{100, 0.3, 0.4};
  const Pose X_W2(Vector3(0.9, -0.2, 0.1));
  WorldDef def = pair(settingsFor(GetParam().attempts), s);
  for (ArticulationDef& body : def.articulations) body.V_WA = {};
  World world(def);
  world.step();
  world.setBodyPose(1, X_W2, {});
  def.articulations[0].X_WA = world.linkPose(0);
  def.articulations[0].V_WA = world.linkTwist(0);
  def.articulations[1].X_WA = X_W2;
  World fresh(def);
  advance(world, 0.3), advance(fresh, 0.3);
  // Solves end at 1e-8 of the change of speed (kContactFree), here of a way of 0.1 m; half a kick by the force of before would be 6e-3 m.
  for (int l = 0; l < 2; ++l) EXPECT_LT((world.linkPose(l).p - fresh.linkPose(l).p).norm(), 1e-9);
}

/// Bodies on rails: a spring between two links of one tree swings with the reduced mass.
TEST_P(Forces, ASpringBetweenLinksOfOneTreeSwingsWithTheReducedMass) {
  const double m1 = 0.4, m2 = 0.6, k = 50, x0 = 0.05, seconds = 0.5;
  double error[2];
  for (int i = 0; i < 2; ++i) {
    WorldDef def;
    def.settings = settingsFor(GetParam().attempts, 1e-3 / (1 << i));
    def.settings.accuracy = 1;
    ArticulationDef rail = freeBox("one", Vector3(0.1, 0.1, 0.1), m1, Pose());
    rail.links[0].joint.type = JointType::kPrismatic;
    rail.links[0].joint.axis = Vector3::UnitX();
    LinkDef two = freeBox("two", Vector3(0.1, 0.1, 0.1), m2, Pose()).links[0];
    two.joint.type = JointType::kPrismatic;
    two.joint.axis = Vector3::UnitX();
    two.joint.X_PJ = Pose(Vector3(0.3 + x0, 0, 0));
    two.parent = 0;
    rail.links.push_back(two);
    def.articulations.push_back(rail);
    ForceDef between = spring({k, 0, 0.3}, 0, 0);
    between.link_b = 1;
    def.forces.push_back(between);
    World world(def);
    advance(world, seconds);
    error[i] = world.linkPose(1).p.x() - world.linkPose(0).p.x() - 0.3 - x0 * std::cos(std::sqrt(k * (m1 + m2) / (m1 * m2)) * seconds);
    EXPECT_NEAR(m1 * world.linkTwist(0).linear.x() + m2 * world.linkTwist(1).linear.x(), 0, 1e4 * kEps);
  }
  EXPECT_NEAR(orderOf(error[0], error[1]), GetParam().order, kOfOrder);
}

/// A hand that leads one body drags another through oil by a spring: at last the hand feels the drag, and supplies what the oil takes.
TEST_P(Forces, AHandDragsByASpring) {
  const double speed = 0.1, viscosity = 5, drag = 6 * M_PI * viscosity * kRadius;
  WorldDef def;
  def.settings = settingsFor(GetParam().attempts);
  def.articulations.push_back(ball("hand", 1, Vector3::Zero()));
  def.articulations.push_back(ball("load", kMass, Vector3(-0.2, 0, 0)));
  PointerDef pointer;
  pointer.articulation = pointer.link = 0;
  def.pointers.push_back(pointer);
  def.filters.push_back({0, 0, 1, 0});
  ForceDef oil = field(viscosity);
  oil.articulation_b = 1, oil.link_b = 0;
  def.forces = {spring({100, 1}, 0, 1), oil};
  World world(def);
  const double h = def.settings.step;
  EnergyLedger before;
  const int n = 4000, last = 1000;
  for (int i = 0; i < n; ++i) {
    if (i == n - last) before = world.report().energy;
    Twist V;
    V.linear = Vector3(speed, 0, 0);
    world.setPointerTarget(0, Pose(Vector3(speed * h * (i + 1), 0, 0)), V);
    world.step();
  }
  const EnergyLedger& e = world.report().energy;
  const double work = drag * speed * speed * last * h;
  const double transient = std::exp(-3 * drag / (2 * kMass)) + 1e-8;  // of 3 s, and the tolerance of implicit solves
  EXPECT_NEAR(world.pointerWrench(0).force.x(), -drag * speed, drag * speed * transient);
  EXPECT_NEAR(e.external - before.external, work, work * transient);
  EXPECT_NEAR(e.damping - before.damping, work, work * transient);
  EXPECT_NEAR(e.numerical - before.numerical, 0, work * transient);
}

/// The joint that holds a link against a spring reads what it reads against a constant force of the same size.
TEST(SprungBodies, AJointSensorCountsTheSpring) {
  std::vector<Wrench> read;
  for (const bool by_spring : {true, false}) {
    WorldDef def;
    def.settings = settingsFor(Attempts::kAll);
    ArticulationDef rail = freeBox("slider", Vector3(0.1, 0.1, 0.1), kMass, Pose());
    rail.links[0].joint.type = JointType::kPrismatic;
    rail.links[0].joint.axis = Vector3::UnitZ();
    def.articulations.push_back(rail);
    SensorDef sensor;
    sensor.name = "joint";
    sensor.kind = SensorDef::Kind::kWrench;
    sensor.articulation = sensor.link = 0;
    def.sensors.push_back(sensor);
    const Vector3 anchor(0.5, 0, 0);
    if (by_spring) def.forces.push_back(spring({100, 0, 0.2}, -1, 0, anchor));
    World world(def);
    if (!by_spring) world.applyWrench(0, {{Vector3::Zero(), Vector3(30, 0, 0)}, Vector3::Zero(), false}, 1);
    advance(world, 0.01);
    read.push_back(world.sensorReading(0).F_S);
  }
  EXPECT_GT(read[0].force.norm(), 29);
  EXPECT_LT((read[0].force - read[1].force).norm(), 1e3 * kEps);
  EXPECT_LT((read[0].torque - read[1].torque).norm(), 1e3 * kEps);
}

/// The same bodies and elements go on bit for bit; without its spring a body flies straight on.
TEST_P(Forces, AnExchangedWorldHasItsOwnElements) {
  const WorldDef def = pair(settingsFor(GetParam().attempts), {100, 0.3, 0.4});
  World world(def), reference(def);
  advance(world, 0.1), advance(reference, 0.1);
  NextWorld same(world, def, {0, 1});
  ASSERT_TRUE(world.exchange(same));
  advance(world, 0.1), advance(reference, 0.1);
  EXPECT_EQ(world.q(), reference.q());
  WorldDef loose = def;
  loose.forces.clear();
  NextWorld next(world, loose, {0, 1});
  ASSERT_TRUE(world.exchange(next));
  const Vector3 p = world.linkPose(0).p, v = world.linkTwist(0).linear;
  advance(world, 0.1);
  EXPECT_LT((world.linkPose(0).p - p - 0.1 * v).norm(), 1e4 * kEps);
}

TEST(ForceElements, BadOnesAreRefused) {
  const auto refused = [](const ForceDef& force) {
    WorldDef def = onSpring({}, settingsFor(Attempts::kAll), 0.3);
    def.articulations.push_back(staticBox("wall", Vector3(1, 1, 1), Pose(Vector3(3, 0, 0))));
    def.forces.push_back(force);
    EXPECT_THROW(World world(def), SetupError);
  };
  for (const char* name : {"stiffness", "damping", "rest_length", "most"}) {
    for (const double bad : {-1.0, std::nan("")}) {
      ForceDef force = spring({}, -1, 0);
      force.set(name, bad);
      refused(force);
    }
  }
  ForceDef force = spring({}, -1, 0);
  EXPECT_THROW(force.set("stifness", 1), SetupError);
  force.p_A.x() = std::nan("");
  refused(force);
  refused(spring({}, -1, 7));
  refused(spring({}, 7, 0));
  refused(spring({}, 0, 0));
  refused(spring({}, -1, 1));
}

}  // namespace link_forces_test
}  // namespace haptic
