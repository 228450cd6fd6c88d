#include "scene/robot_file.h"

#include <algorithm>
#include <cstring>

#include "scene/gazebo_sensors.h"
#include "scene/sound_numbers.h"
#include "scene/text_file.h"
#include "scene/xacro_run.h"

namespace haptic {
namespace {

/// More links than any published robot by far; beyond it the file is something else, and links are looked up
/// one by one.
constexpr std::size_t kMaxLinks = 2000;

/// Versions of URDF: 1.1 adds quat_xyzw, 1.2 capsules and limits of acceleration and jerk. All are read
/// alike, whatever a file says.
constexpr const char* kVersions[] = {"1", "1.0", "1.1", "1.2"};

void checkVersion(const RobotFile& robot) {
  const char* version = robot.xml.root()->Attribute("version");
  const auto is = [&](const char* known) { return std::strcmp(version, known) == 0; };
  if (!version || std::any_of(std::begin(kVersions), std::end(kVersions), is)) return;
  throw SetupError(robot.xml.at(*robot.xml.root()),
                   std::string("version '") + version + "' of URDF is unknown",
                   "known: 1.0, 1.1 and 1.2; write one of them, or none");
}

void readLinks(RobotFile& robot) {
  std::map<std::string, int> seen;
  for (XmlElement* element = robot.xml.root()->FirstChildElement("link"); element;
       element = element->NextSiblingElement("link")) {
    if (robot.links.size() == kMaxLinks) {
      throw SetupError(robot.xml.at(*element),
                       "is one link more than the " + std::to_string(kMaxLinks) + " that are allowed",
                       "split the scene");
    }
    LinkXml link;
    link.name = readOwnName(robot.xml, *element);
    link.element = element;
    const auto [place, fresh] = seen.emplace(link.name, robot.links.size());
    if (!fresh) {
      throw SetupError(robot.at(link),
                       "is defined twice (first in line " +
                           std::to_string(robot.links[place->second].element->GetLineNum()) + ")",
                       "rename one of them");
    }
    for (XmlElement* child = element->FirstChildElement("collision"); child;
         child = child->NextSiblingElement("collision")) {
      link.collisions.push_back(child);
    }
    robot.links.push_back(link);
  }
  if (robot.links.empty())
    throw SetupError(robot.xml.path(), "robot '" + robot.name + "' has no link", "add a <link>");
}

int linkOfJoint(const RobotFile& robot, const JointXml& joint, const char* role) {
  const XmlElement* element = joint.element->FirstChildElement(role);
  if (!element)
    throw SetupError(robot.at(joint), std::string("has no <") + role + ">",
                     "add <" + std::string(role) + " link=\"...\"/>");
  const std::string name = readName(robot.xml, *element, "link");
  const int index = robot.linkIndex(name);
  if (index < 0) {
    throw SetupError(robot.at(joint), std::string("its ") + role + " link '" + name + "' does not exist",
                     "define the link or mend the name");
  }
  return index;
}

void readJoints(RobotFile& robot) {
  std::map<std::string, int> seen;
  for (XmlElement* element = robot.xml.root()->FirstChildElement("joint"); element;
       element = element->NextSiblingElement("joint")) {
    JointXml joint;
    joint.name = readOwnName(robot.xml, *element);
    joint.element = element;
    if (!seen.emplace(joint.name, 0).second)
      throw SetupError(robot.at(joint), "is defined twice", "rename one of them");
    joint.type = readName(robot.xml, *element, "type");
    joint.extension = element->FirstChildElement("haptic:joint");
    joint.parent = linkOfJoint(robot, joint, "parent");
    joint.child = linkOfJoint(robot, joint, "child");
    if (joint.parent == joint.child) {
      throw SetupError(robot.at(joint), "has the same link as parent and child", "name two links");
    }
    LinkXml& child = robot.links[joint.child];
    const int index = static_cast<int>(robot.joints.size());
    if (child.parent_joint >= 0) {
      throw SetupError(robot.at(joint),
                       "link '" + child.name + "' is already the child of joint '" +
                           robot.joints[child.parent_joint].name + "'",
                       "a URDF is a tree: close rings with <haptic:loop>");
    }
    child.parent_joint = index;
    robot.links[joint.parent].child_joints.push_back(index);
    robot.joints.push_back(joint);
  }
}

/// Exactly one link without parent, and everything hangs on it. With one parent per link at most, whatever
/// the root does not reach lies on a ring.
void checkTree(RobotFile& robot) {
  for (int i = 0; i < static_cast<int>(robot.links.size()); ++i) {
    if (robot.links[i].parent_joint >= 0) continue;
    if (robot.root >= 0) {
      throw SetupError(robot.at(robot.links[i]),
                       "is a second root besides '" + robot.links[robot.root].name + "'",
                       "join them with a fixed joint, or hang both on a link named world");
    }
    robot.root = i;
  }
  if (robot.root < 0) {
    throw SetupError(robot.at(robot.joints.front()), "closes a loop: every link has a parent",
                     "open the ring and close it with <haptic:loop>");
  }
  std::vector<bool> reached(robot.links.size(), false);
  std::vector<int> open = {robot.root};
  while (!open.empty()) {
    const int link = open.back();
    open.pop_back();
    reached[link] = true;
    for (int joint : robot.links[link].child_joints) open.push_back(robot.joints[joint].child);
  }
  for (std::size_t i = 0; i < reached.size(); ++i) {
    if (reached[i]) continue;
    throw SetupError(robot.at(robot.joints[robot.links[i].parent_joint]),
                     "closes a loop in the tree: link '" + robot.links[i].name + "' is its own ancestor",
                     "open the ring and close it with <haptic:loop>");
  }
}

/// Descriptions of robots in other words, by their root element.
constexpr struct {
  const char *name, *format, *remedy;
} kOtherFormats[] = {
    {"sdf", "SDF of Gazebo, not a <robot>",
     "load the URDF or xacro that it was made of; for a model that has none, write its links and joints as URDF"},
    {"mujoco", "MJCF of MuJoCo, not a <robot>",
     "load the URDF that it was made of; MuJoCo reads URDF and does not write it, so most models name their origin in their README"},
    {"mujocoinclude", "a part of an MJCF of MuJoCo, not a <robot>", "load the URDF that it was made of"},
    {"COLLADA", "a mesh, not a <robot>", "name it in the <mesh> of a URDF"},
    {"launch", "a launch file, not a <robot>", "load the URDF or xacro that it names"}};

}  // namespace

int RobotFile::linkIndex(const std::string& link) const {
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (links[i].name == link) return static_cast<int>(i);
  }
  return -1;
}

