#include "scene/contact_properties.h"

#include <cmath>
#include <cstring>
#include <sstream>

namespace haptic {
namespace {

struct Property {
  const char* name;
  double ContactMaterial::*value;
  const char* unit;
};

constexpr Property kProperties[] = {
    {"stiffness", &ContactMaterial::stiffness, "N/m³"},
    {"damping", &ContactMaterial::damping, "N·s/m³"},
    {"dissipation", &ContactMaterial::dissipation, "s/m"},
    {"tangential_stiffness", &ContactMaterial::tangential_stiffness, "N/m³"},
    {"tangential_damping", &ContactMaterial::tangential_damping, "N·s/m³"},
    {"mu_static", &ContactMaterial::mu_static, ""},
    {"mu_dynamic", &ContactMaterial::mu_dynamic, ""},
};

const Property* propertyNamed(const std::string& name) {
  for (const Property& property : kProperties) {
    if (name == property.name) return &property;
  }
  return nullptr;
}

std::string knownProperties() {
  std::string list;
  for (const Property& property : kProperties)
    list += (list.empty() ? "" : ", ") + std::string(property.name);
  return list;
}

/// <drake:x value="1"/>, <mu1>1</mu1> and <mu1 value="1"/> are all in use.
std::optional<double> childValue(const XmlFile& file, const XmlElement& parent, const char* name) {
  const XmlElement* child = parent.FirstChildElement(name);
  if (!child) return std::nullopt;
  if (child->Attribute("value")) return readNumber(file, *child, "value");
  const auto numbers = parseNumbers(child->GetText() ? child->GetText() : "");
  if (!numbers || numbers->size() != 1 || !std::isfinite((*numbers)[0])) {
    throw SetupError(file.at(*child) + ": <" + name + ">", "holds no number", "write one finite number");
  }
  return (*numbers)[0];
}

std::string line(const XmlElement& element) {
  return "line " + std::to_string(element.GetLineNum());
}

void setFriction(double mu_static, double mu_dynamic, ContactMaterial& material) {
  material.mu_static = mu_static;
  material.mu_dynamic = mu_dynamic;
}

}  // namespace

void readContact(const XmlFile& file, const XmlElement& element, ContactMaterial& material) {
  const std::string where = file.at(element) + ": <" + element.Name() + ">";
  for (const auto* attribute = element.FirstAttribute(); attribute; attribute = attribute->Next()) {
    const Property* property = propertyNamed(attribute->Name());
    if (!property) {
      throw SetupError(where, std::string("unknown attribute '") + attribute->Name() + "'",
                       "known: " + knownProperties());
    }
    material.*property->value = *readNumber(file, element, property->name);
  }
  for (const XmlElement* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
    const char* name = child->Name();
    const Property* property = propertyNamed(std::strncmp(name, "haptic:", 7) == 0 ? name + 7 : name);
    if (!property) {
      throw SetupError(file.at(*child) + ": <" + name + ">", "is unknown in <haptic:contact>",
                       "known: " + knownProperties());
    }
    material.*property->value = *childValue(file, element, name);
  }
  check(material, where);
}

ContactProperties::ContactProperties(const RobotFile& robot) : robot_(robot) {
  for (const XmlElement* element = robot.xml.root()->FirstChildElement("gazebo"); element;
       element = element->NextSiblingElement("gazebo")) {
    if (const char* reference = element->Attribute("reference")) gazebo_[reference].push_back(element);
  }
}

ContactMaterial ContactProperties::of(const LinkXml& link, const XmlElement& collision, double half_extent,
                                      std::string& source, std::vector<std::string>& notes) {
  ContactMaterial material;
  if (const XmlElement* contact = collision.FirstChildElement("haptic:contact")) {
    readContact(robot_.xml, *contact, material);
    source = "haptic:contact, " + line(*contact);
  } else if (!fromDrake(collision, half_extent, material, source, notes)) {
    fromBullet(link, material, source, notes);
    if (source.empty()) fromGazebo(link, material, source, notes);
  }
  if (source.empty()) source = "default";
  check(material, robot_.at(link));
  return material;
}

bool ContactProperties::fromDrake(const XmlElement& collision, double half_extent, ContactMaterial& material,
                                  std::string& source, std::vector<std::string>& notes) {
  const XmlElement* drake = collision.FirstChildElement("drake:proximity_properties");
  if (!drake) return false;
  const auto mu_static = childValue(robot_.xml, *drake, "drake:mu_static");
  const auto mu_dynamic = childValue(robot_.xml, *drake, "drake:mu_dynamic");
  if (mu_static || mu_dynamic)
    setFriction(mu_static.value_or(*mu_dynamic), mu_dynamic.value_or(*mu_static), material);
  if (const auto dissipation = childValue(robot_.xml, *drake, "drake:hunt_crossley_dissipation")) {
    material.dissipation = *dissipation;
  }
  if (const auto modulus = childValue(robot_.xml, *drake, "drake:hydroelastic_modulus")) {
    material.stiffness = *modulus / half_extent;
    std::ostringstream text;
    text << "Drake's hydroelastic_modulus is a pressure: divided by the shape's half extent (" << *modulus
         << " Pa / " << half_extent << " m at " << robot_.xml.at(*drake) << ")";
    noteOnce(text.str(), notes);
  }
  if (drake->FirstChildElement("drake:point_contact_stiffness")) {
    noteOnce(
        "Drake's point_contact_stiffness [N/m] has no area and is not used: give <haptic:contact "
        "stiffness=...> in N/m³",
        notes);
  }
  source = "drake:proximity_properties, " + line(*drake);
  return true;
}

void ContactProperties::fromBullet(const LinkXml& link, ContactMaterial& material, std::string& source,
                                   std::vector<std::string>& notes) {
  const XmlElement* contact = link.element->FirstChildElement("contact");
  if (!contact) return;
  if (const auto mu = childValue(robot_.xml, *contact, "lateral_friction")) {
    setFriction(*mu, *mu, material);
    source = "Bullet <contact>, " + line(*contact);
  }
  for (const char* name :
       {"stiffness", "damping", "contact_cfm", "contact_erp", "rolling_friction", "spinning_friction"}) {
    if (contact->FirstChildElement(name)) {
      noteOnce(std::string("Bullet's ") + name +
                   " depends on mass and step and is not used: give <haptic:contact>",
               notes);
    }
  }
}

void ContactProperties::fromGazebo(const LinkXml& link, ContactMaterial& material, std::string& source,
                                   std::vector<std::string>& notes) {
  const auto found = gazebo_.find(link.name);
  if (found == gazebo_.end()) return;
  for (const XmlElement* element : found->second) {
    // mu1 and mu2 are two directions, not static and dynamic: mu1 serves for both.
    if (const auto mu = childValue(robot_.xml, *element, "mu1")) {
      // Gazebo's own default for "does not slip" is a huge number; any limit above the range of real pairs
      // means that.
      const double bounded = std::min(*mu, 10.0);
      if (bounded < *mu)
        noteOnce("Gazebo's mu1 above 10 is taken as 10 (" + robot_.xml.at(*element) + ")", notes);
      setFriction(bounded, bounded, material);
      source = "gazebo mu1, " + line(*element);
    }
    for (const char* name : {"kp", "kd"}) {
      if (element->FirstChildElement(name)) {
        noteOnce(std::string("Gazebo's ") + name +
                     " is a solver's number, not a foundation's, and is not used: give <haptic:contact>",
                 notes);
      }
    }
  }
}

void ContactProperties::noteOnce(const std::string& text, std::vector<std::string>& notes) {
  if (!noted_.emplace(text, true).second) return;
  notes.push_back(text);
}

std::string contactText(const ContactMaterial& material, const ContactMaterial& defaults) {
  const ContactMaterial effective = combine(material, material, defaults);
  std::ostringstream text;
  for (const Property& property : kProperties) {
    const double value = effective.*property.value;
    if (std::isnan(value)) continue;
    text << (text.tellp() > 0 ? ", " : "") << property.name << " " << value << (*property.unit ? " " : "")
         << property.unit << (std::isnan(material.*property.value) ? " (default)" : "");
  }
  return text.str();
}

}  // namespace haptic
