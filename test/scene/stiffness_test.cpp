// Stiffness from what a scene says of its surfaces: a material, a modulus, a number, or nothing.
#include <gtest/gtest.h>

#include <cmath>

#include "haptic_core/analysis/hand_certificate.h"
#include "haptic_core/contact/elastic_layer.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/world.h"
#include "temporary_files.h"

namespace haptic {
namespace stiffness_test {

/// A cube of 0.1 m on a slab of 0.2 m whose top is z = 0, 10 µm above it.
std::string cubeOnSlab(const std::string& cube, const std::string& slab, double mass = 1, const std::string& scene = "") {
  return robot(scene + "<link name=\"world\"/>" + boxLink("cube", mass, 0.1, cube) + boxLink("slab", 1, 0.2, slab) +
               joint("f", "floating", "world", "cube", "", "0 0 0.05001") + joint("s", "fixed", "world", "slab", "", "0 0 -0.1"));
}

std::string contact(const std::string& inside) { return "<haptic:contact " + inside + "/>"; }

SceneDef load(const std::string& urdf, bool pointer = false) {
  SceneOptions options;
  options.add_pointer = pointer;
  return loadText(urdf, options);
}

double restDepth(const SceneDef& scene) {
  World world(scene.world);
  for (int i = 0; i < 3000; ++i) world.step();
  EXPECT_LT(world.linkTwist(world.linkIndex("cube")).linear.norm(), 1e-6);
  return 0.05 - world.linkPose(world.linkIndex("cube")).p.z();
}

TEST(Stiffness, ACubeSinksAsItsMaterialsAndItsWeightSay) {
  for (const auto& [cube, slab] : {std::pair("skin", "skin"), {"rubber", "skin"}, {"rubber", "rubber"}, {"steel", "rubber"}}) {
    const SceneDef scene = load(cubeOnSlab(contact("material=\"" + std::string(cube) + "\" dissipation=\"1000\""),
                                           contact("dissipation=\"1000\" material=\"" + std::string(slab) + "\"")));
    const Solid &A = *solidNamed(cube), &B = *solidNamed(slab);
    const double compliance = 0.1 / (2 * confinement(A.poisson_ratio) * A.young_modulus) +
                              0.2 / (2 * confinement(B.poisson_ratio) * B.young_modulus);
    const double depth = 9.8 / 0.01 * compliance;
    EXPECT_NEAR(restDepth(scene), depth, 1e-3 * depth) << cube << " on " << slab;
  }
}

TEST(Stiffness, StiffMaterialsRestToo) {
  for (const char* name : {"acrylic", "wood", "concrete", "aluminium", "steel"}) {
    const std::string of = contact("material=\"" + std::string(name) + "\"");
    const SceneDef scene = load(cubeOnSlab(of, of, 10));
    World world(scene.world);
    for (int i = 0; i < 2000; ++i) world.step();
    EXPECT_TRUE(world.report().finite);
    EXPECT_EQ(world.report().flags & kNotConverged, 0u) << name;
    EXPECT_LT(world.linkTwist(world.linkIndex("cube")).linear.norm(), 1e-6) << name;
    EXPECT_NEAR(world.linkPose(world.linkIndex("cube")).p.z(), 0.05, 1e-6) << name;
  }
}

TEST(Stiffness, AModulusIsOneOfAnUsualSolidAndAScenesMaterialIsForAllThatSayNothing) {
  const double k = surfaceStiffness(3e8, kUsualPoissonRatio, 0.1);
  const auto given = [](const SceneDef& scene, const char* link) {
    for (const CollisionReport& report : scene.collisions)
      if (report.link == link) return report.material.stiffness;
    return 0.0;
  };
  EXPECT_DOUBLE_EQ(given(load(cubeOnSlab(contact("young_modulus=\"3e8\""), "")), "cube"), k);
  EXPECT_DOUBLE_EQ(given(load(cubeOnSlab("<haptic:contact><haptic:young_modulus value=\"3e8\"/></haptic:contact>", "")), "cube"), k);
  const std::string of_all = "<haptic:scene>" + contact("young_modulus=\"3e8\"") + "</haptic:scene>";
  const SceneDef scene = load(cubeOnSlab("", contact("stiffness=\"7e7\""), 1, of_all));
  EXPECT_DOUBLE_EQ(given(scene, "cube"), k);
  EXPECT_DOUBLE_EQ(given(scene, "slab"), 7e7);
  EXPECT_NE(sceneText(scene).find("the scene's material: E 3e+08 Pa"), std::string::npos) << sceneText(scene);
  const TemporaryFiles files;
  files.write("cube.urdf", cubeOnSlab("", ""));
  const SceneDef listed = loadScene(files.write("s.yaml", "material: {material: wood}\nmodels:\n  - {file: cube.urdf}\n"));
  EXPECT_DOUBLE_EQ(given(listed, "cube"), surfaceStiffness(1.2e10, 0.30, 0.1));
}

TEST(Stiffness, BadInputGetsOneLine) {
  const auto refused = [](const std::string& inside) { return refusal(cubeOnSlab(contact(inside), "")); };
  for (const char* twice : {"stiffness=\"1e6\" young_modulus=\"1e9\"", "stiffness=\"1e6\" material=\"steel\"",
                            "young_modulus=\"1e9\" material=\"steel\""}) {
    EXPECT_NE(refused(twice).find("give one of stiffness, young_modulus and material"), std::string::npos) << refused(twice);
  }
  EXPECT_NE(refused("material=\"cheese\"").find("known: steel"), std::string::npos) << refused("material=\"cheese\"");
  for (const char* bad : {"-1", "0", "inf", "nan"}) {
    EXPECT_NE(refused("young_modulus=\"" + std::string(bad) + "\""), "") << bad;
  }
  EXPECT_NE(refused("young_modulus=\"-1\"").find("young_modulus [Pa] is -1"), std::string::npos);
  EXPECT_EQ(refused("young_modulus=\"-1\"").find('\n'), std::string::npos);
}

// Nothing is said: bodies of any weight and size rest within a hundredth of their size, and a hand bears its pointer.
TEST(Stiffness, WithoutAWordBodiesRestWithinTheirShareAndAHandBearsThem) {
  const DeviceDef device = loadDevice(std::string(HAPTIC_SCENES) + "/../devices/spidar_g6x3r.yaml");
  for (const double mass : {0.01, 1.0, 8.0, 400.0}) {
    const SceneDef scene = load(cubeOnSlab("", "", mass), true);
    const double depth = restDepth(load(cubeOnSlab("", "", mass)));
    EXPECT_LT(depth, 1.001e-3) << mass << " kg";
    EXPECT_GT(depth, mass < 1 ? 0 : 0.97e-3) << mass << " kg";  // no stiffer than asked, nor softer than the default
    const HandCertificate c = certifyHand(scene.world, 0, {}, device);
    EXPECT_TRUE(c.holds()) << mass << " kg: " << c.text();
    EXPECT_NE(sceneText(scene).find("stiffness chosen"), std::string::npos);
  }
}

/// Deepest contact of a scene that has run for a while, and the speed that is left.
double deepest(const SceneDef& scene, int steps = 3000) {
  World world(scene.world);
  for (int i = 0; i < steps; ++i) world.step();
  double depth = 0;
  for (int i = 0; i < world.contactCount(); ++i) depth = std::max(depth, world.contact(i).depth);
  return depth;
}

std::string onWorld(const std::string& name, const std::string& type, const std::string& xyz) {
  return joint("on_" + name, type, "world", name, "", xyz);
}

std::string solid(const std::string& name, double mass, const std::string& geometry, double size) {
  const std::string I = std::to_string(mass * size * size / 6);
  return "<link name=\"" + name + "\"><inertial><mass value=\"" + std::to_string(mass) + "\"/><inertia ixx=\"" + I + "\" iyy=\"" + I +
         "\" izz=\"" + I + "\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial><collision><geometry>" + geometry +
         "</geometry></collision></link>\n";
}

bool tooDeep(const SceneDef& scene) { return mentions(scene.warnings, "of the least extent"); }

// 1 kg under anything: k (m + M) g / A is the depth in closed form, 1 % of 0.1 m is the bound.
TEST(Stiffness, WhatLiesBelowCarriesWhatLiesAbove) {
  for (const double top : {10.0, 60.0, 100.0, 1000.0, 10000.0}) {
    const SceneDef scene = load(robot("<link name=\"world\"/>" + boxLink("floor", 1, 2) + boxLink("low", 1) + boxLink("top", top) +
                                      onWorld("floor", "fixed", "0 0 -1") + onWorld("low", "floating", "0 0 0.05") +
                                      onWorld("top", "floating", "0 0 0.15")));
    const double depth = deepest(scene);
    EXPECT_LE(depth, 1e-3) << top;
    EXPECT_GT(depth, 0.97e-3) << top;  // no stiffer than asked
    EXPECT_FALSE(tooDeep(scene)) << sceneText(scene);
    EXPECT_TRUE(mentions(scene.notes, "at rest with the stiffnesses chosen: 2 contacts")) << sceneText(scene);
  }
}

// A cube of 10 mm and 10 g that a hand presses on with 2 N, twenty times its weight: 1 % of its size, as under its own.
TEST(Stiffness, WhatAHandPressesOnRestsAsDeepAsAsked) {
  const std::string text = robot("<link name=\"world\"/>" + boxLink("floor", 1, 2) + boxLink("small", 0.01, 0.01) +
                                 onWorld("floor", "fixed", "0 0 -1") + onWorld("small", "floating", "0 0 0.005"));
  for (const bool hand : {true, false}) {
    const SceneDef scene = load(text, hand);
    World world(scene.world);
    for (const PointerDef& pointer : scene.world.pointers) {
      ASSERT_NE(scene.world.articulations[pointer.articulation].name, "small");
    }
    world.applyWrench(world.linkIndex("small"), {{Vector3::Zero(), Vector3(0, 0, -2)}, Vector3::Zero(), false}, 10);
    for (int i = 0; i < 9000; ++i) world.step();
    const double depth = 0.005 - world.linkPose(world.linkIndex("small")).p.z();
    if (hand) {
      EXPECT_LE(depth, 1e-4);
      EXPECT_GT(depth, 0.7e-4) << "no stiffer than asked, the ball above it counted as if it stood there";
    } else {
      EXPECT_GT(depth, 1e-3) << "where no hand presses it need not bear that";
    }
  }
}

// A can on a plate of 0.1 mm: 1 % of the plate, not of the can.
TEST(Stiffness, AThinPlateCarriesACan) {
  const std::string plate = "<link name=\"plate\"><collision><geometry><box size=\"0.3 0.3 0.0001\"/></geometry></collision></link>\n";
  const std::string can = solid("can", 0.35, "<cylinder radius=\"0.033\" length=\"0.1\"/>", 0.07);
  const SceneDef scene = load(robot("<link name=\"world\"/>" + plate + can +
                                    onWorld("plate", "fixed", "0 0 -0.00005") + onWorld("can", "floating", "0 0 0.05")));
  EXPECT_LE(deepest(scene), 1e-6);
  World world(scene.world);
  for (int i = 0; i < 3000; ++i) world.step();
  EXPECT_NEAR(world.linkPose(world.linkIndex("can")).p.z(), 0.05, 1e-6);
}

// A plank on two blocks with all the load over one of them, which carries it all, on one of its edges at that.
TEST(Stiffness, ALoadOffTheCentreIsCarriedByTheSettledScene) {
  const SceneDef scene = load(robot("<link name=\"world\"/>" + boxLink("floor", 1, 2) + boxLink("left", 1) + boxLink("right", 1) +
                                    solid("plank", 1, "<box size=\"0.5 0.1 0.02\"/>", 0.3) + boxLink("load", 200, 0.1) +
                                    onWorld("floor", "fixed", "0 0 -1") + onWorld("left", "floating", "-0.2 0 0.05") +
                                    onWorld("right", "floating", "0.2 0 0.05") + onWorld("plank", "floating", "0 0 0.11") +
                                    onWorld("load", "floating", "0.17 0 0.17")));
  EXPECT_LE(deepest(scene), 1e-3);
  EXPECT_FALSE(tooDeep(scene)) << sceneText(scene);
}

TEST(Stiffness, WhatNoStiffnessCarriesIsAWarningWithTheDepth) {
  const std::string plate = "<link name=\"plate\"><collision><geometry><box size=\"0.3 0.3 0.00001\"/></geometry></collision></link>\n";
  const SceneDef scene = load(robot("<link name=\"world\"/>" + plate + solid("anvil", 5000, "<box size=\"0.1 0.1 0.1\"/>", 0.1) +
                                    onWorld("plate", "fixed", "0 0 -0.000005") + onWorld("anvil", "floating", "0 0 0.05")));
  // 49 kN on 0.01 m² at 1e12 N/m³: 4.9 µm of 10 µm.
  EXPECT_TRUE(mentions(scene.warnings, "0.0049 mm under 4.9e+04 N, 49 % of the least extent")) << sceneText(scene);
}

}  // namespace stiffness_test
}  // namespace haptic
