/// <haptic:motion> and <haptic:belt>: what they become, and what is refused in one line with file and line.
#include <gtest/gtest.h>

#include "haptic_core/world/led_motion.h"
#include "haptic_core/world/world.h"
#include "temporary_files.h"

namespace haptic {
namespace motion_test {

const char kHead[] = "<link name=\"world\"/>\n";

/// A platform on a floating joint, in which a plate is fixed 0.1 m above, and the tag.
std::string scene(const std::string& tag, const std::string& joint_type = "floating") {
  return robot(kHead + boxLink("platform", 2, 0.2) + joint("free", joint_type, "world", "platform", "", "0.5 0 1") +
               boxLink("plate", 1, 0.1) + joint("held", "fixed", "platform", "plate", "", "0 0 0.1") + tag + "\n");
}

struct Case {
  std::string load() {
    path = files.write("s.urdf", text);
    try {
      loaded = loadScene(path, options());
    } catch (const SetupError& error) {
      return error.what();
    }
    return "";
  }
  static SceneOptions options() {
    SceneOptions o;
    o.add_pointer = false;
    return o;
  }
  std::string text;
  TemporaryFiles files;
  std::string path;
  SceneDef loaded;
};

TEST(Motion, AFileLeadsTheNamedFrame) {
  Case c;
  c.files.write("way.csv",
                "# platform\ntime, x, y, z, roll, pitch, yaw\n0, 1, 2, 3, 0, 0, 0\n1, 1.5, 2, 3, 0, 0, 1\n2, 2, 2, 3, 0, 0, 2\n");
  c.text = scene("<haptic:motion link=\"plate\" file=\"way.csv\"/>");
  ASSERT_EQ(c.load(), "");
  ASSERT_EQ(c.loaded.world.motions.size(), 1u);
  World world(c.loaded.world);
  EXPECT_EQ(world.motion(0).name, "plate");
  // The plate is 0.1 m above the platform's origin, along the platform's z.
  EXPECT_LT((world.linkPose(0).p - Vector3(1, 2, 2.9)).norm(), 1e-14);
  while (world.time() < 0.9995) world.step();
  EXPECT_LT((world.linkPose(0).p - Vector3(1.5, 2, 2.9)).norm(), 1e-9);
  EXPECT_NEAR(world.linkTwist(0).angular.z(), 1, 1e-9);
  EXPECT_NEAR(world.linkTwist(0).linear.x(), 0.5, 1e-9);
  EXPECT_NE(sceneText(c.loaded).find("plate is led along 3 poses from 0 to 2 s"), std::string::npos);
}

TEST(Motion, WithoutAnglesTheBodyKeepsItsTurn) {
  Case c;
  c.files.write("way.csv", "time,x,y,z\n0,0,0,1\n1,1,0,1\n");
  c.text = robot(kHead + boxLink("platform", 2, 0.2) +
                 "<joint name=\"free\" type=\"floating\"><origin xyz=\"0 0 0\" rpy=\"0 0 0.4\"/><parent link=\"world\"/>"
                 "<child link=\"platform\"/></joint>\n<haptic:motion link=\"platform\" file=\"way.csv\"/>\n");
  ASSERT_EQ(c.load(), "");
  World world(c.loaded.world);
  EXPECT_LT((world.linkPose(0).R - rotationAbout(Vector3::UnitZ(), 0.4)).norm(), 1e-14);
}

TEST(Motion, TopicsAndFramesAreLeftToTheNode) {
  Case c;
  c.text = scene("<haptic:motion link=\"plate\" topic=\"lift\"/>");
  ASSERT_EQ(c.load(), "");
  ASSERT_EQ(c.loaded.told_motions.size(), 1u);
  EXPECT_EQ(c.loaded.told_motions[0].topic, "lift");
  EXPECT_LT((c.loaded.told_motions[0].X_FL.p - Vector3(0, 0, -0.1)).norm(), 1e-15);
  c.text = scene("<haptic:motion link=\"platform\" tf=\"hand\"/>");
  ASSERT_EQ(c.load(), "");
  EXPECT_EQ(c.loaded.told_motions[0].frame, "hand");
  World world(c.loaded.world);
  const Pose start = world.linkPose(0);
  for (int i = 0; i < 100; ++i) world.step();
  EXPECT_EQ(world.linkPose(0).p, start.p) << "it stands until it is told";
}

TEST(Motion, BadOnesNameFileAndLine) {
  const auto way = [](const std::string& rows, const std::string& attributes = "") {
    Case c;
    c.files.write("way.csv", rows);
    c.text = scene("<haptic:motion link=\"platform\" file=\"way.csv\" " + attributes + "/>");
    return c.load();
  };
  const auto tag = [](const std::string& attributes, const std::string& joint_type = "floating") {
    Case c;
    c.text = scene("<haptic:motion " + attributes + "/>", joint_type);
    return c.load();
  };
  const std::string head = "time,x,y,z,roll,pitch,yaw\n";
  const std::pair<std::string, std::vector<std::string>> cases[] = {
      {way("0,0,0,0\n"), {"way.csv:1", "no head line", "time,x,y,z,roll,pitch,yaw"}},
      {way("time,x,z\n0,0,0\n"), {"way.csv:1", "other columns"}},
      {way(head + "0,0,0,0,0,0\n"), {"way.csv:2", "6 columns, the head 7"}},
      {way(head + "0,0,nan,0,0,0,0\n"), {"way.csv:2", "column 3"}},
      {way(head + "1,0,0,0,0,0,0\n1,0,0,0,0,0,0\n"), {"way.csv:3", "does not rise"}},
      {way(head + "0,0,0,0,0,0,0\n\n1,0,0,0,3.1,0,0\n"), {"way.csv:4", "3 rad"}},
      {way(head), {"way.csv", "no row"}},
      {way("time,x,y,z\n0,0,0,0\n1,1,0,0\n2,0.1,0,0\n", "repeat=\"true\""), {"way.csv:4", "close the path"}},
      {way("time,x,y,z\n0,0,0,0\n1,1,0,0\n", "repeat=\"yes\""), {"s.urdf:8", "true or false"}},
      {tag("link=\"platform\" file=\"none.csv\""), {"s.urdf:8", "none.csv", "not found"}},
      {tag("link=\"nothing\" topic=\"t\""), {"s.urdf:8", "'nothing' does not exist"}},
      {tag("link=\"platform\""), {"s.urdf:8", "0 sources"}},
      {tag("link=\"platform\" topic=\"t\" tf=\"f\""), {"s.urdf:8", "2 sources"}},
      {tag("link=\"platform\" topic=\"t\" repeat=\"true\""), {"s.urdf:8", "repeats what is told"}},
      {tag("link=\"platform\" speed=\"1\" topic=\"t\""), {"s.urdf:8", "speed"}},
      {tag("link=\"platform\" topic=\"t\"", "fixed"), {"s.urdf:8", "hangs on joints or is fixed"}},
  };
  for (const auto& [message, words] : cases) {
    EXPECT_EQ(message.find('\n'), std::string::npos);
    for (const std::string& word : words) EXPECT_NE(message.find(word), std::string::npos) << word << " in: " << message;
  }
  Case twice;
  twice.text = scene("<haptic:motion link=\"platform\" topic=\"a\"/>\n<haptic:motion link=\"plate\" topic=\"b\"/>");
  EXPECT_NE(twice.load().find("s.urdf:9"), std::string::npos);
}

TEST(Belt, IsGivenInTheFrameOfItsLinkAlsoWhereThatIsMerged) {
  Case c;
  c.text = robot(kHead + boxLink("base", 1, 0.5) + joint("b", "fixed", "world", "base", "", "0 0 0") +
                 boxLink("belt", 1, 0.1, "<haptic:belt velocity=\"0.5 0 0\" spin=\"0 0 2\"/>") +
                 "<joint name=\"f\" type=\"fixed\"><origin xyz=\"1 0 0\" rpy=\"0 0 1.5707963267948966\"/><parent link=\"base\"/>"
                 "<child link=\"belt\"/></joint>\n" +
                 boxLink("box", 1, 0.1) + joint("free", "floating", "world", "box", "", "0 0 2"));
  ASSERT_EQ(c.load(), "");
  const LinkDef& base = c.loaded.world.articulations[0].links[0];
  ASSERT_EQ(base.collisions.size(), 2u);
  EXPECT_FALSE(base.collisions[0].belt.moves());
  const Twist& V = base.collisions[1].belt.V_L;
  EXPECT_LT((V.angular - Vector3(0, 0, 2)).norm(), 1e-14);
  // At the belt's own origin, 1 m along x in the base, it runs along the base's y.
  EXPECT_LT((V.shifted(Vector3(1, 0, 0)).linear - Vector3(0, 0.5, 0)).norm(), 1e-14);
}

TEST(Belt, BadOnesNameFileAndLine) {
  const auto problem = [](const std::string& tag) {
    Case c;
    c.text = robot(kHead + boxLink("belt", 1, 0.1, tag) + joint("f", "fixed", "world", "belt", "", "0 0 0"));
    return c.load();
  };
  for (const auto& [tag, word] : {std::pair{"<haptic:belt/>", "says nothing"}, {"<haptic:belt velocity=\"1\"/>", "velocity"},
                                  {"<haptic:belt speed=\"1\"/>", "speed"},
                                  {"<haptic:belt velocity=\"1 0 0\"/><haptic:belt spin=\"1 0 0\"/>", "twice"}}) {
    const std::string message = problem(tag);
    EXPECT_NE(message.find("s.urdf:4"), std::string::npos) << message;
    EXPECT_NE(message.find(word), std::string::npos) << message;
  }
}

}  // namespace motion_test
}  // namespace haptic
