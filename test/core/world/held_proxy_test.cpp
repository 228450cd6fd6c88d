// A held link follows its hand as far as it presses and sinks within bounds: closed forms of a ball, and the projection's optimality.
#include "haptic_core/world/held_proxy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "../../scenes/touch.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/half_space.h"

namespace haptic {
namespace held_proxy_test {

constexpr double kRadius = 0.005, kStiffness = 1e7, kPeriod = 1e-3, kMu = 0.5;  // [m], [N/m³], [s]
constexpr double kBound = 4571;  // [N/m]: above k times any section of the ball, so nothing is weakened

/// Held over the plane z = 0, which bounds a half-space or a box of 0.1 m.
WorldDef overGround(std::shared_ptr<const ConvexShape> tool, bool half_space) {
  WorldDef world = scenes::pointerOverWall(makeBox(Vector3::Constant(0.01)), 0.02, kStiffness, kPeriod);
  world.articulations[1].links[0].collisions[0].shape = std::move(tool);
  if (half_space) {
    world.articulations[0].X_WA = Pose();
    world.articulations[0].links[0].collisions[0].shape = std::make_shared<HalfSpace>();
  }
  world.settings.default_material.mu_static = world.settings.default_material.mu_dynamic = kMu;
  world.settings.default_material.tangential_damping = 0;  // the hands here start and stop at once
  return world;
}

/// A hand whose goal goes from place to place in steps of 0.05 mm.
struct Hand {
  Hand(std::shared_ptr<const ConvexShape> tool, bool half_space, double force = INFINITY)
      : Hand(overGround(std::move(tool), half_space), force) {}
  explicit Hand(const WorldDef& def, double force = INFINITY) : world(def), at(0, 0, 0.02) {
    bound.stiffness = kBound;
    bound.force = force;
  }
  void goTo(const Vector3& goal) {
    const int steps = std::max(1, static_cast<int>(std::ceil((goal - at).norm() / 5e-5)));
    const Vector3 way = (goal - at) / steps;
    for (int i = 0; i < steps; ++i) {
      const Vector3 before = world.pointerWrench(0).force;
      step(at + way, way / kPeriod);
      const Vector3 change = world.pointerWrench(0).force - before;
      jump = std::max(jump, change.norm() - kBound * way.norm());
      most = std::max(most, world.pointerWrench(0).force.norm());
    }
  }
  void rest() {
    for (int i = 0; i < 100; ++i) step(at, Vector3::Zero());
  }
  void step(const Vector3& goal, const Vector3& velocity) {
    at = goal;
    world.setPointerBound(0, bound);
    world.setPointerTarget(0, Pose(at), {Vector3::Zero(), velocity});
    world.step();
  }
  Vector3 force() const { return world.pointerWrench(0).force; }

