#include "scene/gazebo_sensors.h"

#include <cctype>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "haptic_core/base/parse_numbers.h"
#include "scene/joint_reading.h"

namespace haptic {
namespace {

/// The element at the end of a path of names; null: it is not there.
const XmlElement* below(const XmlElement& element, std::initializer_list<const char*> path) {
  const XmlElement* at = &element;
  for (const char* name : path) at = at ? at->FirstChildElement(name) : nullptr;
  return at;
}

std::string textOf(const XmlElement* element) {
  const char* text = element ? element->GetText() : nullptr;
  const std::string whole = text ? text : "";
  const std::size_t first = whole.find_first_not_of(" \t\r\n"), last = whole.find_last_not_of(" \t\r\n");
  return first == std::string::npos ? std::string() : whole.substr(first, last - first + 1);
}

/// A number > 0; 0: there is none.
double positive(const XmlElement* element) {
  const auto numbers = parseNumbers(textOf(element));
  const bool good = numbers && numbers->size() == 1 && std::isfinite((*numbers)[0]) && (*numbers)[0] > 0;
  return good ? (*numbers)[0] : 0;
}

/// A topic can be called so: other letters become '_'.
std::string topicName(const std::string& name) {
  std::string fit = name;
  for (char& c : fit) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return fit.empty() || !std::isalpha(static_cast<unsigned char>(fit[0])) ? "sensor_" + fit : fit;
}

/// What becomes of one <sensor>.
struct Taken {
  std::string type;                       ///< of <haptic:sensor>
  std::map<std::string, std::string> attributes;
  bool turned = false;                    ///< a wrench whose sign or axes are not ours
};

std::string numberText(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

void takeNoise(const XmlElement* stddev, const char* attribute, Taken& taken) {
  const double value = positive(stddev);
  if (value > 0) taken.attributes[attribute] = numberText(value);
}

/// False: the pose is no six numbers.
bool takePose(const XmlElement& sensor, Taken& taken) {
  const std::string text = textOf(below(sensor, {"pose"}));
  if (text.empty()) return true;
  const auto pose = parseNumbers(text);
  if (!pose || pose->size() != 6) return false;
  bool moved = false;
  for (const double number : *pose) {
    if (!std::isfinite(number)) return false;
    moved |= number != 0;
  }
  if (!moved) return true;
  const auto three = [&](std::size_t i) {
    return numberText((*pose)[i]) + " " + numberText((*pose)[i + 1]) + " " + numberText((*pose)[i + 2]);
  };
  taken.attributes["xyz"] = three(0);
  taken.attributes["rpy"] = three(3);
  return true;
}

/// Why a sensor is left out; empty: it is in `taken`.
std::string read(const RobotFile& robot, const XmlElement& sensor, const std::string& reference, Taken& taken) {
  const std::string type = sensor.Attribute("type") ? sensor.Attribute("type") : "";
  const int link = robot.linkIndex(reference), joint = robot.jointIndex(reference);
  if (type == "force_torque") {
    if (joint < 0) return "no joint '" + reference + "'";
    const JointKind* kind = kindOf(robot.joints[joint]);
    if (!kind || kind->floating) return "its joint carries nothing";
    taken.type = "wrench";
    taken.attributes["joint"] = reference;
    const std::string frame = textOf(below(sensor, {"force_torque", "frame"}));
    const std::string way = textOf(below(sensor, {"force_torque", "measure_direction"}));
    taken.turned = way != "parent_to_child" || (!frame.empty() && frame != "child");
    takeNoise(below(sensor, {"force_torque", "force", "x", "noise", "stddev"}), "noise_force", taken);
    takeNoise(below(sensor, {"force_torque", "torque", "x", "noise", "stddev"}), "noise_torque", taken);
    return {};
  }
  if (type != "imu" && type != "contact") return type.empty() ? "it has no type" : "type " + type;
  if (link < 0 || reference == "world") return "no link '" + reference + "'";
  taken.type = type;
  taken.attributes["link"] = reference;
  if (type == "contact") return {};
  for (const auto& [of_rate, of_acceleration] : {std::pair("angular_velocity", "linear_acceleration"), std::pair("rate", "accel")}) {
    takeNoise(below(sensor, {"imu", of_rate, "x", "noise", "stddev"}), "noise_angular_rate", taken);
    takeNoise(below(sensor, {"imu", of_acceleration, "x", "noise", "stddev"}), "noise_specific_force", taken);
    takeNoise(below(sensor, {"imu", "noise", of_rate, "stddev"}), "noise_angular_rate", taken);
    takeNoise(below(sensor, {"imu", "noise", of_acceleration, "stddev"}), "noise_specific_force", taken);
  }
  return takePose(sensor, taken) ? std::string() : "its pose is no six numbers";
}

/// The element itself becomes ours, so that messages about it name its line.
void become(const Taken& taken, const std::string& name, XmlElement& sensor) {
  const double rate = positive(below(sensor, {"update_rate"}));
  sensor.DeleteChildren();
  while (const auto* attribute = sensor.FirstAttribute()) sensor.DeleteAttribute(std::string(attribute->Name()).c_str());
  sensor.SetName("haptic:sensor");
  sensor.SetAttribute("name", name.c_str());
  sensor.SetAttribute("type", taken.type.c_str());
  if (rate > 0) sensor.SetAttribute("rate", numberText(rate).c_str());
  for (const auto& [attribute, value] : taken.attributes) sensor.SetAttribute(attribute.c_str(), value.c_str());
}

}  // namespace

void takeGazeboSensors(RobotFile& robot) {
  std::set<std::string> names;
  for (const LinkXml& link : robot.links) names.insert(link.name);  // a sensor with a pose of its own is a frame
  XmlElement& root = *robot.xml.root();
  for (const XmlElement* own = root.FirstChildElement("haptic:sensor"); own; own = own->NextSiblingElement("haptic:sensor")) {
    if (own->Attribute("name")) names.insert(own->Attribute("name"));
  }
  std::vector<std::pair<XmlElement*, std::string>> sensors;  // with their references
  for (XmlElement* gazebo = root.FirstChildElement("gazebo"); gazebo; gazebo = gazebo->NextSiblingElement("gazebo")) {
    const char* reference = gazebo->Attribute("reference");
    for (XmlElement* sensor = gazebo->FirstChildElement("sensor"); sensor; sensor = sensor->NextSiblingElement("sensor")) {
      sensors.emplace_back(sensor, reference ? reference : "");
    }
  }
  std::string left_out, turned;
  const auto list = [](std::string& all, const std::string& one) { all += (all.empty() ? "" : ", ") + one; };
  for (const auto& [sensor, reference] : sensors) {
    const std::string given = sensor->Attribute("name") ? sensor->Attribute("name") : reference;
    const std::string where = robot.xml.at(*sensor);
    std::string name = topicName(given);
    if (names.count(name)) name = topicName(reference + "_" + name);
    for (int i = 2; names.count(name); ++i) name = topicName(given) + "_" + std::to_string(i);
    Taken taken;
    const std::string why = read(robot, *sensor, reference, taken);
    if (!why.empty()) {
      list(left_out, "'" + given + "' of line " + std::to_string(sensor->GetLineNum()) + " (" + why + ")");
      continue;
    }
    names.insert(name);
    become(taken, name, *sensor);
    root.InsertEndChild(sensor);
    robot.notes.push_back(where + ": Gazebo's sensor '" + given + "' is read as <haptic:sensor name=\"" + name + "\" type=\"" +
                          taken.type + "\"/>");
    if (taken.turned) list(turned, "'" + name + "'");
  }
  if (!left_out.empty()) robot.notes.push_back(robot.xml.path() + ": ignored: Gazebo's sensors " + left_out);
  if (!turned.empty()) {
    robot.warnings.push_back(robot.xml.path() + ": the wrench of " + turned +
                             " is that on the child link in its axes; Gazebo would give it another sign or other axes");
  }
}

}  // namespace haptic
