/// Texts of files as strangers write them: a file loads or is refused in one line, in UTF-8, whatever its
/// attributes and texts say.
#include "odd_texts.h"

#include <gtest/gtest.h>

#include <cmath>

#include "haptic_core/base/plain_text.h"
#include "haptic_core/world/world.h"
#include "temporary_files.h"

namespace haptic {
namespace odd_texts_test {

SceneOptions withoutMeshes() {
  SceneOptions options;
  options.default_density = 1000;
  options.missing = MissingMeshes::kSkip;
  return options;
}

/// All that a file makes others print or send: it must be a line that every program can show.
std::vector<std::string> linesAndNames(const SceneDef& scene) {
  std::vector<std::string> all = scene.notes;
  for (const auto* lines : {&scene.warnings, &scene.replaced})
    all.insert(all.end(), lines->begin(), lines->end());
  all.push_back(scene.world.name);
  for (const ArticulationDef& tree : scene.world.articulations) {
    all.push_back(tree.name);
    for (const LinkDef& link : tree.links) {
      all.insert(all.end(), {link.name, link.joint.name});
      for (const CollisionDef& collision : link.collisions) all.push_back(collision.name);
      for (const MergedLink& merged : link.merged) all.push_back(merged.name);
    }
  }
  for (const VisualDef& visual : scene.visuals) all.insert(all.end(), {visual.name, visual.mesh_uri});
  for (const SensorDef& sensor : scene.world.sensors) all.push_back(sensor.name);
  return all;
}

/// The line of a refusal; empty: it loads. A world of it can be made.
std::string tryText(const std::string& text) {
  SceneOptions options = withoutMeshes();
  options.text = text;
  try {
    const SceneDef scene = loadScene("odd", options);
    for (const std::string& line : linesAndNames(scene)) EXPECT_EQ(plainText(line), line);
    EXPECT_EQ(validUtf8(scene.text), scene.text);
    World world(scene.world);
  } catch (const SetupError& error) {
    EXPECT_EQ(plainText(error.what()), error.what());
    EXPECT_LT(std::string(error.what()).size(), 2 * SetupError::kLongest);
    return error.what();
  }
  return "";
}

TEST(OddTexts, RobotOfAllElementsLoads) {
  SceneOptions options = withoutMeshes();
  options.text = robotOfAllElements();
  options.add_pointer = false;
  const SceneDef scene = loadScene("all", options);
  const std::array<float, 4> red{1, 0, 0, 1}, green{0, 1, 0, 1}, blue{0, 0, 1, 1};
  ASSERT_EQ(scene.visuals.size(), 4u);  // the mesh is not there
  EXPECT_EQ(scene.visuals[0].colour, red);
  EXPECT_EQ(scene.visuals[1].colour, green);
  EXPECT_EQ(scene.visuals[2].colour, blue);
  EXPECT_EQ(scene.visuals[3].colour, blue);
  double top = 0;  // of the capsule: half of its length and its radius
  for (const Vector3& corner : scene.visuals[1].corners) top = std::max(top, corner.z());
  EXPECT_NEAR(top, 0.05 + 0.02, 0.03 * 0.02);  // facets of its ends, 3 % of the radius
  EXPECT_EQ(scene.world.sensors.size(), 3u);
  EXPECT_TRUE(World(scene.world).report().finite);
}

TEST(OddTexts, LoadOrAreRefusedInOneLine) {
  const OddPlaces places(robotOfAllElements());
  ASSERT_GT(places.spans.size(), 180u);
  int refused = 0;
  const std::size_t count = 2 * places.spans.size();
  for (std::size_t i = 0; i < count; ++i) {
    // Strides through places and texts, so that each place meets texts of several kinds.
    const std::string text = oddFile(places, i + i / places.spans.size() * 41 * places.spans.size());
    SCOPED_TRACE("file " + std::to_string(i));
    refused += !tryText(text).empty();
  }
  EXPECT_GT(refused, static_cast<int>(count) / 10);
  EXPECT_LT(refused, static_cast<int>(count));
}

// Beside this moment every other of the robot is rounding: what stood in for them did so too, and was replaced without end. No robot has
// it, and the mass is spread over the link's shapes.
TEST(OddTexts, InertiaThatDwarfsAllOthersIsReplaced) {
  std::string text = robotOfAllElements();
  const std::string given = "<mass value=\"0.1\"/><inertia ixx=\"1e-4\" iyy=\"1e-4\"";
  text.replace(text.find(given), given.size(), "<mass value=\"0.1\"/><inertia ixx=\"1e-4\" iyy=\"18446744073709551616\"");
  EXPECT_EQ(tryText(text), "");
}

// A name and a colour that the parser of URDF printed as formats: the process ended.
TEST(OddTexts, FormatInColour) {
  const std::string text =
      "<robot name=\"r\"><link name=\"b\"/><material name=\"m\"><color "
      "rgba=\"%s%s%n\"/></material></robot>\n";
  const SceneDef scene = loadText(text);
  EXPECT_TRUE(mentions(scene.warnings, ":1: material 'm': rgba=\"%s%s%n\" is not four finite numbers"));
}

TEST(OddTexts, FormatsInNames) {
  const std::string text = robot(
      "<material name=\"%s%n\"/><link name=\"%s%s%n/ 'a'\"><visual><geometry><box size=\"1 1 "
      "1\"/></geometry><material name=\"%n%s\">"
      "<color rgba=\"1 %n 1\"/><texture filename=\"%s%n\"/></material></visual></link>" +
      boxLink("%p") + joint("%n%n", "revolute", "%s%s%n/ 'a'", "%p"));
  const SceneDef scene = loadText(text);
  EXPECT_EQ(scene.world.articulations[0].links[1].name, "%p");
  EXPECT_EQ(scene.world.articulations[0].links[1].joint.name, "%n%n");
  EXPECT_TRUE(mentions(scene.warnings, "material '%n%s'"));
}

TEST(OddTexts, NamesAreOneLineOfUtf8) {
  SceneOptions options = withoutMeshes();
  options.text =
      "<robot name=\"r\n1\"><link name=\"M\xfcller\"/><link name=\"a&#10;b&#1;c\"/>"
      "<joint name=\"&#xD800;\" type=\"fixed\"><parent link=\"M\xfcller\"/><child "
      "link=\"a&#10;b&#1;c\"/></joint></robot>";
  const SceneDef scene = loadScene("names", options);
  EXPECT_EQ(scene.world.articulations[0].name, "r 1");
  EXPECT_EQ(scene.world.articulations[0].links[0].name, "Müller");
  EXPECT_EQ(scene.world.articulations[0].links[0].merged[0].name, "a b c");
  EXPECT_TRUE(mentions(scene.warnings, "names:2: has bytes that are no UTF-8"));
  EXPECT_TRUE(mentions(scene.warnings, "names:2: <link> has control characters in name"));
}

TEST(OddTexts, LongNamesAreRefused) {
  EXPECT_EQ(refusal(robot(boxLink(std::string(256, 'a')))), "");
  EXPECT_NE(refusal(robot(boxLink(std::string(257, 'a'))))
                .find(":3: <link>: its name has 257 bytes; write at most 256"),
            std::string::npos);
}

// The parser alone takes a minute for these attributes, and reading joints a time quadratic in the links.
TEST(OddTexts, HugeElementsAreRefusedBeforeTheyAreRead) {
  std::string attributes, depth, links;
  for (int i = 0; i < 200000; ++i) {
    attributes += " a" + std::to_string(i) + "='>'";
    depth += "<a>";
    links += "<link name=\"l" + std::to_string(i) + "\"/>";
  }
  const auto refused = [](const std::string& text, const std::string& words) {
    const std::string message = tryText(text);
    EXPECT_NE(message.find(words), std::string::npos) << message;
  };
  refused("<!-- <a b='' -->\n<robot name=\"r\">\n<link name=\"b\"" + attributes + "/></robot>",
          "odd:3: an element has more than 100 attributes");
  refused("<robot name=\"r\">" + depth, "nested too deeply");
  refused("<robot name=\"r\">\n" + links + "</robot>",
          "odd:2: is one link more than the 2000 that are allowed");
}

TEST(OddTexts, EntitiesAreNotExpanded) {
  const std::string bomb =
      "<!DOCTYPE r [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\"><!ENTITY x SYSTEM "
      "\"file:///etc/passwd\">]>\n<robot name=\"r\"><link name=\"&b;&x;\"/></robot>";
  const std::string said = tryText(bomb);
  EXPECT_TRUE(said.empty() || said.find("malformed") != std::string::npos) << said;
}

}  // namespace odd_texts_test
}  // namespace haptic
