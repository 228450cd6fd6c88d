/// Numbers that cannot be right become the nearest sound ones, improbable ones are said: in one line with link or joint, tag and number.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "haptic_core/world/world.h"
#include "scene/number_bounds.h"
#include "temporary_files.h"

namespace haptic {
namespace sound_numbers_test {

const std::string kLimit = "<limit lower=\"-1\" upper=\"1\" effort=\"10\" velocity=\"1\"/>", kAxis = "<axis xyz=\"0 1 0\"/>";

std::string arm(const std::string& in_joint, const std::string& type = "revolute") {
  return robot(boxLink("base") + boxLink("arm") + joint("j", type, "base", "arm", in_joint));
}

/// An arm of 2 kg, 0.1 m wide, whose inertial is given.
std::string armOf(const std::string& inertial, const std::string& shape = "<box size=\"0.1 0.1 0.1\"/>", const std::string& origin = "") {
  return robot(boxLink("base") + "<link name=\"arm\"><inertial>" + inertial + "</inertial><collision>" + origin + "<geometry>" + shape +
               "</geometry></collision></link>\n" + joint("j", "revolute", "base", "arm", kAxis + kLimit));
}

std::string mass(const std::string& value) { return "<mass value=\"" + value + "\"/>"; }

std::string moments(const std::string& x, const std::string& y, const std::string& z) {
  return "<inertia ixx=\"" + x + "\" iyy=\"" + y + "\" izz=\"" + z + "\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>";
}

const std::string kMoments = moments("0.0033", "0.0033", "0.0033");
const std::string kSound = mass("2") + kMoments;

SceneDef load(const std::string& urdf) {
  SceneOptions options;
  options.add_pointer = false;
  return loadText(urdf, options);
}

struct OddCase {
  const char* name;
  std::string urdf;
  std::vector<std::string> words;  ///< all stand in one line
};

/// Exactly one line has all words; no other line is there.
void expectOneLine(const OddCase& odd, const std::vector<std::string>& lines, const SceneDef& scene) {
  SCOPED_TRACE(odd.name);
  int found = 0;
  for (const std::string& line : lines) {
    const auto has = [&](const std::string& word) { return line.find(word) != std::string::npos; };
    found += std::all_of(odd.words.begin(), odd.words.end(), has);
  }
  EXPECT_EQ(found, 1) << sceneText(scene);
  World world(scene.world);
  for (int i = 0; i < 20; ++i) world.step();
  EXPECT_TRUE(world.report().finite);
}

TEST(SoundNumbers, WhatCannotBeIsReplacedOrLeftOut) {
  const std::vector<OddCase> cases = {
      {"zero axis", arm("<axis xyz=\"0 0 0\"/>" + kLimit), {":5", "'j'", "<axis> xyz=\"0 0 0\"", "1 0 0"}},
      {"nan axis", arm("<axis xyz=\"0 nan 1\"/>" + kLimit), {"'j'", "<axis> xyz=\"0 nan 1\"", "1 0 0"}},
      {"infinite axis", arm("<axis xyz=\"0 inf 1\"/>" + kLimit), {"'j'", "<axis> xyz=\"0 inf 1\"", "1 0 0"}},
      {"limits upside down", arm(kAxis + "<limit lower=\"1\" upper=\"-1\" effort=\"1\" velocity=\"1\"/>"), {"'j'", "<limit> lower=\"1\"",
          "-1"}},
      {"nan limit", arm(kAxis + "<limit lower=\"nan\" upper=\"1\" effort=\"1\" velocity=\"1\"/>"), {"'j'", "lower=\"nan\"", "no limit"}},
      {"infinite limit", arm(kAxis + "<limit lower=\"-inf\" upper=\"1\" effort=\"1\" velocity=\"1\"/>"), {"'j'", "lower=\"-inf\"",
          "no limit"}},
      {"negative effort", arm(kAxis + "<limit lower=\"0\" upper=\"1\" effort=\"-1\" velocity=\"1\"/>"), {"'j'", "effort=\"-1\"", "1e6"}},
      {"infinite effort", arm(kAxis + "<limit lower=\"0\" upper=\"1\" effort=\"inf\" velocity=\"1\"/>"), {"'j'", "effort=\"inf\"", "1e6"}},
      {"negative velocity", arm(kAxis + "<limit lower=\"0\" upper=\"1\" effort=\"1\" velocity=\"-1\"/>"), {"'j'", "velocity=\"-1\"",
          "no limit"}},
      {"negative damping", arm(kAxis + kLimit + "<dynamics damping=\"-1\"/>"), {"'j'", "<dynamics> damping=\"-1\"", "0 is taken"}},
      {"nan friction", arm(kAxis + kLimit + "<dynamics friction=\"nan\"/>"), {"'j'", "friction=\"nan\"", "0 is taken"}},
      {"negative mass", armOf(mass("-1") + kMoments), {":4", "'arm'", "<mass> value=\"-1\"", "shapes"}},
      {"nan mass", armOf(mass("nan") + kMoments), {"'arm'", "<mass> value=\"nan\"", "shapes"}},
      {"no mass", armOf(kMoments), {"'arm'", "<inertial> has no mass", "shapes"}},
      {"no inertia", armOf(mass("2")), {"'arm'", "<inertial> has no <inertia>", "spread over its shapes"}},
      {"infinite moment", armOf(mass("2") + moments("1", "inf", "1")), {"'arm'", "<inertia> iyy=\"inf\"", "spread"}},
      {"negative moment", armOf(mass("2") + moments("0.0033", "0.0033", "-1e-5")), {"'arm'", "<inertia> izz=\"-1e-5\"", "spread"}},
      {"box of size 0", armOf(kSound, "<box size=\"0 0 0\"/>"), {"'arm'", "<box> size=\"0 0 0\"", "left out"}},
      {"flat box", armOf(kSound, "<box size=\"0.1 0.1 0\"/>"), {"'arm'", "size=\"0.1 0.1 0\"", "0.001 is taken"}},
      {"negative box", armOf(kSound, "<box size=\"0.1 -0.1 0.1\"/>"), {"'arm'", "size=\"0.1 -0.1 0.1\"", "is taken"}},
      {"nan box", armOf(kSound, "<box size=\"0.1 nan 0.1\"/>"), {"'arm'", "size=\"0.1 nan 0.1\"", "left out"}},
      {"ball of radius 0", armOf(kSound, "<sphere radius=\"0\"/>"), {"'arm'", "<sphere> radius=\"0\"", "left out"}},
      {"negative radius", armOf(kSound, "<cylinder radius=\"-0.1\" length=\"0.1\"/>"), {"'arm'", "<cylinder> radius=\"-0.1\"", "is taken"}},
      {"infinite length", armOf(kSound, "<capsule radius=\"0.1\" length=\"inf\"/>"), {"'arm'", "<capsule> length=\"inf\"", "left out"}},
      {"nan origin", armOf(kSound, "<box size=\"0.1 0.1 0.1\"/>", "<origin xyz=\"0 nan 0\"/>"), {"'arm'", "<origin> xyz=\"0 nan 0\"",
          "0 is taken"}},
      {"huge origin", armOf(kSound, "<box size=\"0.1 0.1 0.1\"/>", "<origin xyz=\"1e300 0 0\"/>"), {"'arm'", "<origin> xyz=\"1e300 0 0\""}},
      {"infinite angle", armOf(kSound, "<box size=\"0.1 0.1 0.1\"/>", "<origin rpy=\"inf 0 0\"/>"), {"'arm'", "<origin> rpy=\"inf 0 0\"",
          "0 is taken"}},
  };
  for (const OddCase& odd : cases) {
    const SceneDef scene = load(odd.urdf);
    expectOneLine(odd, scene.replaced, scene);
    EXPECT_EQ(scene.replaced.size(), 1u) << odd.name << "\n" << sceneText(scene);
  }
}

/// 1e6 N m, which takes the place of an effort that cannot be, is more than robots have.
TEST(SoundNumbers, WhatWasReplacedIsNotAccusedOnceMore) {
  for (const char* effort : {"-1", "inf"}) {
    const SceneDef scene = load(arm(kAxis + "<limit lower=\"0\" upper=\"1\" effort=\"" + effort + "\" velocity=\"1\"/>"));
    EXPECT_EQ(scene.replaced.size(), 1u) << effort;
    EXPECT_EQ(scene.warnings, std::vector<std::string>()) << effort << "\n" << sceneText(scene);
  }
}

TEST(SoundNumbers, WhatIsImprobableIsSaidWithItsNumber) {
  const auto limited = [](const std::string& lower, const std::string& upper, const std::string& effort, const std::string& velocity) {
    return arm(kAxis + "<limit lower=\"" + lower + "\" upper=\"" + upper + "\" effort=\"" + effort + "\" velocity=\"" + velocity + "\"/>");
  };
  const std::string on_table = robot(
      "<link name=\"base\"><collision><geometry><box size=\"1 1 1\"/></geometry></collision></link>\n<link name=\"arm\"><inertial>" +
      kSound + "</inertial><collision><geometry><box size=\"3 0.1 0.1\"/></geometry></collision></link>\n" +
      joint("j", "revolute", "base", "arm", kAxis + kLimit));
  const std::vector<OddCase> cases = {
      {"longer than its moments", on_table, {"'arm'", "<inertia>", "3.003 m large", "1.502"}},
      {"longer than all else", armOf(kSound, "<box size=\"20 0.1 0.1\"/>"), {"'arm'", "20 m large", "all the rest"}},
      {"a grain", armOf(kSound, "<box size=\"5e-4 0.1 0.1\"/>"), {"'arm'", "<box> size=\"5e-4 0.1 0.1\""}},
      {"a drive of thousandths", limited("-1", "1", "1e-3", "1"), {"'j'", "effort", "0.001"}},
      {"ixx of 1", armOf(mass("2") + moments("1", "1", "1")), {":4", "'arm'", "<inertia>", "1 kg m²", "more", "expected 0.003333"}},
      {"a billionth", armOf(mass("2") + moments("3e-12", "3e-12", "3e-12")), {"'arm'", "<inertia>", "3e-12", "less", "expected 0.003333"}},
      {"one moment", armOf(mass("2") + moments("3e-6", "0.0033", "0.0033")), {"'arm'", "<inertia>", "3e-06", "less"}},
      {"centre 50 m away", armOf("<origin xyz=\"50 0 0\"/>" + kSound), {"'arm'", "<origin>", "49.95 m away"}},
      {"a mass of iron tons", armOf(mass("2000") + moments("3.3", "3.3", "3.3")), {"'arm'", "<mass>", "2000 kg", "2e+06 kg/m³",
          "expected 1 kg"}},
      {"a feeble drive", limited("-1", "1", "1e-6", "1"), {"'j'", "effort", "1e-06"}},
      {"degrees", limited("-180", "1", "1", "1"), {"'j'", "<limit> lower=\"-180\"", "3.142 if it is in degrees"}},
      {"no way", limited("0", "1e-3", "1", "1"), {"'j'", "<limit> upper=\"1e-3\"", "too little"}},
      {"a slow drive", limited("-1", "1", "1", "1e-6"), {"'j'", "<limit> velocity=\"1e-6\""}},
      {"rpy in degrees", armOf(kSound, "<box size=\"0.1 0.1 0.1\"/>", "<origin rpy=\"0 90 0\"/>"), {"'arm'", "rpy=\"0 90 0\"", "1.571"}},
      {"millimetres", armOf(kSound, "<box size=\"100 100 100\"/>"), {"'arm'", "173.2 m large"}},
      {"tiny", armOf(kSound, "<box size=\"1e-5 0.1 0.1\"/>"), {"'arm'", "<box> size=\"1e-5 0.1 0.1\""}},
  };
  for (const OddCase& odd : cases) {
    const SceneDef scene = load(odd.urdf);
    expectOneLine(odd, scene.warnings, scene);
    EXPECT_TRUE(scene.replaced.empty()) << odd.name << "\n" << sceneText(scene);
  }
}

/// A box of 2 kg whose centre is 0.1 m from a horizontal axis: with effort 0 it falls, which is said with m g 0.1.
TEST(SoundNumbers, ADriveThatIsNoneAndMustCarryIsSaid) {
  const auto lever = [](const std::string& effort, const std::string& axis) {
    return load(robot(boxLink("base") + "<link name=\"arm\"><inertial><origin xyz=\"0.1 0 0\"/>" + kSound +
                      "</inertial><collision><origin xyz=\"0.1 0 0\"/><geometry>"
                      "<box size=\"0.1 0.1 0.1\"/></geometry></collision></link>\n" +
                      joint("j", "revolute", "base", "arm",
                            "<axis xyz=\"" + axis + "\"/><limit lower=\"-1\" upper=\"1\" effort=\"" + effort + "\" velocity=\"1\"/>")));
  };
  for (const char* none : {"0", "1e10"}) {
    const SceneDef scene = lever(none, "0 1 0");
    EXPECT_TRUE(mentions(scene.warnings, "must carry 1.96 N m")) << sceneText(scene);
    EXPECT_FALSE(mentions(lever(none, "0 0 1").warnings, "must carry"));  // nothing to carry about an upright axis
  }
  EXPECT_FALSE(mentions(lever("10", "0 1 0").warnings, "must carry"));
}

TEST(SoundNumbers, AFileThatIsRightHasNoLine) {
  for (const std::string& urdf : {armOf(kSound), arm(kAxis + kLimit), arm("<axis xyz=\"0 0 1\"/>" + kLimit
      + "<dynamics damping=\"0.1\" friction=\"0.2\"/>")}) {
    const SceneDef scene = load(urdf);
    EXPECT_TRUE(scene.warnings.empty() && scene.replaced.empty()) << sceneText(scene);
  }
}

TEST(SoundNumbers, MeshScalesAreMendedAndMirrorsAreSaid) {
  const TemporaryFiles files;
  std::string stl = "solid t\n";
  const Vector3 c[4] = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}};
  for (const auto& t : {std::array<int, 3>{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}) {
    stl += "facet normal 0 0 0\nouter loop\n";
    for (const int i : t) stl += "vertex " + std::to_string(c[i].x()) + " " + std::to_string(c[i].y()) + " " + std::to_string(c[i].z())
        + "\n";
    stl += "endloop\nendfacet\n";
  }
  files.write("t.stl", stl + "endsolid\n");
  const auto scaled = [&](const std::string& scale) {
    return loadScene(files.write("r.urdf", armOf(kSound, "<mesh filename=\"t.stl\" scale=\"" + scale + "\"/>")));
  };
  const struct {
    const char *scale, *taken;
  } mended[] = {{"0 0 0", "1 1 1"}, {"1 0 1", "1 1 1"}, {"nan 1 1", "1 1 1"}, {"0.5 inf 0.5", "0.5 0.5 0.5"}};
  for (const auto& each : mended) {
    const SceneDef scene = scaled(each.scale);
    ASSERT_EQ(scene.replaced.size(), 1u) << sceneText(scene);
    EXPECT_NE(scene.replaced[0].find("<mesh> scale=\"" + std::string(each.scale) + "\": " + each.taken), std::string::npos)
        << scene.replaced[0];
  }
  const SceneDef mirrored = scaled("1 -1 1");
  EXPECT_TRUE(mirrored.replaced.empty() && mirrored.warnings.empty()) << sceneText(mirrored);
  EXPECT_TRUE(mentions(mirrored.notes, "scale=\"1 -1 1\": the mesh is mirrored"));
}

std::string following(const std::string& mimic, const std::string& master = "revolute") {
  const std::string inside = master == "revolute" || master == "planar" ? kAxis + kLimit : "";
  return robot(boxLink("base") + boxLink("a") + boxLink("b") + joint("j_a", master, "base", "a", inside) +
               joint("j_b", "revolute", "base", "b", kAxis + kLimit + "<mimic joint=\"" + mimic + "/>", "0 1 1"));
}

TEST(Mimics, ThatCannotFollowMoveByThemselves) {
  const std::vector<OddCase> cases = {
      {"ghost", following("ghost\""), {"'j_b'", "'ghost'", "does not exist", "moves by itself"}},
      {"itself", following("j_b\""), {"'j_b'", "itself"}},
      {"fixed", following("j_a\"", "fixed"), {"'j_b'", "'j_a'", "does not move"}},
      {"planar", following("j_a\"", "planar"), {"'j_b'", "'j_a'", "only revolute"}},
      {"1e160", following("j_a\" multiplier=\"1e160\""), {"'j_b'", "<mimic> multiplier=\"1e160\""}},
      {"nan", following("j_a\" multiplier=\"nan\""), {"'j_b'", "<mimic> multiplier=\"nan\""}},
  };
  for (const OddCase& odd : cases) {
    const SceneDef scene = load(odd.urdf);
    expectOneLine(odd, scene.replaced, scene);
    for (const LinkDef& link : scene.world.articulations[0].links) EXPECT_LT(link.joint.mimic_joint, 0) << odd.name;
  }
  const SceneDef offset = load(following("j_a\" offset=\"inf\""));
  EXPECT_TRUE(mentions(offset.replaced, "<mimic> offset=\"inf\": 0 is taken")) << sceneText(offset);
}

/// A chain of followers multiplies: three of 1e3 are 1e9, whose square a leader's inertia does not survive.
TEST(Mimics, MultipliersOverOthersAreBoundedAsWell) {
  std::string links = boxLink("base"), joints;
  for (int i = 0; i < 4; ++i) {
    const std::string n = std::to_string(i), mimic = i ? "<mimic joint=\"j" + std::to_string(i - 1) + "\" multiplier=\"1000\"/>" : "";
    links += boxLink("l" + n);
    joints += joint("j" + n, "continuous", "base", "l" + n, kAxis + mimic, n + " 0 1");
  }
  const SceneDef scene = load(robot(links + joints));
  EXPECT_TRUE(mentions(scene.replaced, "joint 'j3' follows 'j0' over others, with a multiplier of 1e+09")) << sceneText(scene);
}

TEST(Mimics, AJointThatIsPutStaysAndItsFollowersGoWithIt) {
  World world(load(robot(boxLink("base") + boxLink("a") + boxLink("b") + boxLink("c") + joint("j_a", "revolute", "base", "a", kAxis
      + kLimit) +
                         joint("j_b", "revolute", "base", "b", kAxis + kLimit
                             + "<mimic joint=\"j_a\" multiplier=\"-1\" offset=\"0.02\"/>", "0 1 1") +
                         joint("j_c", "revolute", "base", "c", kAxis + kLimit
                             + "<mimic joint=\"j_b\" multiplier=\"0.5\" offset=\"0.01\"/>", "0 2 1")))
                  .world);
  const auto at = [&](const char* joint) { return world.joint(world.jointIndex(joint)).position; };
  world.setJointPositions({{world.jointIndex("j_a"), 0.3}});
  EXPECT_EQ(at("j_a"), 0.3);
  EXPECT_NEAR(at("j_b"), -0.28, 1e-15);
  EXPECT_NEAR(at("j_c"), -0.13, 1e-15);
  world.step();
  EXPECT_NEAR(at("j_a"), 0.3, 1e-3);
}

/// The table that users read has each bound that the loader asks.
TEST(SoundNumbers, TheTableForUsersHasTheBounds) {
  std::ifstream file(std::string(HAPTIC_SCENES) + "/README.md");
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto shortly = [](double number) {
    std::ostringstream out;
    out.precision(4);
    out << number;
    return out.str();
  };
  for (const NumberBounds& bounds : {kPlaceBounds, kAngleBounds, kMassBounds, kMomentBounds, kSizeBounds, kScaleBounds, kEffortBounds,
      kTurnSpeedBounds,
                                     kSlideSpeedBounds, kTurnLimitBounds, kSlideLimitBounds, kDampingBounds, kFrictionBounds,
                                         kMultiplierBounds,
                                     kOffsetBounds}) {
    const std::string row = std::string("| ") + bounds.name + " [" + bounds.unit + "] | " + shortly(bounds.least) + "…"
        + shortly(bounds.most) + " |";
    EXPECT_NE(text.find(row), std::string::npos) << row;
  }
}

}  // namespace sound_numbers_test
}  // namespace haptic
