/// Robots of the shapes that people publish load whole: humanoids, quadrupeds, grippers, meshes of all three
/// formats.
#include <gtest/gtest.h>

#include <cmath>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/world/world.h"
#include "temporary_files.h"

namespace haptic {
namespace published_robots_test {

const char kRevolute[] =
    "<axis xyz=\"0 1 0\"/><limit lower=\"-1\" upper=\"1\" effort=\"20\" velocity=\"5\"/><dynamics "
    "damping=\"0.1\"/>";

/// `limbs` limbs of `length` links each on a trunk; the last link of every limb carries a sensor frame.
std::string limbedRobot(int limbs, int length, bool floating) {
  std::string text = floating ? "<link name=\"origin\"/>" : "";
  text += boxLink("trunk", 10, 0.3);
  if (floating) text += joint("float", "floating", "origin", "trunk", "", "0 0 1");
  for (int limb = 0; limb < limbs; ++limb) {
    std::string parent = "trunk";
    for (int i = 0; i < length; ++i) {
      const std::string name = "limb" + std::to_string(limb) + "_" + std::to_string(i);
      text += boxLink(name, 0.5, 0.05);
      const double y = i == 0 ? 0.3 * (limb - 0.5 * (limbs - 1)) : 0;
      text += joint("j_" + name, i % 3 == 2 ? "continuous" : "revolute", parent, name, kRevolute,
                    "0 " + std::to_string(y) + " " + (i == 0 ? "-0.3" : "-0.2"));
      parent = name;
    }
    text += "<link name=\"sensor" + std::to_string(limb) + "\"/>" +
            joint("s" + std::to_string(limb), "fixed", parent, "sensor" + std::to_string(limb), "");
  }
  return robot(text);
}

TEST(PublishedRobots, HumanoidOfFortyJoints) {
  const SceneDef scene = loadText(limbedRobot(5, 8, true));
  EXPECT_EQ(scene.joints, 1 + 40 + 5);
  EXPECT_EQ(scene.collisions_loaded, scene.collisions_tried);
  EXPECT_EQ(scene.collisions_tried, 41);
  const ArticulationDef& body = scene.world.articulations.at(0);
  EXPECT_EQ(body.links.size(), 41u);
  EXPECT_EQ(body.links[0].joint.type, JointType::kFloating);
  int merged = 0;
  for (const LinkDef& link : body.links) merged += static_cast<int>(link.merged.size());
  EXPECT_EQ(merged, 5);
  const World world(scene.world);
  EXPECT_EQ(world.linkCount(), 42);  // and the pointer
}

TEST(PublishedRobots, QuadrupedAndGripperWithMimic) {
  EXPECT_EQ(loadText(limbedRobot(4, 3, true)).world.articulations[0].links.size(), 13u);
  const std::string slide =
      "<axis xyz=\"0 1 0\"/><limit lower=\"0\" upper=\"0.04\" effort=\"20\" velocity=\"1\"/>";
  const SceneDef gripper =
      loadText(robot(boxLink("palm", 1, 0.1) + boxLink("left", 0.1, 0.02) + boxLink("right", 0.1, 0.02) +
                     joint("jl", "prismatic", "palm", "left", slide, "0 0.03 0.08") +
                     joint("jr", "prismatic", "palm", "right",
                           slide + "<mimic joint=\"jl\" multiplier=\"-1\"/>", "0 -0.03 0.08")));
  EXPECT_EQ(gripper.world.articulations[0].links[2].joint.mimic_joint, 1);
  EXPECT_EQ(gripper.world.articulations[0].links[1].joint.drive, JointDef::Drive::kPosition);
  EXPECT_EQ(gripper.world.articulations[0].links[2].joint.drive, JointDef::Drive::kNone);  // it follows
  EXPECT_NO_THROW(World world(gripper.world));
}

/// Unknown vendors' tags beside and inside of links do not disturb.
TEST(PublishedRobots, VendorTagsAreLeftAlone) {
  std::string link = boxLink("a");
  link.insert(link.find("<inertial>"), "<self_collision_checking/><sensor name=\"s\" type=\"imu\"/>");
  const SceneDef scene =
      loadText(robot(
          link + "<transmission name=\"t\"><type>x</type></transmission><gazebo><plugin name=\"p\"/></gazebo>"
                 "<material name=\"m\"><color rgba=\"1 0 0 1\"/></material>"));
  EXPECT_EQ(scene.collisions_loaded, 1);
}

std::string tetrahedronObj() {
  return "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
}

std::string tetrahedronStl() {
  const double v[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const int f[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  std::string text = "solid t\n";
  for (const auto& face : f) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (int i : face) {
      text += "vertex " + std::to_string(v[i][0]) + " " + std::to_string(v[i][1]) + " " +
              std::to_string(v[i][2]) + "\n";
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid t\n";
}

std::string tetrahedronDae(const std::string& up, double metre) {
  return "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
         "version=\"1.4.1\"><asset><unit meter=\"" +
         std::to_string(metre) + "\" name=\"u\"/><up_axis>" + up +
         "</up_axis></asset><library_geometries><geometry id=\"g\" name=\"g\"><mesh><source "
         "id=\"p\"><float_array id=\"pa\" count=\"12\">"
         "0 0 0 1 0 0 0 1 0 0 0 1</float_array><technique_common><accessor source=\"#pa\" count=\"4\" "
         "stride=\"3\"><param name=\"X\" "
         "type=\"float\"/><param name=\"Y\" type=\"float\"/><param name=\"Z\" "
         "type=\"float\"/></accessor></technique_common></source>"
         "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles "
         "count=\"4\"><input semantic=\"VERTEX\" "
         "source=\"#v\" offset=\"0\"/><p>0 2 1 0 1 3 1 2 3 0 3 "
         "2</p></triangles></mesh></geometry></library_geometries>"
         "<library_visual_scenes><visual_scene id=\"s\"><node id=\"n\"><instance_geometry "
         "url=\"#g\"/></node></visual_scene>"
         "</library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";
}

std::string meshLink(const std::string& uri, const std::string& scale = "1 1 1") {
  return robot("<link name=\"a\"><collision><geometry><mesh filename=\"" + uri + "\" scale=\"" + scale +
               "\"/></geometry></collision></link>");
}

/// The unit tetrahedron has volume 1/6 and its fourth corner up z, whatever the format says about axes.
TEST(Meshes, FormatsScalesAndUnits) {
  const TemporaryFiles files;
  files.write("t.obj", tetrahedronObj());
  files.write("t.STL", tetrahedronStl());
  files.write("z.dae", tetrahedronDae("Z_UP", 1));
  files.write("mm.dae", tetrahedronDae("Z_UP", 0.001));
  const struct {
    const char *mesh, *scale;
    double volume;
  } cases[] = {{"t.obj", "1 1 1", 1 / 6.},  {"t.STL", "1 1 1", 1 / 6.},        {"z.dae", "1 1 1", 1 / 6.},
               {"t.obj", "2 3 4", 4},       {"t.STL", "0.1 0.1 0.1", 1 / 6e3}, {"t.obj", "-1 1 1", 1 / 6.},
               {"mm.dae", "1 1 1", 1 / 6e9}};
  for (const auto& c : cases) {
    SCOPED_TRACE(std::string(c.mesh) + " " + c.scale);
    const SceneDef scene = loadScene(files.write("robot.urdf", meshLink(c.mesh, c.scale)));
    const ConvexPolyhedron& shape = *scene.world.articulations.at(0).links.at(0).collisions.at(0).shape->polyhedron();
    EXPECT_NEAR(shape.volume(), c.volume, 1e-6 * c.volume);  // .stl and .dae carry single precision
    EXPECT_EQ(shape.vertexCount(), 4);
    const double x = c.scale[0] == '-' ? shape.aabb().lower.x() : shape.aabb().upper.x();
    EXPECT_EQ(x < 0, c.scale[0] == '-');
  }
}

TEST(Meshes, PackagesBesideTheFileAndAboveIt) {
  const TemporaryFiles files;
  files.write("my_robot/meshes/t.obj", tetrahedronObj());
  const std::string urdf = meshLink("package://my_robot/meshes/t.obj");
  for (const char* place : {"r.urdf", "my_robot/r.urdf", "my_robot/urdf/deep/r.urdf", "other/r.urdf"}) {
    EXPECT_EQ(loadScene(files.write(place, urdf)).collisions_loaded, 1) << place;
  }
}

TEST(Meshes, UnreadableOnesAreRefusedByName) {
  const TemporaryFiles files;
  const struct {
    const char *name, *text;
  } broken[] = {{"empty.stl", ""},
                {"text.obj", "hello\n"},
                {"infinite.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 3 2\n"},
                {"cut.dae", "<COLLADA>"}};
  for (const auto& mesh : broken) {
    files.write(mesh.name, mesh.text);
    try {
      loadScene(files.write("robot.urdf", meshLink(mesh.name)));
      ADD_FAILURE() << mesh.name << " was accepted";
    } catch (const SetupError& error) {
      EXPECT_NE(std::string(error.what()).find(mesh.name), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("'a'"), std::string::npos) << error.what();
    }
  }
}

/// A strongly concave mesh becomes pieces that leave its hollow open.
TEST(Meshes, ConcaveOnesAreCutIntoPieces) {
  const TemporaryFiles files;
  // An L of two unit cubes' width: (0…2)² × (0…1) without (1…2)².
  files.write("l.obj",
              "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 1\nv 2 0 1\nv 2 1 1\nv 1 1 1\nv 1 "
              "2 1\nv 0 2 1\n"
              "f 1 3 2\nf 1 4 3\nf 1 5 4\nf 1 6 5\nf 7 8 9\nf 7 9 10\nf 7 10 11\nf 7 11 12\nf 1 2 8\nf 1 8 "
              "7\nf 2 3 9\nf 2 9 8\n"
              "f 3 4 10\nf 3 10 9\nf 4 5 11\nf 4 11 10\nf 5 6 12\nf 5 12 11\nf 6 1 7\nf 6 7 12\n");
  const SceneDef scene = loadScene(files.write("robot.urdf", meshLink("l.obj")));
  double volume = 0;
  for (const CollisionDef& c : scene.world.articulations[0].links[0].collisions) volume += c.shape->volume();
  EXPECT_NEAR(volume, 3, 1e-4);
  EXPECT_EQ(scene.collisions_loaded, 1);
}

/// Every scene of the repository loads whole, names its pointer or gets one, and starts as a world.
TEST(Scenes, AllLoad) {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(HAPTIC_SCENES)) {
    if (entry.path().extension() != ".urdf") continue;
    SCOPED_TRACE(entry.path().string());
    const SceneDef scene = loadScene(entry.path().string());
    EXPECT_EQ(scene.collisions_loaded, scene.collisions_tried);
    EXPECT_FALSE(mentions(scene.warnings, "overlap"));
    EXPECT_GE(scene.hands.size(), 1u);
    World world(scene.world);
    for (int i = 0; i < 20; ++i) world.step();
    EXPECT_TRUE(world.report().finite);
    ++scenes;
  }
  EXPECT_GE(scenes, 25);
}

}  // namespace published_robots_test
}  // namespace haptic
