#include "robots_numbers.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <random>
#include <set>
#include <sstream>

#include "figure.h"
#include "haptic_core/base/error.h"
#include "haptic_core/base/parse_numbers.h"
#include "robots_files.h"
#include "scene/check_report.h"
#include "scene/robot_file.h"
#include "scene/scene_file.h"
#include "scene/text_file.h"

namespace haptic::bench {
namespace {

/// A number in a file: element, attribute, which of its numbers.
struct Slot {
  XmlElement* element;
  const char* attribute;
  std::size_t index;
  std::string kind, owner;
};

class Slots {
 public:
  explicit Slots(XmlElement& robot) {
    for (XmlElement* link = robot.FirstChildElement("link"); link; link = link->NextSiblingElement("link")) addLink(*link);
    for (XmlElement* joint = robot.FirstChildElement("joint"); joint; joint = joint->NextSiblingElement("joint")) addJoint(*joint);
  }
  std::map<std::string, std::vector<Slot>> by_kind;

 private:
  void add(XmlElement* element, const char* attribute, const char* kind, const char* owner) {
    const char* text = element ? element->Attribute(attribute) : nullptr;
    const auto numbers = text ? parseNumbers(text) : std::nullopt;
    for (std::size_t i = 0; numbers && i < numbers->size(); ++i) by_kind[kind].push_back({element, attribute, i, kind, owner ? owner : ""});
  }
  void addLink(XmlElement& link) {
    const char* name = link.Attribute("name");
    if (XmlElement* inertial = link.FirstChildElement("inertial")) {
      add(inertial->FirstChildElement("mass"), "value", "mass", name);
      for (const char* entry : {"ixx", "iyy", "izz", "ixy", "ixz", "iyz"}) add(inertial->FirstChildElement("inertia"), entry, "inertia",
          name);
      add(inertial->FirstChildElement("origin"), "xyz", "centre", name);
      add(inertial->FirstChildElement("origin"), "rpy", "angle", name);
    }
    for (XmlElement* part = link.FirstChildElement("collision"); part; part = part->NextSiblingElement("collision")) {
      add(part->FirstChildElement("origin"), "xyz", "centre", name);
      add(part->FirstChildElement("origin"), "rpy", "angle", name);
      XmlElement* geometry = part->FirstChildElement("geometry");
      XmlElement* shape = geometry ? geometry->FirstChildElement() : nullptr;
      for (const char* attribute : {"size", "radius", "length"}) add(shape, attribute, "size", name);
      add(shape, "scale", "scale", name);
    }
  }
  void addJoint(XmlElement& joint) {
    const char* name = joint.Attribute("name");
    add(joint.FirstChildElement("origin"), "xyz", "centre", name);
    add(joint.FirstChildElement("origin"), "rpy", "angle", name);
    const char* type = joint.Attribute("type");
    if (!type || std::string(type) == "fixed") return;  // the rest means nothing there
    add(joint.FirstChildElement("axis"), "xyz", "axis", name);
    XmlElement* limit = joint.FirstChildElement("limit");
    add(limit, "effort", "effort", name);
    add(limit, "velocity", "velocity", name);
    if (std::string(type) == "continuous") return;
    add(limit, "lower", "limit", name);
    add(limit, "upper", "limit", name);
  }
};

std::string written(double number) {
  std::ostringstream text;
  text.precision(9);
  text << number;
  return text.str();
}

/// The number made wrong; the same: this kind has no such fault.
double made(const std::string& kind, double number, std::mt19937& random) {
  const double factors[] = {0, 1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9};
  const std::set<std::string> signed_kinds = {"mass", "inertia", "size", "scale", "effort", "velocity"};
  const unsigned choice = random() % 11;
  if (choice == 7) return NAN;
  if (choice == 8) return INFINITY;
  if (choice == 9) return signed_kinds.count(kind) ? -1 : number;
  if (choice == 10) return kind == "axis" ? 0 : kind == "angle" ? number * 180 / M_PI : number;
  return number * factors[choice];
}

void put(const Slot& slot, double number) {
  auto numbers = *parseNumbers(slot.element->Attribute(slot.attribute));
  std::string text;
  for (std::size_t i = 0; i < numbers.size(); ++i) text += (i > 0 ? " " : "") + written(i == slot.index ? number : numbers[i]);
  slot.element->SetAttribute(slot.attribute, text.c_str());
}

/// In the printer's own lines, so that those of two texts are the same where the texts are.
std::string printed(XmlFile& xml) {
  tinyxml2::XMLPrinter printer;
  xml.root()->GetDocument()->Print(&printer);
  return printer.CStr();
}

/// All lines of a check of a text that stands for the file.
std::set<std::string> linesOf(const std::string& file, const std::string& text) {
  SceneOptions options;
  options.default_density = 1000;
  options.missing = MissingMeshes::kBox;
  options.add_pointer = false;
  options.text = text;
  std::set<std::string> lines;
  try {
    const SceneDef scene = loadScene(file, options);
    const CheckReport report = checkReport(scene, Certificate{});
    for (const auto* section : {&report.replaced, &report.warnings, &report.weak_drives, &report.start, &report.chosen})
      lines.insert(section->begin(), section->end());
  } catch (const SetupError& refused) {
    lines.insert(std::string("refused: ") + refused.what());
  }
  return lines;
}

/// By what matter and robots can be, not by the loader's bounds. A number that means no more than another one that is right is sound.
bool isSound(const Slot& slot, double before, double now) {
  const double size = std::abs(now);
  if (!std::isfinite(now)) return false;
  if (slot.kind == "centre") return size <= 0.3 || size <= 3 * std::abs(before);
  if (slot.kind == "angle") return size <= 2 * M_PI;
  if (slot.kind == "mass") return now >= 0.05 * before && now <= 20 * before;
  if (slot.kind == "inertia") {
    const bool diagonal = slot.attribute[1] == slot.attribute[2];
    if (diagonal) return now >= 0.01 * before && now <= 20 * before;
    const double largest = std::max(std::atof(slot.element->Attribute("ixx")), std::atof(slot.element->Attribute("iyy")));
    return size <= std::max(std::abs(before), 0.1 * largest);  // a product of inertia may be small
  }
  if (slot.kind == "size") return now >= 1e-3 && now <= 3 * std::max(before, 0.1);
  if (slot.kind == "scale") return now == -before || (size >= 1e-3 * 0.99 && size < 50
      && size <= 3 * std::abs(before));  // a mirror, millimetres
  if (slot.kind == "effort") return now >= 0.1 * before && now < 1e5;
  if (slot.kind == "velocity") return now >= 0.01 && now < 1e5;
  if (slot.kind == "limit") return size <= 2 * M_PI;
  return size > 0 || before == 0;  // axes are directions, as long as one number is left
}

}  // namespace

void measureOddNumbers() {
  constexpr int kFiles = 200;
  std::mt19937 random(66);
  std::map<std::string, std::set<std::string>> before;
  std::vector<std::string> files;
  for (const std::string& file : robotFiles()) {
    if (file.size() > 5 && file.compare(file.size() - 5, 5, ".urdf") == 0) files.push_back(file);
  }
  const std::vector<std::string> kinds = {"mass", "inertia", "centre", "size", "effort", "velocity", "limit", "axis", "angle", "scale"};
  int unsaid = 0, sound = 0, refused = 0;
  for (int made_wrong = 0; made_wrong < kFiles;) {
    const std::string& file = files[random() % files.size()];
    const std::string& kind = kinds[random() % kinds.size()];
    XmlFile xml(file, readTextFile(file));
    const Slots slots(*xml.root());
    const auto of_kind = slots.by_kind.find(kind);
    if (of_kind == slots.by_kind.end()) continue;
    const Slot slot = of_kind->second[random() % of_kind->second.size()];
    const double number = (*parseNumbers(slot.element->Attribute(slot.attribute)))[slot.index], wrong = made(kind, number, random);
    if (wrong == number) continue;
    if (!before.count(file)) before[file] = linesOf(file, printed(xml));
    if (before[file].size() == 1 && before[file].begin()->rfind("refused", 0) == 0) continue;
    put(slot, wrong);
    ++made_wrong;
    bool said = false, is_refused = false;
    for (const std::string& line : linesOf(file, printed(xml))) {
      is_refused |= line.rfind("refused", 0) == 0;
      const bool tag = line.find(slot.element->Name()) != std::string::npos || line.find(" m large") != std::string::npos;
      said |= !before[file].count(line) && (is_refused || (line.find("'" + slot.owner + "'") != std::string::npos && tag));
    }
    refused += is_refused;
    if (said && !is_refused) continue;
    const bool is_sound = !said && isSound(slot, number, wrong);
    (is_refused ? refused : is_sound ? sound : unsaid) += is_refused ? 0 : 1;
    std::printf("number %s|%s|'%s' <%s> %s %s -> %s\n", is_refused ? "refused" : is_sound ? "sound" : "unsaid", file.c_str(),
        slot.owner.c_str(),
                slot.element->Name(), slot.attribute, written(number).c_str(), written(wrong).c_str());
  }
  figure("robots.odd_numbers_unsaid", unsaid, "1");
  figure("robots.odd_but_sound", sound, "1");
  figure("robots.odd_refused", refused, "1");
}

void measureFalseAlarms() {
  int files = 0, alarmed = 0;
  for (const std::string& file : robotFiles()) {
    if (file.find("/cases/") != std::string::npos) continue;  // these are wrong on purpose
    SceneOptions options;
    options.default_density = 1000;
    options.missing = MissingMeshes::kBox;
    options.add_pointer = false;
    try {
      const SceneDef scene = loadScene(file, options);
      ++files;
      bool numbers = false;
      for (const std::string& line : scene.warnings) {
        std::printf("to mend|%s\n", line.c_str());
        numbers |= line.find(": <") != std::string::npos || line.find(" m large") != std::string::npos;
      }
      for (const std::string& line : scene.replaced) std::printf("replaced|%s\n", line.c_str());
      alarmed += numbers;
    } catch (const SetupError& refused) {
      std::printf("refused|%s\n", refused.what());
    }
  }
  figure("robots.alarmed_files", alarmed, "1");
  figure("robots.judged_files", files, "1");
}

}  // namespace haptic::bench
