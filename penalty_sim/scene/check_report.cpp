#include "scene/check_report.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "scene/contact_properties.h"
#include "scene/joint_reading.h"

namespace haptic {
namespace {

using Lines = std::vector<std::string> CheckReport::*;

/// Fields in the order of the text, with their names for people and programs.
constexpr struct {
  Lines lines;
  const char *title, *key;
} kSections[] = {{&CheckReport::replaced, "replaced, shapes in magenta", "replaced"},
                 {&CheckReport::warnings, "to mend", "warnings"},
                 {&CheckReport::hands, "what a hand feels and carries", "hands"},
                 {&CheckReport::weak_drives, "drives that cannot hold the start pose", "weak_drives"},
                 {&CheckReport::start, "at the start", "start"},
                 {&CheckReport::chosen, "chosen", "chosen"},
                 {&CheckReport::size, "size", "size"},
                 {&CheckReport::collisions, "collisions", "collisions"},
                 {&CheckReport::cost, "cost", "cost"},
                 {&CheckReport::deadline, "deadline", "deadline"},
                 {&CheckReport::stability, "stability", "stability"}};

std::string counted(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

void countParts(const SceneDef& scene, CheckReport& report) {
  int moving = 0, shapes = 0;
  for (const ArticulationDef& tree : scene.world.articulations) {
    for (const LinkDef& link : tree.links) {
      moving += link.joint.type != JointType::kFixed;
      shapes += static_cast<int>(link.collisions.size());
    }
  }
  const Vector3& g = scene.world.settings.gravity;
  std::ostringstream text;
  text << counted(scene.world.articulations.size(), "body or tree") << ", " << moving << " moving links, " << scene.joints
       << " joints in the files; " << scene.collisions_loaded << " of " << scene.collisions_tried << " collisions as " << shapes
       << " convex shapes, " << scene.world.filters.size() << " filtered pairs; step " << 1e3 * scene.world.settings.step
       << " ms, gravity " << g.x() << " " << g.y() << " " << g.z() << " m/s²";
  std::string line = text.str();
  const std::size_t plural = line.find("body or trees");
  if (plural != std::string::npos) line.replace(plural, 13, "bodies and trees");
  report.size = {line};
}

/// What is chosen or given of "stiffness 1e+06 N/m³ (default), mu_static 0.5".
std::string withoutDefaults(const std::string& values) {
  std::string kept;
  for (std::size_t begin = 0; begin < values.size();) {
    const std::size_t end = std::min(values.find(", ", begin), values.size());
    const std::string value = values.substr(begin, end - begin);
    if (value.find("(default)") == std::string::npos) kept += (kept.empty() ? "" : ", ") + value;
    begin = end + 2;
  }
  return kept;
}

/// Collisions with the same shape, values and source are one line.
void groupCollisions(const SceneDef& scene, CheckReport& report) {
  std::vector<std::pair<std::string, std::vector<std::string>>> groups;
  for (const CollisionReport& collision : scene.collisions) {
    const std::string values = withoutDefaults(contactText(collision.material, scene.world.settings.default_material));
    // The listing's place differs from link to link, and says nothing of the surface.
    const std::string source = collision.material_source.substr(0, collision.material_source.find(", line "));
    const std::string text = collision.text + (values.empty() ? "" : "; " + values) + "; source: " + source;
    auto group = groups.begin();
    while (group != groups.end() && group->first != text) ++group;
    if (group == groups.end()) group = groups.insert(group, {text, {}});
    group->second.push_back(collision.link);
  }
  for (const auto& [text, links] : groups) {
    std::string names;
    for (std::size_t i = 0; i < links.size() && i < kMostLines; ++i) names += (i > 0 ? ", " : "") + links[i];
    if (links.size() > kMostLines) names += ", … (" + std::to_string(links.size()) + ")";
    report.collisions.push_back(names + ": " + text);
  }
}

void judgeStart(const SceneDef& scene, CheckReport& report) {
  for (const StartContact& contact : scene.start_contacts) {
    if (contact.filtered) continue;  // a warning says so
    std::ostringstream text;
    text.precision(3);
    text << "'" << contact.a << "' and '" << contact.b << "' overlap by " << 1e3 * contact.depth << " mm";
    report.start.push_back(text.str());
  }
  for (const ArticulationDef& tree : scene.world.articulations) {
    for (const LinkDef& link : tree.links) {
      const JointDef& joint = link.joint;
      if (!isScalar(joint.type) || (joint.position >= joint.lower && joint.position <= joint.upper)) continue;
      std::ostringstream text;
      text << "joint '" << joint.name << "' at " << joint.position << " is beyond its limits [" << joint.lower << ", " << joint.upper
           << "]";
      report.start.push_back(text.str());
    }
    for (const HoldingEffort& drive : holdingEfforts(tree, scene.world.settings.gravity)) {
      if (drive.asked <= drive.limit) continue;
      std::ostringstream text;
      text.precision(4);
      text << "'" << drive.joint << "' asks for " << drive.asked << (drive.turns ? " N·m" : " N") << ", its limit is " << drive.limit;
      report.weak_drives.push_back(text.str());
    }
  }
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : SetupError::oneLine(text)) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

}  // namespace

CheckReport checkReport(const SceneDef& scene, const Certificate& certificate) {
  CheckReport report;
  report.replaced = scene.replaced;
  report.warnings = scene.warnings;
  report.chosen = scene.notes;
  countParts(scene, report);
  groupCollisions(scene, report);
  judgeStart(scene, report);
  std::istringstream lines(certificate.text());
  for (std::string line; std::getline(lines, line);) {
    const bool verdict = report.stability.empty(), island = line.rfind("  island", 0) == 0;
    if (verdict || (island && line.find(": PASS") == std::string::npos)) report.stability.push_back(verdict ? line : line.substr(2));
  }
  return report;
}

void judge(const SceneDef& scene, const Certificate& certificate, bool rings, CheckReport& report) {
  std::vector<std::string> but;
  if (certificate.verdict != Verdict::kPass) but.push_back("it buckles or topples under its own weight");
  if (!report.replaced.empty()) but.push_back(counted(report.replaced.size(), "part") + " replaced");
  if (!report.weak_drives.empty()) but.push_back(counted(report.weak_drives.size(), "drive") + " too weak for the start pose");
  if (!report.warnings.empty()) but.push_back(counted(report.warnings.size(), "warning"));
  report.verdict = std::string(rings ? "RINGS" : "PASS") + ": '" + scene.world.name + "' loads" +
                   (rings ? ", and a hand rings on it" : report.hands.empty() ? "" : " and a hand bears it");
  for (std::size_t i = 0; i < but.size(); ++i) report.verdict += (i == 0 ? "; " : ", ") + but[i];
  report.verdict += " (" + scene.file + ")";
}

std::string checkText(const CheckReport& report) {
  std::ostringstream out;
  out << report.verdict << "\n";
  for (const auto& section : kSections) {
    const std::vector<std::string>& lines = report.*section.lines;
    if (lines.empty()) continue;
    out << section.title << ":\n";
    const std::size_t shown = lines.size() > kMostLines ? kMostLines - 1 : lines.size();
    for (std::size_t i = 0; i < shown; ++i) out << (lines[i].rfind("hand ", 0) == 0 ? "" : "  ") << lines[i] << "\n";
    if (shown < lines.size()) out << "  … and " << lines.size() - shown << " more: --all\n";
  }
  return out.str();
}

std::string checkJson(const CheckReport& report) {
  std::string out = "{\"verdict\": " + quoted(report.verdict);
  for (const auto& section : kSections) {
    out += std::string(", \"") + section.key + "\": [";
    const std::vector<std::string>& lines = report.*section.lines;
    for (std::size_t i = 0; i < lines.size(); ++i) out += (i > 0 ? ", " : "") + quoted(lines[i]);
    out += "]";
  }
  return out + "}\n";
}

}  // namespace haptic