int RobotFile::jointIndex(const std::string& joint) const {
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints[i].name == joint) return static_cast<int>(i);
  }
  return -1;
}

std::unique_ptr<RobotFile> readRobot(const std::string& path, const SceneOptions& options) {
  auto robot = std::make_unique<RobotFile>(path, options.text ? *options.text : readTextFile(path));
  if (isXacro(robot->xml)) robot = std::make_unique<RobotFile>(path + " (expanded)", expandXacro(path, robot->xml, options));
  const XmlElement* root = robot->xml.root();
  robot->warnings = robot->xml.warnings();
  for (const auto& [name, format, remedy] : kOtherFormats) {
    if (std::strcmp(root->Name(), name) == 0) throw SetupError(robot->xml.at(*root), std::string("<") + name + "> is " + format, remedy);
  }
  if (std::strcmp(root->Name(), "robot") != 0) {
    throw SetupError(robot->xml.at(*root),
                     std::string("the root element is <") + root->Name() + ">, not <robot>",
                     "give a URDF file");
  }
  robot->name = readOwnName(robot->xml, *root);
  checkVersion(*robot);
  readLinks(*robot);
  readJoints(*robot);
  checkTree(*robot);
  makeNumbersSound(*robot);
  checkJoints(*robot);
  takeGazeboSensors(*robot);
  return robot;
}

}  // namespace haptic
