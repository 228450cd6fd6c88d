// Surfaces that are said to be rigid: how deep bodies sink in them, at rest and in a fall, and what a hand still bears.
#include <gtest/gtest.h>

#include <cmath>

#include "haptic_core/analysis/chosen_stiffness.h"
#include "haptic_core/analysis/hand_certificate.h"
#include "haptic_core/world/world.h"
#include "scene/stiffness_choice.h"
#include "temporary_files.h"

namespace haptic {
namespace rigid_test {

const std::string kRigidTag = "<haptic:contact stiffness=\"rigid\"/>", kRigidScene = "<haptic:scene>" + kRigidTag + "</haptic:scene>";

std::string boxOf(const std::string& name, double mass, const std::string& size, const std::string& contact = "") {
  const std::string m = std::to_string(mass), I = std::to_string(mass * 1e-3);
  return "<link name=\"" + name + "\"><inertial><mass value=\"" + m + "\"/><inertia ixx=\"" + I + "\" iyy=\"" + I + "\" izz=\"" + I +
         "\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial><collision><geometry><box size=\"" + size + "\"/></geometry>" + contact +
         "</collision></link>\n";
}

std::string onWorld(const std::string& name, const std::string& type, const std::string& xyz) {
  return joint("on_" + name, type, "world", name, "", xyz);
}

/// A floor whose top is z = 0, a cube of 0.1 m at a height, and a second body on it.
std::string tower(const std::string& scene, const std::string& of_floor, const std::string& of_cube, double mass, double top = 0,
                  double fall = 0) {
  const std::string above = std::to_string(0.05 + fall);
  return robot(scene + "<link name=\"world\"/>" + boxOf("floor", 1, "2 2 1", of_floor) + boxOf("cube", mass, "0.1 0.1 0.1", of_cube) +
               onWorld("floor", "fixed", "0 0 -0.5") + onWorld("cube", "floating", "0 0 " + above) +
               (top > 0 ? boxOf("top", top, "0.1 0.1 0.1") + onWorld("top", "floating", "0 0 0.15") : ""));
}

SceneDef load(const std::string& urdf, bool pointer = false) {
  SceneOptions options;
  options.add_pointer = pointer;
  return loadText(urdf, options);
}

struct Sunk {
  double rest, deepest;  ///< of the cube's lowest face below z = 0, over its size
};

Sunk sunk(const SceneDef& scene, int steps = 2000) {
  World world(scene.world);
  const int cube = world.linkIndex("cube");
  double deepest = 0, now = 0;
  for (int i = 0; i < steps; ++i) {
    world.step();
    now = (0.05 - world.linkPose(cube).p.z()) / 0.1;
    deepest = std::max(deepest, now);
  }
  EXPECT_LT(world.linkTwist(cube).linear.norm(), 1e-9);
  EXPECT_TRUE(world.report().finite);
  return {now, deepest};
}

// The floor says it, the cube says it, the scene says it: the pair is rigid, whatever lies on the cube.
TEST(Rigid, ABodySinksByAMillionthUnderAnyLoad) {
  for (const double mass : {1e-3, 0.1, 8.0, 400.0}) {
    for (const double top : {0.0, 1.0, 1000.0}) {
      for (const auto& [scene, floor, cube] : {std::tuple<std::string, std::string, std::string>{"", kRigidTag, ""},
                                               {"", "", kRigidTag}, {kRigidScene, "", ""}}) {
        const Sunk s = sunk(load(tower(scene, floor, cube, mass, top)));
        EXPECT_LE(s.rest, kRigidSink) << mass << " kg under " << top;
        EXPECT_GT(s.rest, 0) << mass << " kg under " << top;
      }
    }
  }
}

// It stops within v h/100: 14 µm at most, of which the damper takes more than half.
TEST(Rigid, ABodyThatFallsFromItsOwnHeightSinksByATenThousandth) {
  for (const double mass : {1e-3, 0.1, 8.0, 400.0}) {
    const Sunk s = sunk(load(tower(kRigidScene, "", "", mass, 0, 0.1)));
    EXPECT_LE(s.deepest, 1e-4) << mass;
    EXPECT_LE(s.rest, kRigidSink) << mass;
  }
}

// A rigid floor under a cushion of k: the layer of the cushion alone, 2k. The floor says it, its scene, or the list.
TEST(Rigid, ASoftBodyOnARigidOneIsSoftByItsOwnLayer) {
  const double k = 2e6, depth = 9.8 / (2 * k * 0.01) / 0.1;
  const std::string cushion = "<haptic:contact stiffness=\"2e6\"/>";
  const TemporaryFiles files;
  files.write("tower.urdf", tower("", "", cushion, 1));
  const std::string list = files.write("s.yaml", "material: {stiffness: rigid}\nmodels:\n  - {file: tower.urdf}\n");
  const SceneDef scenes[] = {load(tower("", kRigidTag, cushion, 1)), load(tower(kRigidScene, "", cushion, 1)), loadScene(list)};
  for (const SceneDef& scene : scenes) EXPECT_NEAR(sunk(scene).rest, depth, 1e-6 * depth) << &scene - scenes;
}

/// A slab 1 m thick, of weight W [N], on two ridges of 1 m. A ridge that is d deep in a flat side has d² · 1 m in common with it, 45° on
/// either side, and bears W/2 = k d² · 1 m.
struct OnRidges {
  explicit OnRidges(double W)
      : scene(load(robot(kRigidScene + "<link name=\"world\"/>" + boxOf("left", 1, "1 1 1") + boxOf("right", 1, "1 1 1") +
                         boxOf("slab", W / 9.8, "2 2 1") + onWorld("left", "fixed", ridge("-0.75")) +
                         onWorld("right", "fixed", ridge("0.75")) + onWorld("slab", "floating", "0 0 0.5")))) {
    World world(scene.world);
    for (int i = 0; i < 4000; ++i) world.step();
    EXPECT_TRUE(world.report().finite);
    depth = 0.5 - world.linkPose(world.linkIndex("slab")).p.z();
  }
  /// A box whose upper edge is along y at z = 0.
  static std::string ridge(const std::string& x) { return x + " 0 -0.7071067811865476\" rpy=\"0 0.7853981633974483 0"; }
  bool stiffened() const { return sceneText(scene).find("stiffened to") != std::string::npos; }

