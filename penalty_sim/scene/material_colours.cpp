#include "scene/material_colours.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/parse_numbers.h"

namespace haptic {
namespace {

std::string nameOf(const XmlElement& material) {
  const char* name = material.Attribute("name");
  return name ? name : "";
}

std::optional<Colour> readColour(const RobotFile& robot, const XmlElement& material, LoadReport& said) {
  const XmlElement* const element = material.FirstChildElement("color");
  const char* const rgba = element ? element->Attribute("rgba") : nullptr;
  if (!rgba) return std::nullopt;
  const auto numbers = parseNumbers(rgba);
  const auto finite = [](double number) { return std::isfinite(number); };
  if (!numbers || numbers->size() != 4 || !std::all_of(numbers->begin(), numbers->end(), finite)) {
    said.warnings.push_back(
        robot.xml.at(*element) + ": material '" + nameOf(material) + "': rgba=\"" + rgba +
        "\" is not four finite numbers and is left out; write red, green, blue and opacity from 0 to 1");
    return std::nullopt;
  }
  Colour colour;
  for (std::size_t i = 0; i < colour.size(); ++i)
    colour[i] = static_cast<float>(std::clamp((*numbers)[i], 0.0, 1.0));
  return colour;
}

}  // namespace

MaterialColours::MaterialColours(const RobotFile& robot, LoadReport& said) {
  const auto read = [&](const XmlElement& material) {
    const auto colour = readColour(robot, material, said);
    const std::string name = nameOf(material);
    if (!colour) return;
    if (name.empty()) {
      nameless_.emplace(&material, *colour);
    } else {
      named_.emplace(name, *colour);
    }
  };
  const XmlElement* const root = robot.xml.root();
  for (auto* material = root->FirstChildElement("material"); material;
       material = material->NextSiblingElement("material"))
    read(*material);
  for (const LinkXml& link : robot.links) {
    const XmlElement* visual = link.element->FirstChildElement("visual");
    for (; visual; visual = visual->NextSiblingElement("visual")) {
      if (const XmlElement* material = visual->FirstChildElement("material")) read(*material);
    }
  }
}

std::optional<Colour> MaterialColours::of(const XmlElement& visual) const {
  const XmlElement* const material = visual.FirstChildElement("material");
  if (!material) return std::nullopt;
  const auto nameless = nameless_.find(material);
  if (nameless != nameless_.end()) return nameless->second;
  const auto named = named_.find(nameOf(*material));
  return named == named_.end() ? std::nullopt : std::optional<Colour>(named->second);
}

}  // namespace haptic
