/// Robots and scenes as files become the right bodies, joints, inertias and shapes.
#include <gtest/gtest.h>

#include <cmath>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/world/world.h"
#include "temporary_files.h"

namespace haptic {
namespace robot_test {

const SceneOptions kNoPointer = {0, "", {}, false};

std::string inertial(double mass, const std::string& xyz) {
  return "<inertial><origin xyz=\"" + xyz + "\"/><mass value=\"" + std::to_string(mass) +
         "\"/><inertia ixx=\"0.01\" iyy=\"0.02\" izz=\"0.025\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";
}

/// Mass, centre of mass and inertia about the link's origin are sums over the parts, wherever they are
/// attached.
TEST(Merging, KeepsMassCentreAndInertia) {
  const std::string turned =
      "<joint name=\"weld\" type=\"fixed\"><origin xyz=\"0.3 -0.1 0.2\" rpy=\"0.4 -0.7 1.1\"/><parent "
      "link=\"arm\"/><child link=\"tool\"/></joint>";
  const SceneDef scene =
      loadText(robot("<link name=\"base\"/><link name=\"arm\">" + inertial(2, "0.1 0 0.05") +
                     "</link><link name=\"tool\">" + inertial(0.5, "0 0.2 0") + "</link>" +
                     joint("j", "revolute", "base", "arm") + turned),
               kNoPointer);
  const LinkDef& arm = scene.world.articulations.at(0).links.at(1);
  ASSERT_EQ(arm.merged.size(), 1u);
  EXPECT_EQ(arm.merged[0].name, "tool");
  const Pose X = arm.merged[0].X_LM;
  EXPECT_NEAR((X.p - Vector3(0.3, -0.1, 0.2)).norm(), 0, 1e-15);
  const Matrix3 I = Vector3(0.01, 0.02, 0.025).asDiagonal();
  const auto aboutOrigin = [](double m, const Vector3& c, const Matrix3& I_C) {
    return Matrix3(I_C + m * (c.squaredNorm() * Matrix3::Identity() - c * c.transpose()));
  };
  const Vector3 c1(0.1, 0, 0.05), c2 = X * Vector3(0, 0.2, 0);
  const Matrix3 expected = aboutOrigin(2, c1, I) + aboutOrigin(0.5, c2, X.R * I * X.R.transpose());
  EXPECT_DOUBLE_EQ(arm.inertia.mass, 2.5);
  EXPECT_NEAR((arm.inertia.p_LC - (2 * c1 + 0.5 * c2) / 2.5).norm(), 0, 1e-15);
  // A handful of roundings of numbers of size 0.1.
  EXPECT_NEAR((aboutOrigin(2.5, arm.inertia.p_LC, arm.inertia.I_C) - expected).norm(), 0, 1e-15);
}

TEST(Joints, TypesAxesLimitsAndMimics) {
  const std::string limit = "<limit lower=\"0.2\" upper=\"0.5\" effort=\"3\" velocity=\"2\"/>",
                    axis = "<axis xyz=\"0 3 4\"/>";
  const SceneDef scene =
      loadText(robot("<link name=\"base\"/>" + boxLink("a") + boxLink("b") + boxLink("c") + boxLink("d") +
                     boxLink("e") +
                     joint("ja", "revolute", "base", "a",
                           axis + limit + "<dynamics damping=\"0.1\" friction=\"0.2\"/>") +
                     joint("jb", "continuous", "a", "b", axis) +
                     joint("jc", "prismatic", "b", "c",
                           axis + limit + "<mimic joint=\"ja\" multiplier=\"2\" offset=\"-0.1\"/>") +
                     joint("jd", "planar", "c", "d", axis) +
                     joint("je", "floating", "d", "e", "<haptic:joint type=\"spherical\"/>")),
               kNoPointer);
  const auto& links = scene.world.articulations.at(0).links;
  ASSERT_EQ(links.size(), 6u);
  EXPECT_EQ(links[1].joint.type, JointType::kRevolute);
  EXPECT_NEAR((links[1].joint.axis - Vector3(0, 0.6, 0.8)).norm(), 0, 1e-15);
  EXPECT_DOUBLE_EQ(links[1].joint.lower, 0.2);
  EXPECT_DOUBLE_EQ(links[1].joint.position, 0.2);  // the value nearest zero within the limits
  EXPECT_DOUBLE_EQ(links[1].joint.max_effort, 3);
  EXPECT_DOUBLE_EQ(links[1].joint.damping, 0.1);
  EXPECT_DOUBLE_EQ(links[1].joint.friction, 0.2);
  EXPECT_TRUE(std::isinf(links[2].joint.upper));
  EXPECT_EQ(links[3].joint.mimic_joint, 1);
  EXPECT_DOUBLE_EQ(links[3].joint.position, 2 * 0.2 - 0.1);
  EXPECT_EQ(links[4].joint.type, JointType::kPlanar);
  EXPECT_EQ(links[5].joint.type, JointType::kSpherical);
}

TEST(Joints, AMimicOfAMimicFollowsTheFirst) {
  const std::string inside = "<axis xyz=\"0 0 1\"/>";
  const SceneDef scene =
      loadText(robot("<link name=\"base\"/>" + boxLink("a") + boxLink("b") + boxLink("c") +
                     joint("jc", "continuous", "base", "c",
                           inside + "<mimic joint=\"jb\" multiplier=\"3\" offset=\"1\"/>") +
                     joint("jb", "continuous", "base", "b",
                           inside + "<mimic joint=\"ja\" multiplier=\"-2\" offset=\"5\"/>") +
                     joint("ja", "continuous", "base", "a", inside)),
               kNoPointer);
  for (const LinkDef& link : scene.world.articulations.at(0).links) {
    if (link.name != "c") continue;
    EXPECT_EQ(scene.world.articulations[0].links[link.joint.mimic_joint].name, "a");
    EXPECT_DOUBLE_EQ(link.joint.mimic_multiplier, -6);
    EXPECT_DOUBLE_EQ(link.joint.mimic_offset, 16);
  }
}

TEST(Worlds, FloatingJointsAreFreeBodiesFixedOnesStatic) {
  const SceneDef scene =
      loadText(robot("<link name=\"world\"/>" + boxLink("floor") + boxLink("cube") + boxLink("door") +
                     joint("f", "fixed", "world", "floor", "", "0 0 -1") +
                     joint("c", "floating", "world", "cube",
                           "<haptic:joint angular=\"1 2 3\" linear=\"4 5 6\"/>", "0 0 2") +
                     joint("d", "revolute", "floor", "door")),
               kNoPointer);
  ASSERT_EQ(scene.world.articulations.size(), 2u);
  const ArticulationDef &floor = scene.world.articulations[0], &cube = scene.world.articulations[1];
  EXPECT_EQ(floor.links[0].joint.type, JointType::kFixed);
  EXPECT_EQ(floor.links[1].joint.type, JointType::kRevolute);
  EXPECT_EQ(cube.links[0].joint.type, JointType::kFloating);
  EXPECT_DOUBLE_EQ(cube.X_WA.p.z(), 2);
  EXPECT_EQ(cube.V_WA.angular, Vector3(1, 2, 3));
  EXPECT_EQ(cube.V_WA.linear, Vector3(4, 5, 6));
  EXPECT_EQ(scene.world.filters.size(), 1u);  // floor and door are neighbours; the cube meets both
}

/// A floating joint below a moving link starts where forward kinematics puts it.
TEST(Worlds, AFloatingJointInsideATreeBecomesItsOwnBody) {
  const SceneDef scene = loadText(
      robot("<link name=\"base\"/>" + boxLink("arm") + boxLink("ball") +
            joint("j", "revolute", "base", "arm",
                  "<axis xyz=\"0 0 1\"/><limit lower=\"0.5\" upper=\"1\" effort=\"1\" velocity=\"1\"/>",
                  "1 0 0") +
            joint("k", "floating", "arm", "ball", "", "2 0 0")),
      kNoPointer);
  ASSERT_EQ(scene.world.articulations.size(), 2u);
  EXPECT_NEAR(
      (scene.world.articulations[1].X_WA.p - Vector3(1 + 2 * std::cos(0.5), 2 * std::sin(0.5), 0)).norm(), 0,
      1e-15);
}

TEST(Worlds, AnEmptyRootThatFloatsIsTheWorld) {
  const SceneDef scene = loadText(
      robot("<link name=\"origin\"/>" + boxLink("pelvis") + boxLink("leg") +
            joint("base", "floating", "origin", "pelvis", "") + joint("hip", "revolute", "pelvis", "leg")),
      kNoPointer);
  ASSERT_EQ(scene.world.articulations.size(), 1u);
  EXPECT_EQ(scene.world.articulations[0].links[0].joint.type, JointType::kFloating);
  EXPECT_EQ(scene.world.articulations[0].links.size(), 2u);
}

TEST(Contact, SourcesInTheirOrder) {
  const std::string drake =
      "<drake:proximity_properties><drake:mu_static value=\"0.7\"/><drake:hydroelastic_modulus "
      "value=\"1e5\"/>"
      "<drake:hunt_crossley_dissipation value=\"2\"/></drake:proximity_properties>";
  const std::string bullet =
      "<contact><lateral_friction value=\"0.3\"/><stiffness value=\"1000\"/></contact>";
  const auto material = [](const std::string& text) {
    return loadText(text, kNoPointer).world.articulations.at(0).links.at(0).collisions.at(0);
  };
  const std::string gazebo = "<gazebo reference=\"a\"><mu1>0.9</mu1><mu2>0.1</mu2><kp>1e12</kp></gazebo>";
  std::string link = boxLink(
      "a", 1, 0.1, "<haptic:contact stiffness=\"1e6\" mu_static=\"0.5\" mu_dynamic=\"0.4\"/>" + drake);
  CollisionDef c = material(robot(link + gazebo));
  EXPECT_DOUBLE_EQ(c.material.stiffness, 1e6);
  EXPECT_DOUBLE_EQ(c.material.mu_dynamic, 0.4);
  EXPECT_NE(c.material_source.find("haptic:contact, line 3"), std::string::npos);
  c = material(robot(boxLink("a", 1, 0.1, drake) + gazebo));
  EXPECT_DOUBLE_EQ(c.material.stiffness, 1e5 / 0.05);  // pressure over half extent
  EXPECT_DOUBLE_EQ(c.material.mu_dynamic, 0.7);
  EXPECT_DOUBLE_EQ(c.material.dissipation, 2);
  link = boxLink("a");
  link.insert(link.find("<inertial>"), bullet);
  c = material(robot(link + gazebo));
  EXPECT_DOUBLE_EQ(c.material.mu_static, 0.3);
  EXPECT_TRUE(std::isnan(c.material.stiffness));  // Bullet's number depends on mass and step
  c = material(robot(boxLink("a") + gazebo));
  EXPECT_DOUBLE_EQ(c.material.mu_static, 0.9);  // mu1 for both: mu2 is another direction, not the dynamic one
  EXPECT_DOUBLE_EQ(c.material.mu_dynamic, 0.9);
  EXPECT_TRUE(std::isnan(c.material.stiffness));  // kp is no physical number
  EXPECT_NE(c.material_source.find("gazebo mu1, line 4"), std::string::npos);
}

TEST(Contact, ChildElementsAreReadLikeAttributes) {
  const auto& scene = loadText(
      robot(boxLink(
          "a", 1, 0.1,
          "<haptic:contact><haptic:stiffness value=\"2e6\"/><mu_static>0.5</mu_static></haptic:contact>")),
      kNoPointer);
  const ContactMaterial& m = scene.world.articulations[0].links[0].collisions[0].material;
  EXPECT_DOUBLE_EQ(m.stiffness, 2e6);
  EXPECT_DOUBLE_EQ(m.mu_static, 0.5);
}

TEST(Pointer, AddedOutsideOfAllCollisions) {
  const SceneDef scene = loadText(
      robot(boxLink("low", 1, 0.1) + boxLink("high", 1, 0.1) + joint("j", "revolute", "low", "high")));
  ASSERT_EQ(scene.world.pointers.size(), 1u);
  ASSERT_EQ(scene.hands.size(), 1u);
  const PointerDef& pointer = scene.world.pointers[0];
  const ArticulationDef& body = scene.world.articulations[pointer.articulation];
  const double radius = body.links[0].collisions.at(0).shape->boundingRadius();
  EXPECT_EQ(radius, 0.005);  // a ball of 10 mm
  EXPECT_GT(body.X_WA.p.z() - radius, 1.05);
  EXPECT_GT(scene.hands[0].path.duration(), 5);
  // The scripted hand goes below the surface: it touches.
  double lowest = 0;
  for (const HandKey& key : scene.hands[0].path.keys) lowest = std::min(lowest, key.p_BG.z());
  EXPECT_LT(body.X_WA.p.z() + lowest - radius, 1.05);
}

/// The surface is where the ball's is, however it is turned.
TEST(Pointer, StartsAboveTheSurfaceOfATurnedShape) {
  const SceneDef scene = loadText(robot(
      "<link name=\"ball\">" + inertial(1, "0 0 0") +
      "<collision><origin rpy=\"0 0.7854 0\"/><geometry><sphere radius=\"0.05\"/></geometry></collision></link>"));
  const PointerDef& pointer = scene.world.pointers.at(0);
  const ArticulationDef& body = scene.world.articulations[pointer.articulation];
  EXPECT_NEAR(body.X_WA.p.z() - 0.005 - 0.05, 0.005, 1e-12);
}

/// Lowest way of the scripted hand [m] over a box of 0.2 m that hangs on the world by a joint; 0: it waits.
double lowestOver(const std::string& joint, const std::string& axis, const std::string& motion, const std::string& more = "") {
  const SceneDef scene = loadText(
      "<robot name=\"r\" xmlns:haptic=\"https://haptic/urdf\"><link name=\"world\"/><link name=\"box\">" + inertial(1, "0 0 0") +
      "<collision><geometry><box size=\"0.2 0.2 0.2\"/></geometry></collision></link>" + more + "<joint name=\"j\" type=\"" + joint +
      "\"><origin xyz=\"3 2 1\" rpy=\"0 0 0.3\"/><parent link=\"world\"/><child link=\"box\"/><axis xyz=\"" + axis +
      "\"/><limit lower=\"-9\" upper=\"9\" effort=\"0\" velocity=\"100\"/>" + motion + "</joint></robot>");
  double z = 0;
  for (const HandKey& key : scene.hands.at(0).path.keys) z = std::min(z, key.p_BG.z());
  return z;
}

/// The upper side of a box that turns about a horizontal axis through its middle passes at 0.1 m times its speed.
TEST(Pointer, TheScriptedHandWaitsAboveWhatSpins) {
  // The floor that carries it is 0.5 mm below.
  const std::string floor =
      "<link name=\"floor\"><collision><geometry><box size=\"9 9 0.1\"/></geometry></collision></link><joint name=\"f\" "
      "type=\"fixed\"><origin xyz=\"0 0 0.8495\"/><parent link=\"world\"/><child link=\"floor\"/></joint>";
  EXPECT_LT(lowestOver("floating", "0 1 0", "<haptic:joint angular=\"0 9.9 0\"/>", floor), -0.005);
  EXPECT_EQ(lowestOver("floating", "0 1 0", "<haptic:joint angular=\"0 10.1 0\"/>", floor), 0);
  EXPECT_LT(lowestOver("continuous", "0 1 0", "<haptic:joint velocity=\"9.9\"/>", floor), -0.005);
  EXPECT_EQ(lowestOver("continuous", "0 1 0", "<haptic:joint velocity=\"10.1\"/>", floor), 0);
  EXPECT_LT(lowestOver("prismatic", "1 0 0", "<haptic:joint velocity=\"0.9\"/>", floor), -0.005);
  EXPECT_EQ(lowestOver("prismatic", "1 0 0", "<haptic:joint velocity=\"1.1\"/>", floor), 0);
}

/// With nothing under it: a free box falls 49 mm in 0.1 s, one on a rail does where the rail is steep, one on a hinge stays.
TEST(Pointer, TheScriptedHandWaitsWhereTheSurfaceLeaves) {
  EXPECT_EQ(lowestOver("floating", "0 1 0", ""), 0);
  EXPECT_EQ(lowestOver("prismatic", "0 0 1", ""), 0);
  EXPECT_LT(lowestOver("prismatic", "1 0 0", ""), -0.005);
  EXPECT_LT(lowestOver("continuous", "0 1 0", ""), -0.005);
  EXPECT_EQ(lowestOver("continuous", "0 1 0", "<haptic:joint velocity=\"0.6\"/>"), 0);  // 6 mm
  EXPECT_LT(lowestOver("continuous", "0 1 0", "<haptic:joint velocity=\"0.4\"/>"), -0.005);
}

TEST(Filters, OverlapInsideOneRobotIsFilteredAndNamed) {
  const std::string near = "0.04 0 0";
  const SceneDef scene = loadText(
      robot(
          boxLink("a") + boxLink("b") + boxLink("c") +
          joint("j", "revolute", "a", "b",
                "<axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>", near) +
          joint("k", "revolute", "b", "c",
                "<axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>", near)),
      kNoPointer);
  EXPECT_EQ(scene.world.filters.size(), 3u);  // two neighbours, and a with c
  EXPECT_TRUE(mentions(scene.warnings, "'a' and 'c' overlap by 20 mm"));
}

TEST(Filters, SrdfPairs) {
  const TemporaryFiles files;
  const std::string urdf =
      files.write("r.urdf", robot(boxLink("a") + boxLink("b") + boxLink("c") +
                                  joint("j", "revolute", "a", "b") + joint("k", "revolute", "b", "c")));
  SceneOptions options = kNoPointer;
  const std::size_t without = loadScene(urdf, options).world.filters.size();
  options.srdf =
      files.write("r.srdf",
                  "<robot name=\"r\"><disable_collisions link1=\"a\" link2=\"c\" reason=\"Never\"/>"
                  "<disable_collisions link1=\"a\" link2=\"ghost\"/></robot>");
  const SceneDef scene = loadScene(urdf, options);
  EXPECT_EQ(scene.world.filters.size(), without + 1);
  EXPECT_TRUE(mentions(scene.notes, "1 pairs do not collide, 1 pairs name links"));
}

/// A four-bar closed at its start: the frame that the loop joins is one place in W, seen from both links.
/// An arm of a revolute, a tilted prismatic and a revolute joint, stretched out sideways: the feed-forward carries its
/// weight from the first step on. What is left is the change of that weight with the rounding of the pose.
TEST(Joints, APublishedRobotHoldsItsPoseAgainstGravity) {
  const std::string limit = "<limit lower=\"-2\" upper=\"2\" effort=\"500\" velocity=\"2\"/>";
  const SceneDef scene = loadText(
      robot("<link name=\"base\"/><link name=\"a\">" + inertial(2, "0.3 0 0") + "</link><link name=\"b\">" +
            inertial(1, "0.2 0.1 0") + "</link><link name=\"c\">" + inertial(0.5, "0.1 0 0.05") + "</link>" +
            joint("ja", "revolute", "base", "a", "<axis xyz=\"0 1 0\"/>" + limit) +
            joint("jb", "prismatic", "a", "b", "<axis xyz=\"0 3 4\"/>" + limit) +
            joint("jc", "revolute", "b", "c", "<axis xyz=\"1 1 0\"/>" + limit)),
      kNoPointer);
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_EQ(scene.world.articulations[0].links[i].joint.drive, JointDef::Drive::kPosition);
    EXPECT_NE(scene.world.articulations[0].links[i].joint.drive_effort, 0);
  }
  World world(scene.world);
  std::vector<Pose> start;
  for (int l = 0; l < world.linkCount(); ++l) start.push_back(world.linkPose(l));
  for (int step = 0; step < 1000; ++step) world.step();
  for (int l = 0; l < world.linkCount(); ++l) EXPECT_LT((world.linkPose(l).p - start[l].p).norm(), 1e-12) << l;
}

TEST(Loops, CloseWhereTheLinksAre) {
  const std::string axis = "<axis xyz=\"0 1 0\"/>";
  const SceneDef scene = loadText(
      robot("<link name=\"base\"/>" + boxLink("crank") + boxLink("rod") + boxLink("rocker") +
            joint("j1", "continuous", "base", "crank", axis, "0 0 0") +
            joint("j2", "continuous", "crank", "rod", axis, "0 0 1") +
            joint("j3", "continuous", "base", "rocker", axis, "2 0 0") +
            "<haptic:loop type=\"hinge\" link1=\"rod\" link2=\"rocker\" xyz=\"2 0 0\" axis=\"0 1 0\"/>"),
      kNoPointer);
  ASSERT_EQ(scene.world.loops.size(), 1u);
  const LoopDef& loop = scene.world.loops[0];
  const auto X_WL = initialPoses(scene.world.articulations[loop.articulation_a]);
  const Pose a = X_WL[loop.link_a] * loop.X_AF, b = X_WL[loop.link_b] * loop.X_BF;
  EXPECT_NEAR((a.p - b.p).norm(), 0, 1e-15);
  EXPECT_NEAR((a.p - Vector3(2, 0, 1)).norm(), 0, 1e-15);
  EXPECT_EQ(loop.type, LoopDef::Type::kHinge);
}

TEST(Lists, ModelsWithPrefixPoseJointsAndDevice) {
  const TemporaryFiles files;
  files.write("arm.urdf", robot(boxLink("base") + boxLink("arm") + joint("j", "revolute", "base", "arm")));
  files.write("ball.urdf", robot("<link name=\"world\"/>" + boxLink("ball") +
                                 joint("f", "floating", "world", "ball", "", "0 0 5")));
  const std::string list =
      files.write("scene.yaml",
                  "name: two\nsettings: {step: 0.0005, gravity: [0, 0, -1]}\nmaterial: {stiffness: 1e5}\n"
                  "models:\n  - {file: arm.urdf, prefix: l_, pose: {xyz: [0, 1, 0], rpy: [0, 0, "
                  "1.5707963267948966]}, joints: {j: 0.25}}\n"
                  "  - {file: arm.urdf, prefix: r_, base: floating}\n  - {file: ball.urdf}\n"
                  "devices:\n  - {device: left, pointer: ball, coupling: virtual, scale: 2}\nfilters:\n  - "
                  "[l_arm, r_arm]\n");
  const SceneDef scene = loadScene(list, kNoPointer);
  EXPECT_EQ(scene.world.name, "two");
  EXPECT_DOUBLE_EQ(scene.world.settings.step, 0.0005);
  EXPECT_DOUBLE_EQ(scene.world.settings.default_material.stiffness, 1e5);
  ASSERT_EQ(scene.world.articulations.size(), 3u);
  EXPECT_EQ(scene.world.articulations[0].links[1].name, "l_arm");
  EXPECT_DOUBLE_EQ(scene.world.articulations[0].links[1].joint.position, 0.25);
  EXPECT_DOUBLE_EQ(scene.world.articulations[0].X_WA.p.y(), 1);
  EXPECT_EQ(scene.world.articulations[1].links[0].joint.type, JointType::kFloating);
  ASSERT_EQ(scene.hands.size(), 1u);
  EXPECT_EQ(scene.hands[0].device, "left");
  EXPECT_DOUBLE_EQ(scene.hands[0].workspace.scale, 2);
  EXPECT_EQ(scene.world.pointers[0].coupling.mode, PointerCoupling::Mode::kVirtual);
}

TEST(Inertia, DefaultDensityOnlyWhenAsked) {
  const std::string urdf = robot(
      "<link name=\"base\"/><link name=\"arm\"><collision><geometry><box size=\"0.1 0.2 "
      "0.3\"/></geometry></collision></link>" +
      joint("j", "revolute", "base", "arm"));
  EXPECT_NE(refusal(urdf), "");
  SceneOptions options = kNoPointer;
  options.default_density = 500;
  const LinkInertia inertia = loadText(urdf, options).world.articulations[0].links[1].inertia;
  EXPECT_NEAR(inertia.mass, 3, 1e-12);
  EXPECT_NEAR(inertia.I_C(0, 0), 3 * (0.04 + 0.09) / 12, 1e-12);
}

/// Also far from where its box ends; a link fixed to it may have one too.
TEST(Robot, HalfSpacesAreGroundWithoutEnd) {
  const std::string plane = "<haptic:shape type=\"half_space\"/>";
  const SceneDef scene = loadText(robot(boxLink("base", 1, 0.1, plane) + boxLink("wall", 1, 0.1, plane) + boxLink("cube") +
                                        joint("fix", "fixed", "base", "wall", "", "0 0 -2") +
                                        joint("free", "floating", "base", "cube", "", "30 0 0.06")));
  int planes = 0;
  for (const ArticulationDef& articulation : scene.world.articulations) {
    for (const LinkDef& link : articulation.links) {
      for (const CollisionDef& collision : link.collisions) planes += collision.shape->halfSpace() != nullptr;
    }
  }
  EXPECT_EQ(planes, 2);
  EXPECT_NE(scene.collisions[0].text.find("half-space"), std::string::npos);
  World world(scene.world);
  for (int i = 0; i < 1000; ++i) world.step();
  EXPECT_NEAR(world.linkPose(world.linkIndex("cube")).p.z(), 0.05, 1e-3);
}

/// An ellipsoid and a cone in place of the box beside them: mass, what `check` says, and how high they come to rest.
TEST(Robot, EllipsoidsAndConesCollideInPlaceOfTheGeometry) {
  const std::string egg = "<haptic:shape type=\"ellipsoid\" radii=\"0.06 0.05 0.03\"/>";
  const std::string cone = "<haptic:shape type=\"cone\" radius=\"0.05\" top_radius=\"0.02\" length=\"0.08\"/>";
  const SceneDef scene = loadText(robot(boxLink("base", 1, 0.1, "<haptic:shape type=\"half_space\"/>") + boxLink("egg", 1, 0.1, egg) +
                                        boxLink("cone", 1, 0.1, cone) +
                                        joint("e", "floating", "base", "egg", "", "0 0 0.035") +
                                        joint("c", "floating", "base", "cone", "", "1 0 0.045")));
  ASSERT_EQ(scene.collisions.size(), 3u);
  std::string said;
  for (const auto& collision : scene.collisions) said += collision.text + "\n";
  EXPECT_NE(said.find("ellipsoid r 0.06 × 0.05 × 0.03 m, exact on planes and polyhedra"), std::string::npos) << said;
  EXPECT_NE(said.find("cone r 0.05 to 0.02 l 0.08 m, in contacts a polyhedron of 128 vertices, surface within 0."), std::string::npos)
      << said;
  World world(scene.world);
  for (int i = 0; i < 1000; ++i) world.step();
  EXPECT_NEAR(world.linkPose(world.linkIndex("egg")).p.z(), 0.03, 1e-3);
  EXPECT_NEAR(world.linkPose(world.linkIndex("cone")).p.z(), 0.04, 1e-3);
}

/// A height field from a file, and the surface of an open mesh: what `check` says, what rviz draws, and how high a cube rests.
TEST(Robot, HeightFieldsAndMeshesAreGround) {
  const TemporaryFiles files;
  files.write("steps.txt", "# two levels\n0.1, 0.1, 0.1\n\n0.1 0.1 0.1\r\n0 0 0\n0 0 0\n");
  files.write("slab.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3\nf 1 3 4\n");
  const std::string field = "<haptic:shape type=\"height_field\" file=\"steps.txt\" size=\"2 3\" thickness=\"0.2\"/>";
  const std::string slab =
      "<link name=\"slab\"><collision><geometry><mesh filename=\"slab.obj\"/></geometry><haptic:shape type=\"ground\" "
      "thickness=\"0.5\"/></collision></link>\n";
  const SceneDef scene = loadScene(files.write(
      "robot.urdf", robot(boxLink("base", 1, 0.1, field) + slab + boxLink("upper") + boxLink("lower") + boxLink("third") +
                          joint("s", "fixed", "base", "slab", "", "5 0 1") + joint("u", "floating", "base", "upper", "", "0.3 1.2 0.16") +
                          joint("l", "floating", "base", "lower", "", "0.3 -1.2 0.06") +
                          joint("t", "floating", "base", "third", "", "5.3 0.2 1.06"))));
  const std::string said = scene.collisions[0].text;
  EXPECT_NE(said.find("height field 3 × 4 over 2 × 3 m, 12 triangles from 0 to 0.1 m as 3 convex pieces down to -0.2 m"), std::string::npos)
      << said;
  EXPECT_NE(scene.collisions[1].text.find("ground under mesh slab.obj, 2 triangles from 0 to 0 m as 1 convex pieces down to -0.5 m"),
            std::string::npos)
      << scene.collisions[1].text;
  std::size_t corners = 0;
  for (const VisualDef& visual : scene.visuals) corners += visual.shape == VisualShape::kTriangles ? visual.corners.size() : 0;
  EXPECT_EQ(corners, 3u * (12 + 2));
  World world(scene.world);
  for (int i = 0; i < 1000; ++i) world.step();
  EXPECT_NEAR(world.linkPose(world.linkIndex("upper")).p.z(), 0.15, 1e-3);
  EXPECT_NEAR(world.linkPose(world.linkIndex("lower")).p.z(), 0.05, 1e-3);
  EXPECT_NEAR(world.linkPose(world.linkIndex("third")).p.z(), 1.05, 1e-3);
}

/// Bad files of heights are refused with their line.
TEST(Robot, BadHeightFilesNameTheirLine) {
  const TemporaryFiles files;
  const std::string text = robot(
      boxLink("base", 1, 0.1, "<haptic:shape type=\"height_field\" file=\"h.txt\" size=\"1 1\" thickness=\"1\"/>"));
  const struct {
    const char *heights, *word, *other;
  } cases[] = {{"0 0\n# no row\n0 0 0\n", "h.txt:3", "3 heights"}, {"0 0\n0 inf\n", "h.txt:2", "inf"}, {"0 0\n0,,0\n", "h.txt:2", "''"},
               {"# nothing\n", "h.txt", "no heights"},         {"0\n0\n", "robot.urdf:3", "2 × 1"}, {"a b\n", "h.txt:1", "a b"}};
  for (const auto& bad : cases) {
    files.write("h.txt", bad.heights);
    std::string message;
    try {
      loadScene(files.write("robot.urdf", text));
    } catch (const SetupError& error) {
      message = error.what();
    }
    EXPECT_NE(message.find(bad.word), std::string::npos) << message;
    EXPECT_NE(message.find(bad.other), std::string::npos) << message;
  }
}

}  // namespace robot_test
}  // namespace haptic
