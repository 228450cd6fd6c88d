// Depths at which a scene comes to rest, against m g / (k A).
#include "haptic_core/analysis/resting_depths.h"

#include <gtest/gtest.h>

#include <cmath>

#include "../../scenes/touch.h"

namespace haptic {
namespace resting_depths_test {

constexpr double kStiffness = 1e7, kSize = 0.1;

ArticulationDef cube(const std::string& name, JointType type, double mass, double z) {
  ArticulationDef body;
  body.name = name;
  body.X_WA.p = Vector3(0, 0, z);
  LinkDef link;
  link.name = name;
  link.joint.type = type;
  link.inertia.mass = mass;
  link.inertia.I_C = mass * kSize * kSize / 6 * Matrix3::Identity();
  CollisionDef collision;
  collision.shape = scenes::box(Vector3::Constant(kSize));
  collision.material.stiffness = kStiffness;
  link.collisions.push_back(collision);
  body.links.push_back(link);
  return body;
}

TEST(RestingDepths, ATowerRestsAsItsWeightsSayAndWhatFallsIsLeftOut) {
  WorldDef def;
  def.name = "tower";
  def.articulations = {cube("floor", JointType::kFixed, 1, 0), cube("low", JointType::kFloating, 2, kSize),
                       cube("top", JointType::kFloating, 5, 2 * kSize), cube("falls", JointType::kFloating, 1, 100)};
  const double area = kSize * kSize, g = def.settings.gravity.norm();
  for (const RestingDepths& rest : {restingDepths(def, 100), restingDepthsAsRun(def, 1)}) {
    EXPECT_FALSE(rest.settled);  // one falls
    ASSERT_EQ(rest.contacts.size(), 2u);
    for (const RestingContact& contact : rest.contacts) {
      const double weight = contact.shape_a == 0 ? 7 * g : 5 * g;
      EXPECT_EQ(contact.shape_b, contact.shape_a + 1);
      // What is still settling after a second: a share of e^(-c t) of the softest mode, and a thousandth for the damper of the rest.
      EXPECT_NEAR(contact.depth, weight / (kStiffness * area), 1e-3 * weight / (kStiffness * area));
      EXPECT_NEAR(contact.force, weight, 1e-3 * weight);
    }
  }
  def.articulations.pop_back();
  EXPECT_TRUE(restingDepths(def, 100).settled);
}

/// Settling ends when its budget is spent, tells each step, and a budget that several calls share is one.
TEST(RestingDepths, ABudgetEndsThem) {
  WorldDef def;
  def.name = "tower";
  def.articulations = {cube("floor", JointType::kFixed, 1, 0), cube("low", JointType::kFloating, 2, kSize)};
  SettleBudget endless{1e15, {}};
  const RestingDepths whole = restingDepths(def, 100, kAtRest, &endless);
  ASSERT_TRUE(whole.settled);
  const double work = 1e15 - endless.left;
  EXPECT_GT(work, 0);
  int told = 0;
  SettleBudget half{0.5 * work, [&](double) { ++told; }};
  EXPECT_FALSE(restingDepths(def, 100, kAtRest, &half).settled);
  EXPECT_TRUE(half.spent());
  EXPECT_GT(told, 0);
  EXPECT_TRUE(restingDepths(def, 100, kAtRest, &half).contacts.empty());  // not a step is left
}

}  // namespace resting_depths_test
}  // namespace haptic
