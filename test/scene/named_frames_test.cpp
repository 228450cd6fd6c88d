/// References to links that hang on fixed joints: each keeps the frame that was named, whatever it was merged into.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>

#include "haptic_core/world/world.h"
#include "scene/robot_description.h"
#include "temporary_files.h"

namespace haptic {
namespace named_frames_test {

const SceneOptions kNoPointer = {0, "", {}, false};
constexpr int kLongest = 3;       ///< fixed joints in a row
constexpr double kEqual = 1e-12;  ///< [m], and per metre of an axis

/// A joint of the chain: 0.1 m along x, turned by 30° about z.
const Pose kJoint(rotationAbout(Vector3::UnitZ(), M_PI / 6), Vector3(0.1, 0, 0));
const char kJointText[] = "<origin xyz=\"0.1 0 0\" rpy=\"0 0 0.52359877559829881546\"/>";

/// link0 on a joint of the world at (0.5, 0, 1), and link1…link3, each on a fixed joint of the one before.
std::string chain(const std::string& type, const std::string& tags) {
  std::string text = "<link name=\"world\"/>\n" + boxLink("link0", 1, 0.05) +
                     joint("first", type, "world", "link0", type == "floating" ? "" : "<axis xyz=\"0 0 1\"/>", "0.5 0 1");
  for (int n = 1; n <= kLongest; ++n) {
    const std::string name = "link" + std::to_string(n);
    text += boxLink(name, 1, 0.05) + "<joint name=\"fixed" + std::to_string(n) + "\" type=\"fixed\">" + kJointText + "<parent link=\"link" +
            std::to_string(n - 1) + "\"/><child link=\"" + name + "\"/></joint>\n";
  }
  return robot(text + boxLink("other", 1, 0.05) + joint("free", "floating", "world", "other", "", "0 2 1") + tags + "\n");
}

Pose named(int n) {
  Pose X(Vector3(0.5, 0, 1));
  for (int i = 0; i < n; ++i) X = X * kJoint;
  return X;
}

double distance(const Pose& a, const Pose& b) { return std::max((a.p - b.p).norm(), (a.R - b.R).norm()); }

/// Where a frame of a definition's link stands at the start.
Pose inWorld(const SceneDef& scene, int articulation, int link, const Pose& X_LF) {
  return initialPoses(scene.world.articulations[static_cast<std::size_t>(articulation)])[static_cast<std::size_t>(link)] * X_LF;
}

/// By kind of reference: a scene with one to link n, and how far its frame is from the named one.
using Kind = double (*)(int n);
std::string tagOf(const std::string& kind, int n, const std::string& more) {
  return "<haptic:" + kind + " link=\"link" + std::to_string(n) + "\" " + more + "/>";
}

double ofPointer(int n, const std::string& type, const std::string& coupling) {
  const SceneDef scene = loadText(chain(type, tagOf("pointer", n, coupling)));
  World world(scene.world);
  // Where the device stands, what the world calls the pointer, and the wrench's point after a step towards a target.
  const double at_home = distance(scene.hands[0].workspace.X_WB, named(n)), now = distance(world.pointerPose(0), named(n));
  world.setPointerTarget(0, named(n), {});
  world.step();
  const double gravity = 9.8e-6;  // [m] that the link falls in a step under a virtual coupling
  const double later = distance(world.pointerPose(0), named(n));
  return std::max({at_home, now, coupling.empty() ? later : std::max(0.0, later - 20 * gravity)});
}

double ofSensor(int n, const std::string& type, const std::string& more) {
  const std::string reference = type == "wrench" ? "joint=\"" + (n ? "fixed" + std::to_string(n) : std::string("first")) + "\""
                                                 : "link=\"link" + std::to_string(n) + "\"";
  const std::string tag = "<haptic:sensor name=\"s\" type=\"" + type + "\" " + reference + more + "/>";
  const SceneDef scene = loadText(chain("continuous", tag), kNoPointer);
  const SensorDef& sensor = scene.world.sensors.at(0);
  return distance(inWorld(scene, sensor.articulation, sensor.link, sensor.X_LS), named(n));
}

double ofLoop(int n) {
  const SceneDef scene = loadText(chain("floating", "<haptic:loop type=\"weld\" link1=\"link" + std::to_string(n) + "\" link2=\"other\"/>"),
                                  kNoPointer);
  const LoopDef& loop = scene.world.loops.at(0);
  return std::max(distance(inWorld(scene, loop.articulation_a, loop.link_a, loop.X_AF), named(n)),
                  distance(inWorld(scene, loop.articulation_b, loop.link_b, loop.X_BF), named(n)));
}

double ofForce(int n) {
  const std::string link = "link" + std::to_string(n);
  const SceneDef scene = loadText(
      chain("floating", "<haptic:force type=\"spring\" link1=\"" + link + "\" link2=\"other\" stiffness=\"10\"/>"), kNoPointer);
  const ForceDef& force = scene.world.forces.at(0);
  return (inWorld(scene, force.articulation_a, force.link_a, Pose(force.p_A)).p - named(n).p).norm();
}

double ofMotion(int n, bool told) {
  const TemporaryFiles files;
  const Pose target = named(n);
  char row[200];
  std::snprintf(row, sizeof row, "%.17g,%.17g,%.17g,0,0,%.17g\n", target.p.x(), target.p.y(), target.p.z(), n * M_PI / 6);
  files.write("way.csv", std::string("time,x,y,z,roll,pitch,yaw\n0,") + row + "1," + row);
  const std::string source = told ? "topic=\"/way\"" : "file=\"way.csv\"";
  const SceneDef scene = loadScene(files.write("robot.urdf", chain("floating", tagOf("motion", n, source))), kNoPointer);
  const Pose X_WL = initialPoses(scene.world.articulations[static_cast<std::size_t>(scene.world.motions.at(0).articulation)])[0];
  return distance(told ? X_WL * scene.told_motions.at(0).X_FL.inverse() : X_WL, told ? target : named(0));
}

double ofDevice(int n) {
  const TemporaryFiles files;
  files.write("robot.urdf", chain("floating", ""));
  const SceneDef scene = loadScene(files.write("list.yaml", "models: [{file: robot.urdf}]\ndevices: [{device: left, pointer: link" +
                                                                std::to_string(n) + "}]\n"));
  return std::max(distance(scene.hands.at(0).workspace.X_WB, named(n)), distance(World(scene.world).pointerPose(0), named(n)));
}

TEST(NamedFrames, AreWhereTheFileHasThem) {
  const std::map<std::string, Kind> kinds = {
      {"pointer", [](int n) { return ofPointer(n, "floating", ""); }},
      {"pointer, virtual", [](int n) { return ofPointer(n, "floating", "coupling=\"virtual\""); }},
      {"pointer of an arm", [](int n) { return ofPointer(n, "continuous", "coupling=\"virtual\""); }},
      {"device of a list", ofDevice},
      {"wrench", [](int n) { return ofSensor(n, "wrench", ""); }},
      {"contact", [](int n) { return ofSensor(n, "contact", ""); }},
      {"imu", [](int n) { return ofSensor(n, "imu", ""); }},
      {"motion of a file", [](int n) { return ofMotion(n, false); }},
      {"motion told", [](int n) { return ofMotion(n, true); }},
      {"force", ofForce},
      {"loop", ofLoop}};
  int moved = 0;
  for (const auto& [name, off] : kinds) {
    for (int n = 0; n <= kLongest; ++n) {
      const double away = off(n);
      EXPECT_LT(away, kEqual) << name << " behind " << n << " fixed joints";
      moved += !(away < kEqual);
    }
  }
  std::printf("figure frames.moved %d 1\n", moved);
}

TEST(NamedFrames, TheHandIsToldByTheNameInTheFile) {
  const SceneDef scene = loadText(chain("floating", tagOf("pointer", 2, "")));
  EXPECT_EQ(scene.world.pointers.at(0).name, "link2");
}

TEST(NamedFrames, OthersReadTheRobotUnderTheScenesNames) {
  const std::string text = chain("continuous", "");
  EXPECT_EQ(loadText(text, kNoPointer).descriptions.at(0), std::make_pair(std::string(), text));
  EXPECT_EQ(robotDescription(text, ""), text);
  const std::string prefixed = robotDescription(text, "left_");
  for (const char* part : {"<link name=\"left_link3\"", "<joint name=\"left_fixed2\"", "<parent link=\"left_link1\"",
                           "<child link=\"left_link2\"", "<link name=\"world\"", "<parent link=\"world\""}) {
    EXPECT_NE(prefixed.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(prefixed.find("\"link"), std::string::npos);
}

}  // namespace named_frames_test
}  // namespace haptic
