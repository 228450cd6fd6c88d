// The stiffness that a scene does not give, against closed forms of what lies on a floor and of what a hand bears.
#include "haptic_core/analysis/chosen_stiffness.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "../../scenes/touch.h"
#include "haptic_core/geometry/shapes/ball.h"

namespace haptic {
namespace chosen_stiffness_test {

constexpr double kWeight = 20;  // [N]

LinkDef linkOf(const std::vector<std::pair<Vector3, Vector3>>& boxes) {  // size, centre
  LinkDef link;
  link.name = "body";
  link.joint.type = JointType::kFloating;
  link.inertia.mass = 1;
  for (const auto& [size, centre] : boxes) {
    CollisionDef collision;
    collision.shape = scenes::box(size);
    collision.X_LS.p = centre;
    link.collisions.push_back(collision);
  }
  return link;
}

// It may lie on any of its sides; on the smallest it sinks deepest.
TEST(ChosenStiffness, ABrickNeedsWhatItsSmallestSideNeeds) {
  const double a = 0.2, b = 0.1, c = 0.05;
  const RestingStiffness rest = restingStiffness(linkOf({{{a, b, c}, {0.3, 0, 0}}}), kWeight);
  EXPECT_DOUBLE_EQ(rest.extent, c);
  // The centre of mass at the link's origin lies over none of the sides but those that look along x.
  EXPECT_NEAR(rest.stiffness, kWeight / (b * c * kSink * c), 1e-6 * rest.stiffness);
}

// A corner that is cut off is a side as well, but nothing rests on it: the centre of mass lies beside it.
TEST(ChosenStiffness, ASideThatCarriesNothingAsksForNothing) {
  const Vector3 size(0.2, 0.1, 0.05);
  const double cut = 0.001;
  std::vector<Vector3> corners = scenes::box(size)->vertices();
  const auto last = std::find_if(corners.begin(), corners.end(), [](const Vector3& v) { return v.minCoeff() > 0; });
  const Vector3 corner = *last;
  corners.erase(last);
  for (int i = 0; i < 3; ++i) corners.push_back(corner - cut * Vector3::Unit(i));
  LinkDef link = linkOf({});
  CollisionDef collision;
  collision.shape = std::make_shared<ConvexPolyhedron>(ConvexPolyhedron::hull(corners));
  link.collisions.push_back(collision);
  const double side = size.y() * size.z();
  const RestingStiffness rest = restingStiffness(link, kWeight);
  EXPECT_NEAR(rest.stiffness * side * kSink * size.z(), kWeight, cut * cut / side * kWeight);
}

TEST(ChosenStiffness, ABallNeedsItsCap) {
  LinkDef link = linkOf({});
  CollisionDef collision;
  const double R = 0.05, d = kSink * 2 * R;
  collision.shape = std::make_shared<Ball>(R);
  link.collisions.push_back(collision);
  const double cap = M_PI * d * d * (R - d / 3);
  EXPECT_NEAR(restingStiffness(link, kWeight).stiffness, kWeight / cap, 1e-9 * kWeight / cap);
}

// Four legs under a board: standing on them is the case that counts, and they share the weight.
TEST(ChosenStiffness, ATableStandsOnItsFeet) {
  const double foot = 0.01, height = 0.3;
  std::vector<std::pair<Vector3, Vector3>> boxes = {{{0.4, 0.4, 0.05}, {0, 0, 0}}};
  for (const double x : {-0.15, 0.15}) {
    for (const double y : {-0.15, 0.15}) boxes.push_back({{foot, foot, height}, {x, y, -0.025 - height / 2}});
  }
  const RestingStiffness rest = restingStiffness(linkOf(boxes), kWeight);
  EXPECT_NEAR(rest.extent, height + 0.05, 1e-12);
  const double feet = 4 * foot * foot * kSink * rest.extent;
  EXPECT_NEAR(rest.stiffness, kWeight / feet, 1e-6 * rest.stiffness);
}

TEST(ChosenStiffness, OfATreeThatFloatsEveryLinkCarriesAll) {
  ArticulationDef tree;
  tree.links = {linkOf({{{0.1, 0.1, 0.1}, {0, 0, 0}}}), linkOf({{{0.1, 0.1, 0.1}, {0, 0, 0}}})};
  tree.links[1].parent = 0;
  tree.links[1].joint.type = JointType::kRevolute;
  EXPECT_DOUBLE_EQ(carriedWeight(tree, 1, 10), 20);
  tree.links[0].joint.type = JointType::kRevolute;
  EXPECT_DOUBLE_EQ(carriedWeight(tree, 1, 10), 10);
  tree.links[0].joint.type = JointType::kFixed;
  EXPECT_DOUBLE_EQ(carriedWeight(tree, 0, 10), 0);
}

TEST(ChosenStiffness, ARigidBodyRestsUnderWhatItCarries) {
  const double L = 0.1;
  const LinkDef cube = linkOf({{{L, L, L}, {0, 0, 0}}});
  const double heavy = 1e6;
  const double at_rest = heavy / (L * L * kRigidSink * L);
  EXPECT_NEAR(restingStiffness(cube, heavy, INFINITY, kRigidSink).stiffness, at_rest, 1e-6 * at_rest);
  EXPECT_EQ(restingStiffness(cube, 0, INFINITY, kRigidSink).stiffness, 0) << "what cannot lie asks for nothing";
}

// On every shipped device the certificate passes, at half of the bound or more: no softer than needed.
TEST(ChosenStiffness, AHandBearsWhatItTouches) {
  int devices = 0;
  std::set<std::pair<double, double>> judged;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices")) {
    if (entry.path().extension() != ".yaml") continue;
    const DeviceDef device = loadDevice(entry.path().string());
    ++devices;
    if (!judged.insert({device.delay_s, device.grip_damping}).second) continue;  // a hand bears the same on it
    for (const double rate : {500.0, 1000.0, 2500.0}) {
      for (const bool ball : {true, false}) {
        WorldDef def = scenes::pointerOverWall(makeBox(Vector3(0.01, 0.02, 0.03)), 0.1, 1, 1 / rate);
        if (ball) def.articulations[1].links[0].collisions[0].shape = std::make_shared<Ball>(0.005);
        for (ArticulationDef& body : def.articulations) body.links[0].collisions[0].material = {};
        const HandMapping mapping{2, 0.7};
        def.articulations[1].links[0].collisions[0].material.touch_stiffness = touchStiffness(def, 0, mapping);
        const HandCertificate c = certifyHand(def, 0, mapping, device);
        EXPECT_TRUE(c.holds()) << entry.path() << ": " << c.text();
        EXPECT_GT(c.stiffness, 0.5 * c.held) << entry.path() << ": " << c.text();
      }
    }
  }
  EXPECT_GE(devices, 20);
}

}  // namespace chosen_stiffness_test
}  // namespace haptic
