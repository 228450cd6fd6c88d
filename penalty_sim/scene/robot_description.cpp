#include "scene/robot_description.h"

#include <tinyxml2.h>

#include <cstring>

namespace haptic {
namespace {

void prefixed(tinyxml2::XMLElement& element, const char* attribute, const std::string& prefix) {
  if (const char* name = element.Attribute(attribute)) element.SetAttribute(attribute, (prefix + name).c_str());
}

}  // namespace

std::string robotDescription(const std::string& text, const std::string& prefix) {
  tinyxml2::XMLDocument document;
  if (prefix.empty() || document.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS || !document.RootElement()) return text;
  for (tinyxml2::XMLElement* part = document.RootElement()->FirstChildElement(); part; part = part->NextSiblingElement()) {
    const bool is_link = std::strcmp(part->Name(), "link") == 0, is_joint = std::strcmp(part->Name(), "joint") == 0;
    if (is_link && part->Attribute("name", "world")) continue;  // the world has one name in all models
    if (is_link || is_joint) prefixed(*part, "name", prefix);
    for (tinyxml2::XMLElement* end = is_joint ? part->FirstChildElement() : nullptr; end; end = end->NextSiblingElement()) {
      const bool to_link = std::strcmp(end->Name(), "parent") == 0 || std::strcmp(end->Name(), "child") == 0;
      if (to_link && !end->Attribute("link", "world")) prefixed(*end, "link", prefix);
      if (std::strcmp(end->Name(), "mimic") == 0) prefixed(*end, "joint", prefix);
    }
  }
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

}  // namespace haptic
