/// <haptic:force>: what it becomes, and what is refused in one line with file and line.
#include <gtest/gtest.h>

#include <cmath>

#include "haptic_core/world/world.h"
#include "scene/scene_bodies.h"
#include "temporary_files.h"

namespace haptic {
namespace force_test {

/// Two bodies on floating joints, the second with a plate fixed 0.1 m above, and the tag.
std::string scene(const std::string& tag) {
  return robot(std::string("<link name=\"world\"/>\n") + boxLink("one", 2, 0.2) + joint("free1", "floating", "world", "one", "", "0 0 1") +
               boxLink("two", 2, 0.2) + joint("free2", "floating", "world", "two", "", "1 0 1") + boxLink("plate", 1, 0.1) +
               joint("held", "fixed", "two", "plate", "", "0 0 0.1") + tag + "\n");
}

struct Case {
  std::string load(const std::string& tag) {
    SceneOptions options;
    options.add_pointer = false;
    try {
      loaded = loadScene(files.write("s.urdf", scene(tag)), options);
    } catch (const SetupError& error) {
      return error.what();
    }
    return "";
  }
  TemporaryFiles files;
  SceneDef loaded;
};

TEST(Force, ASpringJoinsTheNamedFrames) {
  Case c;
  ASSERT_EQ(c.load("<haptic:force type=\"spring\" link1=\"one\" link2=\"plate\" xyz=\"0.1 0 0\" xyz2=\"0 0 0.2\" stiffness=\"50\" "
                   "rest_length=\"0.3\" most=\"7\"/>"), "");
  World world(c.loaded.world);
  ASSERT_EQ(world.forceCount(), 1);
  const LinkForce force = world.force(0);
  EXPECT_LT((force.p_WA - Vector3(0.1, 0, 1)).norm(), 1e-15);
  EXPECT_LT((force.p_WB - Vector3(1, 0, 1.3)).norm(), 1e-15);
  EXPECT_NEAR(force.onB().force.norm(), 7, 1e-15);
}

TEST(Force, WithoutLinksItActsFromTheWorldOnAllThatMoves) {
  Case c;
  ASSERT_EQ(c.load("<haptic:force type=\"viscous\" viscosity=\"2\" upper_z=\"5\"/>"), "");
  EXPECT_EQ(World(c.loaded.world).forceCount(), 2);
}

TEST(Force, GoesWithTheBodyThatItPulls) {
  Case c;
  ASSERT_EQ(c.load("<haptic:force type=\"spring\" link2=\"one\"/><haptic:force type=\"spring\" link2=\"two\" stiffness=\"3\"/>"), "");
  const SceneDef left = withoutModel(c.loaded, "one").scene;
  ASSERT_EQ(left.world.forces.size(), 1u);
  EXPECT_EQ(left.world.forces[0].parameter[kSpringStiffness], 3);
  EXPECT_EQ(World(left.world).forceCount(), 1);
}

TEST(Force, BadOnesAreRefused) {
  const std::pair<const char*, const char*> cases[] = {
      {"<haptic:force type=\"spring\" link2=\"one\" stiffness=\"-1\"/>", "stiffness is -1 N/m"},
      {"<haptic:force type=\"spring\" link2=\"one\" viscosity=\"1\"/>", "viscosity"},
      {"<haptic:force type=\"rope\" link2=\"one\"/>", "known: spring, viscous"},
      {"<haptic:force link2=\"one\"/>", "type"},
      {"<haptic:force type=\"spring\" link2=\"three\"/>", "'three' does not exist"},
      {"<haptic:force type=\"spring\" link1=\"one\" link2=\"world\"/>", "link2 is the world"},
  };
  for (const auto& [tag, said] : cases) {
    Case c;
    const std::string error = c.load(tag);
    EXPECT_NE(error.find(said), std::string::npos) << tag << " says: " << error;
    EXPECT_NE(error.find("s.urdf:"), std::string::npos) << error;
  }
}

}  // namespace force_test
}  // namespace haptic
