#include "scene/robot_file.h"

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <cstring>

#include "haptic_core/base/parse_numbers.h"
#include "scene/gazebo_sensors.h"
#include "scene/xacro_run.h"

namespace haptic {
namespace {

/// Keeps what urdfdom logs instead of printing it: its lines name neither file nor line.
class LogCapture : public console_bridge::OutputHandler {
 public:
  LogCapture() { console_bridge::useOutputHandler(this); }
  ~LogCapture() override { console_bridge::restorePreviousOutputHandler(); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first_.empty()) first_ = text;
  }
  const std::string& first() const { return first_; }

 private:
  std::string first_;
};

void readLinks(RobotFile& robot) {
  std::map<std::string, int> seen;
  for (XmlElement* element = robot.xml.root()->FirstChildElement("link"); element;
       element = element->NextSiblingElement("link")) {
    LinkXml link;
    link.name = readName(robot.xml, *element, "name");
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
    joint.name = readName(robot.xml, *element, "name");
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

/// A visual that urdfdom cannot read would make it drop the whole robot.
bool visualIsReadable(const XmlElement& visual) {
  const XmlElement* geometry = visual.FirstChildElement("geometry");
  const XmlElement* shape = geometry ? geometry->FirstChildElement() : nullptr;
  if (!shape) return false;
  const std::string name = shape->Name();
  if (name == "mesh") {
    const char* scale = shape->Attribute("scale");
    const auto numbers = parseNumbers(scale ? scale : "1 1 1");
    return shape->Attribute("filename") && numbers && numbers->size() == 3;
  }
  const auto has = [&](const char* attribute, std::size_t count) {
    const char* text = shape->Attribute(attribute);
    const auto numbers = parseNumbers(text ? text : "");
    return numbers && numbers->size() == count;
  };
  if (name == "box") return has("size", 3);
  if (name == "sphere") return has("radius", 1);
  return name == "cylinder" && has("radius", 1) && has("length", 1);
}

/// Takes out what would make urdfdom refuse or lose something: collisions (read here, with lines and haptic:
/// tags), visuals of shapes it does not know, and vendors' extensions.
void trimForUrdfdom(RobotFile& robot) {
  std::vector<XmlElement*> doomed;
  for (LinkXml& link : robot.links) {
    for (XmlElement* child = link.element->FirstChildElement(); child; child = child->NextSiblingElement()) {
      const std::string name = child->Name();
      if (name == "visual" && !visualIsReadable(*child)) {
        robot.warnings.push_back(robot.xml.at(*child) + ": link '" + link.name +
                                 "': this <visual> has no shape that can be drawn and is left out");
        doomed.push_back(child);
      } else if (name == "visual") {
        readOrigin(robot.xml, *child);  // refuses what is not a number, with its line
      }
    }
  }
  for (XmlElement* element : doomed) element->Parent()->DeleteChild(element);
}

void parseWithUrdfdom(RobotFile& robot) {
  tinyxml2::XMLDocument copy;
  robot.xml.document().DeepCopy(&copy);
  for (XmlElement* link = copy.RootElement()->FirstChildElement("link"); link;
       link = link->NextSiblingElement("link")) {
    while (XmlElement* collision = link->FirstChildElement("collision")) link->DeleteChild(collision);
  }
  for (const char* vendor : {"gazebo", "transmission", "sensor"}) {
    while (XmlElement* element = copy.RootElement()->FirstChildElement(vendor))
      copy.RootElement()->DeleteChild(element);
  }
  tinyxml2::XMLPrinter printer;
  copy.Print(&printer);
  LogCapture log;
  try {
    robot.model = urdf::parseURDF(std::string(printer.CStr(), printer.CStrSize() - 1));
  } catch (const std::exception& error) {
    throw SetupError(robot.xml.path(), std::string("urdfdom: ") + error.what(),
                     "compare the file with check_urdf");
  }
  if (!robot.model) {
    throw SetupError(robot.xml.path(),
                     "urdfdom: " + (log.first().empty() ? "the file is refused" : log.first()),
                     "compare the file with check_urdf");
  }
}

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
  if (!robot->xml.warning().empty()) robot->warnings.push_back(robot->xml.warning());
  for (const auto& [name, format, remedy] : kOtherFormats) {
    if (std::strcmp(root->Name(), name) == 0) throw SetupError(robot->xml.at(*root), std::string("<") + name + "> is " + format, remedy);
  }
  if (std::strcmp(root->Name(), "robot") != 0) {
    throw SetupError(robot->xml.at(*root),
                     std::string("the root element is <") + root->Name() + ">, not <robot>",
                     "give a URDF file");
  }
  robot->name = readName(robot->xml, *root, "name");
  readLinks(*robot);
  readJoints(*robot);
  checkTree(*robot);
  checkJoints(*robot);
  checkInertials(*robot);
  takeGazeboSensors(*robot);
  trimForUrdfdom(*robot);
  parseWithUrdfdom(*robot);
  return robot;
}

}  // namespace haptic