  World world;
  PointerBound bound;
  Vector3 at;
  double jump = -INFINITY, most = 0;
};

double capVolume(double depth) { return M_PI * depth * depth * (kRadius - depth / 3); }

class HeldProxy : public testing::TestWithParam<bool> {};

// k V(h) as far as h = 0.9 · 2R, the force of that depth from there on, and the same on the way back.
TEST_P(HeldProxy, ABallPressesByItsCapAndIsNeverSwallowed) {
  Hand hand(std::make_shared<Ball>(kRadius), GetParam());
  const auto expected = [&](double depth) { return kStiffness * capVolume(std::min(std::max(depth, 0.0), kMostSunk * 2 * kRadius)); };
  const double depths[] = {0.001, 0.004, 0.008, 0.0089, 0.0095, 0.02, 0.12, 0.02, 0.0095, 0.0089, 0.004, 0.001, -0.001};
  for (const double depth : depths) {
    hand.goTo(Vector3(0, 0, kRadius - depth));
    hand.rest();
    // Rounding of V, and of the way into the bound: 1e-9 of the ball's diameter, times k A0.
    EXPECT_NEAR(hand.force().z(), expected(depth), 1e-8 * expected(0.12)) << depth;
    EXPECT_NEAR(hand.force().head<2>().norm(), 0, 1e-8 * expected(0.12)) << depth;
  }
  EXPECT_LE(hand.jump, 1e-3 * expected(0.12));
}

// A surface that carries less than its hand's force F and the tool's weight is firm: a twentieth of the ball's volume carries both, so at
// rest the ball shares just that with the ground, and the hand feels F however far it goes. The spring is K e up to F: on the way back the
// force falls where the hand is F/K from its tool.
TEST_P(HeldProxy, ASpringGivesItsHandsForceAndTheGroundCarriesIt) {
  constexpr double F = 6, kShared = 0.05;
  WorldDef def = overGround(std::make_shared<Ball>(kRadius), GetParam());
  def.pointers[0].coupling.mode = PointerCoupling::Mode::kVirtual;
  const double volume = 4.0 / 3 * M_PI * kRadius * kRadius * kRadius;
  const double weight = def.articulations[1].links[0].inertia.mass * def.settings.gravity.norm();
  ASSERT_LT(kStiffness * kShared * volume, F + weight);  // less than that at k
  Hand hand(def, F);
  hand.bound.damping = 4;
  hand.bound.press = F;
  double depth = kRadius;  // of a cap of that volume
  for (int i = 0; i < 60; ++i) depth = std::sqrt(kShared * volume / (M_PI * (kRadius - depth / 3)));
  for (const double z : {-0.03, -0.12, -0.03}) {
    hand.goTo(Vector3(0, 0, z));
    for (int i = 0; i < 10; ++i) hand.rest();
    EXPECT_NEAR(hand.force().z(), F, 1e-4 * F) << z;
    EXPECT_NEAR(hand.world.linkPose(hand.world.pointerLink(0)).p.z(), kRadius - depth, 1e-3 * depth) << z;
  }
  const double half = hand.world.linkPose(hand.world.pointerLink(0)).p.z() - 0.5 * F / kBound;
  hand.goTo(Vector3(0, 0, half));
  for (int i = 0; i < 10; ++i) hand.rest();
  const double spring = kBound * (hand.world.linkPose(hand.world.pointerLink(0)).p.z() - half);
  EXPECT_NEAR(hand.force().z(), spring, 1e-4 * F);
  EXPECT_LT(spring, 0.9 * F);  // the tool rises as it falls
  hand.goTo(Vector3(0, 0, 0.03));
  for (int i = 0; i < 10; ++i) hand.rest();
  EXPECT_NEAR(hand.force().z(), -weight, 1e-3 * F);
}

// A world that came to rest bit for bit goes on to press: a hand that stands still feels the same force in every tick.
TEST_P(HeldProxy, AHandAtRestFeelsItsToolInEveryTick) {
  WorldDef def = overGround(scenes::box(Vector3::Constant(0.01)), GetParam());
  def.pointers[0].coupling.mode = PointerCoupling::Mode::kVirtual;
  def.settings.attempts = Attempts::kImplicitEuler;
  def.settings.default_material.stiffness = 8e8;
  Hand hand(def, 5);
  hand.goTo(Vector3(0, 0, 0));
  for (int i = 0; i < 50; ++i) hand.rest();
  const double pressed = hand.force().z();
  ASSERT_GT(pressed, 1);
  for (int i = 0; i < 500; ++i) {
    hand.step(hand.at, Vector3::Zero());
    ASSERT_NEAR(hand.force().z(), pressed, 1e-6 * pressed) << i;
  }
}

// At the hand's greatest force F the ball stays where the contact's force on it points at the target, as of a hand that pulls with F: it
// sticks while that lies within the friction cone, and slides up to the cone's edge beyond.
TEST_P(HeldProxy, AtTheHandsLimitItSticksInTheFrictionConeAndRubsBeyond) {
  constexpr double F = 2, deep = 0.02;
  Hand hand(std::make_shared<Ball>(kRadius), GetParam(), F);
  hand.goTo(Vector3(0, 0, -deep));
  hand.rest();
  EXPECT_NEAR(hand.force().z(), F, 1e-6 * F);
  const double depth = kRadius - hand.world.linkPose(hand.world.pointerLink(0)).p.z();
  EXPECT_NEAR(kStiffness * capVolume(depth), F, 1e-6 * F);
  for (const double aside : {0.005, 0.04}) {
    hand.goTo(Vector3(aside, 0, -deep));
    for (int i = 0; i < 10; ++i) hand.rest();  // across, what is left of the way falls by F/(k A0 deep), a fiftieth, in a step
    const Vector3 tool = hand.world.linkPose(hand.world.pointerLink(0)).p, way = tool - hand.at;
    EXPECT_LE((hand.force() - F * way.normalized()).norm(), 1e-6 * F) << aside;
    const bool sticks = aside < kMu * deep;
    if (sticks) EXPECT_LE(tool.x(), F / (kStiffness * M_PI * depth * (2 * kRadius - depth) / 2));  // the layer's share of the way
    else EXPECT_NEAR(hand.force().x(), -kMu * hand.force().z(), 1e-6 * F);
  }
  EXPECT_LE(hand.most, F * (1 + 1e-3));
  hand.goTo(Vector3(0.04, 0, kRadius + 0.001));
  EXPECT_EQ(hand.force().norm(), 0);
  EXPECT_LE(hand.jump, 1e-2 * F);
}

// A cube on a soft floor stands under the hand's force F, pressed beside its middle by e, where its tilt is F e / (k J - F H): J the second
// moment of its face, H its height. A tool that follows the normal of the cube's top to its hand, D below, throws it over where
// F (H + D) > k J.
TEST(HeldProxyOf, ACubeUnderAHandFarBelowStands) {
  constexpr double F = 4, side = 0.03, beside = 2e-4;
  WorldDef def = overGround(std::make_shared<Ball>(kRadius), true);
  def.articulations[1].X_WA = Pose(Vector3(0, 0, 0.04));
  def.articulations.push_back(scenes::freeBox("cube", Vector3::Constant(side), 0.1, Pose(Vector3(0, 0, side / 2))));
  Hand hand(def, F);
  hand.bound.stiffness = 8000;
  hand.at = Vector3(0, 0, 0.04);
  hand.goTo(Vector3(beside, 0, 0.04));
  hand.goTo(Vector3(beside, 0, -0.2));  // F (H + D) is 1.5 k J
  for (int i = 0; i < 10; ++i) hand.rest();
  const double upright = kStiffness * side * side * side * side / 12 - F * side;
  const Pose X_WC = hand.world.linkPose(hand.world.linkIndex("cube"));
  EXPECT_NEAR(hand.force().norm(), F, 1e-2 * F);
  EXPECT_LE(std::acos(std::min(1.0, X_WC.R(2, 2))), 2 * F * beside / upright);
}

// A box on its face has no section that warns: V is swallowed from one moment to the next.
TEST_P(HeldProxy, ABoxStopsBeforeItIsInside) {
  constexpr double side = 0.008;
  Hand hand(scenes::box(Vector3::Constant(side)), GetParam());
  const double most = kStiffness * side * side * side * kMostSunk;
  for (const double z : {0.0, -0.03, -0.2, -0.03, 0.0, 0.01}) {
    hand.goTo(Vector3(0, 0, z));
    hand.rest();
    const double depth = std::clamp(side / 2 - z, 0.0, kMostSunk * side);
    EXPECT_NEAR(hand.force().z(), kStiffness * side * side * depth, 1e-8 * most) << z;
  }
  EXPECT_LE(hand.jump, 1e-3 * most);
}

INSTANTIATE_TEST_SUITE_P(BoxAndHalfSpace, HeldProxy, testing::Bool());

// Bars that cross: through one another at most by 0.9 of the thinner one, and out again where they came in.
TEST(HeldProxyOf, ABarDoesNotPassThroughABar) {
  WorldDef world = overGround(scenes::box(Vector3(0.1, 0.01, 0.01)), false);
  world.articulations[0] = scenes::springyBody("wall", makeBox({0.006, 0.2, 0.006}), JointType::kFixed, {0, 0, -0.003}, kStiffness);
  World held(world);
  double height = 0.02, last = 0, deepest = 0;
  for (int i = 0; i < 2400; ++i) {
    height += i < 1200 ? -5e-5 : 5e-5;
    held.setPointerTarget(0, Pose(Vector3(0, 0, height)), {});
    held.step();
    const double F = held.pointerWrench(0).force.z();
    ASSERT_GE(F, 0);
    ASSERT_LE(std::fabs(F - last), 1.01 * kStiffness * 0.006 * 0.01 * 5e-5) << i;  // k A0 times the way
    last = F;
    deepest = std::max(deepest, F);
  }
  EXPECT_NEAR(deepest, kMostSunk * kStiffness * 0.006 * 0.006 * 0.01, 1e-6);
  EXPECT_EQ(last, 0);
}

// A foot that sticks out beside an upright of 40 mm ends at its own back, 10 mm behind its sole. With the upright's height for it, the foot
// was swallowed; where its back went in its area vector fell from one step to the next, and its weakened force K V/A0 leapt.
TEST(HeldProxyOf, AFootEndsAtItsOwnBack) {
  constexpr double foot = 0.01, tall = 0.04;
  WorldDef world = overGround(scenes::box(Vector3(foot, foot, tall)), false);
  CollisionDef piece;
  piece.name = "foot";
  piece.shape = scenes::box(Vector3(0.03, foot, foot));
  piece.X_LS = Pose(Vector3(0.02, 0, -0.5 * (tall - foot)));
  world.articulations[1].links[0].collisions.push_back(piece);
  world.articulations[1].X_WA = Pose(Vector3(0, 0, 0.05));
  Hand hand(world);
  hand.at = Vector3(0, 0, 0.05);
  hand.goTo(Vector3(0, 0, -0.02));
  for (int i = 0; i < 10; ++i) hand.rest();
  const double deep = 0.5 * tall - hand.world.linkPose(hand.world.pointerLink(0)).p.z();
  EXPECT_LE(deep, kMostSunk * foot * (1 + 1e-6));
  EXPECT_GE(deep, kMostSunkWeakened * foot * (1 - 1e-6));
  EXPECT_LE(hand.jump, 1e-2 * hand.most);
}

Matrix6 metric(double rho) {
  Matrix6 M = Matrix6::Identity();
  M.topLeftCorner<3, 3>() *= rho * rho;
  return M;
}

// Karush-Kuhn-Tucker: feasible, pulls ≥ 0 and of active rows alone, and M (δ - δ*) = -Σ λ J. Rows that are a few degrees from
// parallel, with a goal far beyond them, are those of a tool between floor and wall.
TEST(HeldProxyOf, TheMotionIsTheNearestOne) {
  std::mt19937 random(5);
  const auto number = [&] { return random() / 2147483648.0 - 1; };
  constexpr double rho = 0.3;
  int active = 0;
  for (int trial = 0; trial < 600; ++trial) {
    LoadedVector<ProxyRow> rows;
    rows.reserve(8);
    const double apart = trial % 2 ? 1 : 0.1;
    Vector6 common;
    for (int k = 0; k < 6; ++k) common[k] = number();
    for (int i = 0; i < 1 + trial % 8; ++i) {
      ProxyRow row;
      for (int k = 0; k < 6; ++k) row.J[k] = (1 - apart) * common[k] + apart * number();
      row.J.head<3>() *= 0.1;
      row.room = 0.5 * (number() + 1);
      rows.push_back(row);
    }
    Vector6 wanted, motion;
    for (int k = 0; k < 6; ++k) wanted[k] = 10 * number();
    if (!nearestMotion(rows, metric(rho), wanted, motion)) {
      for (const ProxyRow& row : rows) EXPECT_LE(row.J.dot(wanted), row.room);
      continue;
    }
    Vector6 pull = metric(rho) * (motion - wanted);
    // A row gives way by the square of 1e-8, times the rows' condition: 1e4 of eight random ones, 1 / apart² times that of rows alike.
    // A multiplier is known to J δ's rounding times the row's weight of 1e8.
    const double given = 1e-12 * wanted.norm() / (apart * apart), pulled = 1e-6 * wanted.norm() / (apart * apart);
    for (const ProxyRow& row : rows) {
      const double slack = row.room - row.J.dot(motion);
      EXPECT_GE(slack, -given) << trial;
      EXPECT_GE(row.pull(), 0);
      if (row.pull() > pulled) EXPECT_LE(slack, given) << trial;
      pull += row.pull() * row.J;
      active += row.pull() > 0;
    }
    EXPECT_LE(pull.norm(), pulled) << trial;
  }
  EXPECT_GT(active, 200);
}

// Two walls, one hand far beyond both: the force is at its limit, and stays there. The limit is a ball; a tool that followed the planes
// that touch it went from wall to wall, 1 mm in a tick.
TEST(HeldProxyOf, ATwoWallsToolAtTheHandsLimitRests) {
  WorldDef def = overGround(std::make_shared<Ball>(kRadius), true);
  ArticulationDef wall = def.articulations[0];
  wall.name = wall.links[0].name = "wall";
  wall.X_WA = Pose(Matrix3(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitY())), Vector3(-0.0055, 0, 0));  // faces +x
  def.articulations.push_back(wall);
  def.settings.default_material.mu_static = def.settings.default_material.mu_dynamic = 0;
  for (const double angle : {0.3, 0.8, 1.2}) {
    constexpr double F = 2;
    Hand hand(def, F);
    hand.goTo(Vector3(-0.04 * std::cos(angle), 0, -0.04 * std::sin(angle)));
    for (int i = 0; i < 5; ++i) hand.rest();
    const Vector3 there = hand.world.linkPose(hand.world.pointerLink(0)).p;
    for (int i = 0; i < 100; ++i) {
      hand.step(hand.at, Vector3::Zero());
      ASSERT_LE((hand.world.linkPose(hand.world.pointerLink(0)).p - there).norm(), 1e-7) << angle << " " << i;
      ASSERT_NEAR(hand.force().norm(), F, 1e-4 * F) << angle << " " << i;
    }
    EXPECT_GT(hand.force().x(), 0.1 * F);
    EXPECT_GT(hand.force().z(), 0.1 * F);
  }
}

}  // namespace held_proxy_test
}  // namespace haptic
