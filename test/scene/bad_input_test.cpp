/// Ill-formed files: refused in one line that names file, line, element and remedy, or mended with a warning.
#include <gtest/gtest.h>

#include <random>

#include "temporary_files.h"

namespace haptic {
namespace bad_input_test {

struct BadCase {
  const char* name;
  std::string text;
  std::vector<std::string> words;  ///< all must stand in the message
};

std::string inertial(const std::string& mass, const std::string& ixx, const std::string& iyy,
                     const std::string& izz) {
  return robot(boxLink("base") + "<link name=\"arm\"><inertial><mass value=\"" + mass +
               "\"/>\n<inertia ixx=\"" + ixx + "\" iyy=\"" + iyy + "\" izz=\"" + izz +
               "\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>\n" +
               joint("j", "revolute", "base", "arm"));
}

std::string twoLinks(const std::string& joint_inside, const std::string& type = "revolute") {
  return robot(boxLink("base") + boxLink("arm") + joint("j", type, "base", "arm", joint_inside));
}

std::string ground(const std::string& attributes) {
  return "<haptic:shape type=\"height_field\" " + attributes + "/>";
}

const char kLimit[] = "<limit lower=\"-1\" upper=\"1\" effort=\"10\" velocity=\"1\"/>";

std::vector<BadCase> badCases() {
  const std::string axis = "<axis xyz=\"0 0 1\"/>";
  return {
      {"empty file", "", {"empty"}},
      {"blank file", " \n\t\n", {"empty"}},
      {"no xml", "hello", {"robot.urdf"}},
      {"unclosed tag", "<robot name=\"r\">\n<link name=\"a\">\n</robot>", {"malformed", ":2", "not closed"}},
      {"two attributes of one name", "<robot name=\"r\"><link name=\"a\" name=\"b\"/></robot>", {}},
      {"other root", "<sdf version=\"1.6\"/>", {"<sdf>", "<robot>"}},
      {"some other root", "<model/>", {"<model>", "<robot>"}},
      {"no name", "<robot><link name=\"a\"/></robot>", {"name"}},
      {"no link", "<robot name=\"r\"></robot>", {"no link"}},
      {"xacro",
       "<robot name=\"r\" xmlns:xacro=\"x\">\n<xacro:property name=\"a\" value=\"1\"/><link "
       "name=\"a\"/></robot>",
       {":2", "xacro"}},
      {"link without name", robot("<link/>"), {":3", "name"}},
      {"half-space that moves",
       robot(boxLink("base") + boxLink("arm", 1, 0.1, "<haptic:shape type=\"half_space\"/>") +
             joint("j", "revolute", "base", "arm")),
       {":4", "'arm'", "half-space", "fixed to the world"}},
      {"unknown shape", robot(boxLink("a", 1, 0.1, "<haptic:shape type=\"plane\"/>")), {":3", "plane", "half_space"}},
      {"ellipsoid without radii", robot(boxLink("a", 1, 0.1, "<haptic:shape type=\"ellipsoid\"/>")), {":3", "'a'", "radii"}},
      {"flat ellipsoid",
       robot(boxLink("a", 1, 0.1, "<haptic:shape type=\"ellipsoid\" radii=\"1 0 1\"/>")), {":3", "'a'", "radius along y"}},
      {"cone without length", robot(boxLink("a", 1, 0.1, "<haptic:shape type=\"cone\" radius=\"1\"/>")), {":3", "'a'", "length"}},
      {"cone of a negative top",
       robot(boxLink("a", 1, 0.1, "<haptic:shape type=\"cone\" radius=\"1\" length=\"1\" top_radius=\"-1\"/>")),
       {":3", "'a'", "top radius"}},
      {"radii of a cone",
       robot(boxLink("a", 1, 0.1, "<haptic:shape type=\"cone\" radius=\"1\" length=\"1\" radii=\"1 1 1\"/>")),
       {":3", "radii", "ellipsoid"}},
      {"half-space as a mesh",
       robot("<link name=\"a\"><collision><geometry><mesh filename=\"a.stl\"/></geometry><haptic:shape "
             "type=\"half_space\"/></collision></link>"),
       {":3", "'a'", "half-space", "box"}},
      {"ground that moves",
       robot(boxLink("base") + boxLink("arm", 1, 0.1, ground("heights=\"0 0;0 0\" size=\"1 1\" thickness=\"1\"")) +
             joint("j", "revolute", "base", "arm")),
       {":4", "'arm'", "ground", "fixed to the world"}},
      {"ground without thickness", robot(boxLink("a", 1, 0.1, ground("heights=\"0 0;0 0\" size=\"1 1\""))), {":3", "'a'", "thickness"}},
      {"ground of no thickness",
       robot(boxLink("a", 1, 0.1, ground("heights=\"0 0;0 0\" size=\"1 1\" thickness=\"0\""))),
       {":3", "'a'", "thickness"}},
      {"ground without size", robot(boxLink("a", 1, 0.1, ground("heights=\"0 0;0 0\" thickness=\"1\""))), {":3", "'a'", "size"}},
      {"ground of no size",
       robot(boxLink("a", 1, 0.1, ground("heights=\"0 0;0 0\" size=\"1 -1\" thickness=\"1\""))),
       {":3", "'a'", "size", "> 0"}},
      {"one row of heights",
       robot(boxLink("a", 1, 0.1, ground("heights=\"0 0\" size=\"1 1\" thickness=\"1\""))),
       {":3", "'a'", "1 × 2", "at least 2 × 2"}},
      {"ragged heights",
       robot(boxLink("a", 1, 0.1, ground("heights=\"0 0; 0 0 0\" size=\"1 1\" thickness=\"1\""))),
       {":3", "row 2", "3 heights", "has 2"}},
      {"heights that are no numbers",
       robot(boxLink("a", 1, 0.1, ground("heights=\"0 0; 0 nan\" size=\"1 1\" thickness=\"1\""))),
       {":3", "row 2", "nan"}},
      {"no heights", robot(boxLink("a", 1, 0.1, ground("size=\"1 1\" thickness=\"1\""))), {":3", "'a'", "file"}},
      {"heights in a file that is not there",
       robot(boxLink("a", 1, 0.1, ground("file=\"no.txt\" size=\"1 1\" thickness=\"1\""))),
       {":3", "'a'", "no.txt", "not found"}},
      {"thickness of a cone",
       robot(boxLink("a", 1, 0.1, "<haptic:shape type=\"cone\" radius=\"1\" length=\"1\" thickness=\"1\"/>")),
       {":3", "thickness", "ground"}},
      {"ground of a box", robot(boxLink("a", 1, 0.1, "<haptic:shape type=\"ground\" thickness=\"1\"/>")), {":3", "'a'", "<box>", "<mesh>"}},
      {"link twice", robot(boxLink("a") + boxLink("a")), {":4", "'a'", "twice", "line 3"}},
      {"joint twice",
       robot(boxLink("a") + boxLink("b") + boxLink("c") + joint("j", "fixed", "a", "b") +
             joint("j", "fixed", "a", "c")),
       {"'j'", "twice"}},
      {"child twice",
       robot(boxLink("a") + boxLink("b") + boxLink("c") + joint("j", "fixed", "a", "b") +
             joint("k", "fixed", "c", "b")),
       {":7", "'k'", "'b'", "'j'"}},
      {"two roots", robot(boxLink("a") + boxLink("b")), {":4", "'b'", "second root", "'a'"}},
      {"loop of all",
       robot(boxLink("a") + boxLink("b") + joint("j", "revolute", "a", "b") +
             joint("k", "revolute", "b", "a")),
       {"loop", "haptic:loop"}},
      {"loop beside a root",
       robot(boxLink("r") + boxLink("a") + boxLink("b") + joint("j", "revolute", "a", "b") +
             joint("k", "revolute", "b", "a")),
       {"loop", "ancestor"}},
      {"own parent",
       robot(boxLink("a") + boxLink("b") + joint("j", "revolute", "a", "b") + joint("k", "fixed", "b", "b")),
       {"'k'"}},
      {"missing parent link", robot(boxLink("a") + joint("j", "revolute", "ghost", "a")), {"'j'", "'ghost'"}},
      {"no child",
       robot(boxLink("a") + "<joint name=\"j\" type=\"fixed\"><parent link=\"a\"/></joint>"),
       {"'j'", "child"}},
      {"unknown joint type", twoLinks(axis, "screw"), {"'j'", "screw", "revolute"}},
      {"two-number axis", twoLinks(std::string("<axis xyz=\"0 1\"/>") + kLimit), {"axis", "3 numbers"}},
      {"text for mass", inertial("heavy", "1", "1", "1"), {"mass", "heavy"}},
      {"mass of 1e-9 beside 1",
       robot("<link name=\"world\"/>" + boxLink("a", 1) + boxLink("b", 1) +
             "<link name=\"c\"><inertial><mass value=\"1e-9\"/><inertia ixx=\"1e-12\" iyy=\"1e-12\" "
             "izz=\"1e-12\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>" +
             joint("j", "floating", "world", "a", "", "0 0 1") +
             joint("k", "floating", "world", "b", "", "0 0 2") +
             joint("l", "floating", "world", "c", "", "0 0 3")),
       {"'c'", "1e-09"}},
      {"no inertia at all",
       robot("<link name=\"a\"/><link name=\"b\"><collision><geometry><box size=\"1 1 "
             "1\"/></geometry></collision></link>" +
             joint("j", "revolute", "a", "b")),
       {"'b'", "--default-density"}},
      {"mesh not found",
       robot("<link name=\"a\"><collision><geometry><mesh "
             "filename=\"package://none/x.stl\"/></geometry></collision></link>"),
       {"'a'", "package://none/x.stl", "package none is not here", "ROS_PACKAGE_PATH"}},
      {"no geometry",
       robot("<link name=\"a\"><collision><origin xyz=\"0 0 0\"/></collision></link>"),
       {"'a'", "geometry"}},
      {"unknown shape",
       robot("<link name=\"a\"><collision><geometry><torus radius=\"1\"/></geometry></collision></link>"),
       {"'a'", "torus"}},
      {"unknown haptic tag", robot("<haptic:glue/>" + boxLink("a")), {":3", "haptic:glue", "haptic:scene"}},
      {"haptic tag at the wrong place",
       robot(boxLink("a") + "<link name=\"b\"><haptic:contact stiffness=\"1\"/></link>" +
             joint("j", "fixed", "a", "b")),
       {"haptic:contact", "<link>"}},
      {"unknown contact attribute",
       robot(boxLink("a", 1, 0.1, "<haptic:contact stifness=\"1\"/>")),
       {"stifness", "stiffness"}},
      {"negative stiffness",
       robot(boxLink("a", 1, 0.1, "<haptic:contact stiffness=\"-1\"/>")),
       {"stiffness", "-1"}},
      {"nan stiffness",
       robot(boxLink("a", 1, 0.1, "<haptic:contact stiffness=\"nan\"/>")),
       {"stiffness", "finite"}},
      {"friction of 11", robot(boxLink("a", 1, 0.1, "<haptic:contact mu_static=\"11\"/>")), {"11", "10"}},
      {"dynamic above static friction",
       robot(boxLink("a", 1, 0.1, "<haptic:contact mu_static=\"0.1\" mu_dynamic=\"0.2\"/>")),
       {"mu_dynamic", "mu_static"}},
      {"step of 0", robot("<haptic:scene step=\"0\"/>" + boxLink("a")), {"step", "'0'"}},
      {"step of 1 s", robot("<haptic:scene step=\"1\"/>" + boxLink("a")), {"step", "'1'"}},
      {"accuracy of 0", robot("<haptic:scene accuracy=\"0\"/>" + boxLink("a")), {"accuracy", "'0'", "≤ 1"}},
      {"accuracy of 2", robot("<haptic:scene accuracy=\"2\"/>" + boxLink("a")), {"accuracy", "'2'"}},
      {"unknown scene setting", robot("<haptic:scene stepp=\"1\"/>" + boxLink("a")), {"stepp", "far_step"}},
      {"pointer to a ghost", robot("<haptic:pointer link=\"ghost\"/>" + boxLink("a")), {"ghost"}},
      {"pointer that is fixed", robot("<haptic:pointer link=\"a\"/>" + boxLink("a")), {"'a'", "fixed"}},
      {"filter with a ghost",
       robot("<haptic:collision_filter link1=\"a\" link2=\"ghost\"/>" + boxLink("a")),
       {"ghost"}},
      {"loop onto itself",
       robot("<haptic:loop link1=\"a\" link2=\"a\"/>" + boxLink("a")),
       {"haptic:loop", "one rigid body"}},
  };
}

TEST(BadInput, IsRefusedInOneLineThatNamesThePlace) {
  for (const BadCase& bad : badCases()) {
    SCOPED_TRACE(bad.name);
    const std::string message = refusal(bad.text);
    EXPECT_NE(message, "") << "was accepted";
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    for (const std::string& word : bad.words)
      EXPECT_NE(message.find(word), std::string::npos) << "no '" << word << "' in: " << message;
  }
}

TEST(BadInput, MissingFilesAndNames) {
  for (const char* name : {"", "/no/such/file.urdf", "no_such_scene", "/tmp", "nothing.yaml"}) {
    EXPECT_THROW(loadScene(name), SetupError) << name;
  }
  try {
    loadScene("no_such_scene", SceneOptions{0, "", {HAPTIC_SCENES}, true});
    FAIL();
  } catch (const SetupError& error) {
    EXPECT_NE(std::string(error.what()).find("touch_cube"), std::string::npos) << error.what();
  }
}

TEST(BadInput, MendedWithAWarning) {
  const struct {
    const char* text;
    std::string urdf;
  } cases[] = {
      {"no <axis", twoLinks(kLimit)},
      {"normalised", twoLinks(std::string("<axis xyz=\"0 0 2\"/>") + kLimit)},
      {"without <limit>", twoLinks("<axis xyz=\"0 0 1\"/>")},
      {"cannot move",
       twoLinks("<axis xyz=\"0 0 1\"/><limit lower=\"0\" upper=\"0\" effort=\"0\" velocity=\"0\"/>")},
      {"triangle inequality", inertial("1", "0.01", "0.01", "0.03")},
      {"has no <inertial>",
       robot(boxLink("a") + boxLink("b") + "<link name=\"c\"><collision><geometry><sphere radius=\"0.1\"/></geometry></collision></link>" +
             joint("j", "revolute", "a", "b") + joint("k", "revolute", "b", "c"))},
      {"xmlns:haptic", "<robot name=\"r\"><haptic:scene/>" + boxLink("a") + "</robot>"},
      {"integrator = 'sdirk2' is ignored", robot("<haptic:scene integrator=\"sdirk2\"/>" + boxLink("a"))},
      {"contact_model = 'point' is ignored", robot("<haptic:scene contact_model=\"point\"/>" + boxLink("a"))},
      {"no shape that can be drawn",
       robot("<link name=\"a\"><visual><geometry><torus/></geometry></visual></link>")},
  };
  for (const auto& mended : cases) {
    SCOPED_TRACE(mended.text);
    const SceneDef scene = loadText(mended.urdf);
    EXPECT_TRUE(mentions(scene.warnings, mended.text)) << sceneText(scene);
  }
}

TEST(BadInput, AMethodThatIsNamedChangesNothing) {
  const SceneDef named = loadText(robot("<haptic:scene integrator=\"symplectic_euler\" contact_model=\"volume\"/>" + boxLink("a")));
  EXPECT_EQ(named.world.settings.attempts, WorldSettings{}.attempts);
  EXPECT_EQ(named.warnings.size(), loadText(robot(boxLink("a"))).warnings.size() + 1) << sceneText(named);  // the volume is no news
}

TEST(BadInput, ASceneSaysHowExactItsStepsAre) {
  EXPECT_EQ(loadText(robot(boxLink("a"))).world.settings.accuracy, 0.03);
  EXPECT_EQ(loadText(robot("<haptic:scene accuracy=\"0.003\"/>" + boxLink("a"))).world.settings.accuracy, 0.003);
}

/// Damaged files end in a scene or in a SetupError, never otherwise. Deterministic: the generator is seeded.
TEST(BadInput, DamagedFilesNeverCrash) {
  const std::string sound =
      robot("<haptic:scene step=\"0.001\"/><haptic:pointer link=\"arm\"/>" + boxLink("base") +
            boxLink("arm", 1, 0.1, "<haptic:contact stiffness=\"1e6\"/>") +
            joint("j", "revolute", "base", "arm") + boxLink("tip") + joint("k", "prismatic", "arm", "tip"));
  ASSERT_EQ(refusal(sound), "");
  const std::vector<std::string> pieces = {"<",    ">",   "\"",       "/",     "&",
                                           "nan",  "-",   "1e999",    "<link", "</robot>",
                                           "<!--", "]]>", "\xff\xfe", "0",     "link=\"base\""};
  std::mt19937 random(7);
  int refused = 0;
  for (int i = 0; i < 1500; ++i) {
    std::string text = sound;
    for (int edits = 1 + static_cast<int>(random() % 4); edits > 0; --edits) {
      const std::size_t at = random() % text.size();
      switch (random() % 4) {
        case 0:
          text.erase(at, 1 + random() % 40);
          break;
        case 1:
          text.insert(at, pieces[random() % pieces.size()]);
          break;
        case 2:
          text[at] = static_cast<char>(random());
          break;
        default:
          text.insert(at, text.substr(random() % text.size(), random() % 80));
      }
      if (text.empty()) text = " ";
    }
    const std::string message = refusal(text);
    refused += !message.empty();
    ASSERT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_GT(refused, 500);  // the damage is real
}

TEST(BadInput, DeepNestingIsRefused) {
  std::string text = "<robot name=\"r\">";
  for (int i = 0; i < 5000; ++i) text += "<a>";
  EXPECT_NE(refusal(text), "");
}

TEST(BadInput, SceneLists) {
  const struct {
    const char* text;
    std::vector<std::string> words;
  } cases[] = {
      {"", {"empty"}},
      {"models: [", {"malformed"}},
      {"models: 3", {"no models"}},
      {"models:\n  - {file: ghost.urdf}\n", {":2", "ghost.urdf"}},
      {"models:\n  - {fil: a.urdf}\n", {":2", "'fil'", "file"}},
      {"modells: []\n", {"modells"}},
      {"- a\n- b\n", {"mapping"}},
      {"models:\n  - {file: ../x/robot.urdf, base: soft}\n", {}},
      {"models: [{file: a.urdf}]\nsettings: {step: nan}\n", {}},
  };
  for (const auto& bad : cases) {
    SCOPED_TRACE(bad.text);
    const std::string message = refusal(bad.text, {}, "scene.yaml");
    EXPECT_NE(message, "");
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    for (const std::string& word : bad.words)
      EXPECT_NE(message.find(word), std::string::npos) << "no '" << word << "' in: " << message;
  }
}

}  // namespace bad_input_test
}  // namespace haptic