  SceneDef scene;
  double depth = 0;  ///< [m]
};

// On an edge there is no face: the flat sides' k would let 1 N sink by more than a hundred times the bound.
TEST(Rigid, WhatRestsOnAnEdgeIsStiffened) {
  const OnRidges light(1);
  EXPECT_TRUE(light.stiffened()) << sceneText(light.scene);
  EXPECT_FALSE(mentions(light.scene.warnings, "of the least extent")) << sceneText(light.scene);
  EXPECT_LE(light.depth, kRigidSink);
  EXPECT_GT(light.depth, 0);
}

// 10 kN ask for 5e15 N/m³, more than there may be: d = sqrt(W / (2 · 1e14 · 1 m)), which the warning names with three digits.
TEST(Rigid, WhatNoStiffnessHoldsOnAnEdgeIsAWarning) {
  const double W = 1e4, depth = std::sqrt(W / (2 * 1e14));
  const OnRidges heavy(W);
  EXPECT_TRUE(mentions(heavy.scene.warnings, "0.00707 mm under 5e+03 N, 0.000707 % of the least extent and not 0.0001 %"))
      << sceneText(heavy.scene);
  EXPECT_NEAR(heavy.depth, depth, 1e-3 * depth);
}

// Whoever loads a scene may say it of all surfaces, whatever their file says; a hand still bears them.
TEST(Rigid, ALoaderSaysItOfAll) {
  SceneOptions options;
  options.rigid = true;
  const std::string soft = "<haptic:contact stiffness=\"1e5\" tangential_stiffness=\"1e4\"/>";
  EXPECT_LE(sunk(loadText(tower("<haptic:scene><haptic:contact material=\"rubber\"/></haptic:scene>", soft, soft, 8, 100), options)).rest,
            kRigidSink);
}

// A scene that a program made: the lower one of two cubes carries both, the upper one itself.
TEST(Rigid, AProgramSaysItOfAll) {
  WorldDef def = load(tower("", "", "<haptic:contact stiffness=\"1e5\"/>", 3, 3e3)).world;
  makeRigid(def);
  const double g = def.settings.gravity.norm(), side = 0.1 * 0.1, at_rest = 3003 * g / (side * kRigidSink * 0.1);
  for (const ArticulationDef& body : def.articulations) {
    const ContactMaterial& m = body.links[0].collisions[0].material;
    EXPECT_TRUE(m.rigid());
    if (body.name == "cube") { EXPECT_NEAR(m.rigid_stiffness / at_rest, 1.03, 1e-3) << "the choice has that margin"; }
    if (body.name == "top") { EXPECT_NEAR(m.rigid_stiffness / at_rest, 1.03 * 3000 / 3003, 1e-3); }
  }
  World world(def);
  for (int i = 0; i < 100; ++i) world.step();
  EXPECT_LE((0.05 - world.linkPose(world.linkIndex("cube")).p.z()) / 0.1, kRigidSink);
}

TEST(Rigid, AHandBearsWhatIsRigid) {
  const DeviceDef device = loadDevice(std::string(HAPTIC_SCENES) + "/../devices/spidar_g6x3r.yaml");
  const SceneDef scene = load(tower(kRigidScene, kRigidTag, kRigidTag, 1), true);
  const HandCertificate c = certifyHand(scene.world, 0, {}, device);
  EXPECT_TRUE(c.holds()) << c.text();
}

TEST(Rigid, FilesSayItAndListingsShowIt) {
  const auto stiffness = [](const SceneDef& scene, const char* link) {
    for (const CollisionReport& report : scene.collisions) {
      if (report.link == link) return report.material.stiffness;
    }
    return 0.0;
  };
  for (const char* tag : {"<haptic:contact><haptic:stiffness value=\"rigid\"/></haptic:contact>",
                          "<haptic:contact><stiffness>rigid</stiffness></haptic:contact>"}) {
    EXPECT_EQ(stiffness(load(tower("", "", tag, 1)), "cube"), ContactMaterial::kRigid) << tag;
  }
  const TemporaryFiles files;
  files.write("tower.urdf", tower("", "", "", 1));
  const SceneDef listed = loadScene(files.write("s.yaml", "material: {stiffness: rigid}\nmodels:\n  - {file: tower.urdf}\n"));
  EXPECT_TRUE(listed.world.settings.default_material.rigid());
  EXPECT_LE(sunk(listed).rest, kRigidSink);
  for (const SceneDef& scene : {listed, load(tower("", "", kRigidTag, 1))}) {
    EXPECT_NE(sceneText(scene).find("(rigid)"), std::string::npos) << sceneText(scene);
    EXPECT_NE(sceneText(scene).find("or as a step resolves"), std::string::npos) << sceneText(scene);
  }
}

TEST(Rigid, BadInputGetsOneLine) {
  for (const char* word : {"hard", "Rigid", "inf", "nan"}) {
    const std::string said = refusal(tower("", "", "<haptic:contact stiffness=\"" + std::string(word) + "\"/>", 1));
    EXPECT_NE(said.find("give a finite number > 0 in N/m³, or rigid"), std::string::npos) << said;
    EXPECT_EQ(said.find('\n'), std::string::npos);
  }
  const std::string twice = refusal(tower("", "", "<haptic:contact stiffness=\"rigid\" material=\"steel\"/>", 1));
  EXPECT_NE(twice.find("give one of stiffness, young_modulus and material"), std::string::npos) << twice;
  EXPECT_NE(refusal(tower("", "", "<haptic:contact damping=\"rigid\"/>", 1)), "");
  const TemporaryFiles files;
  const std::string model = files.write("tower.urdf", tower("", "", "", 1));
  const std::string listed = refusal("material: {stiffness: hard}\nmodels:\n  - {file: " + model + "}\n", {}, "s.yaml");
  EXPECT_NE(listed.find("give a finite number > 0 in N/m³, or rigid"), std::string::npos) << listed;
}

}  // namespace rigid_test
}  // namespace haptic
