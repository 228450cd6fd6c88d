#include "scene/contact_properties.h"

#include <cmath>
#include <cstring>
#include <sstream>

#include "haptic_core/base/parse_numbers.h"
#include "haptic_core/contact/elastic_layer.h"

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
  return list + ", young_modulus, material";
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

GivenSolid givenSolid(const std::string& name, double young_modulus, const std::string& where) {
  if (name.empty()) {
    if (young_modulus > 0 && std::isfinite(young_modulus)) return {"", young_modulus, kUsualPoissonRatio};
    std::ostringstream is;
    is << "young_modulus [Pa] is " << young_modulus;
    throw SetupError(where, is.str(), "give a finite number > 0");
  }
  if (const Solid* solid = solidNamed(name)) return {solid->name, solid->young_modulus, solid->poisson_ratio};
  std::string known;
  for (const Solid& solid : kSolids) known += (known.empty() ? "" : ", ") + std::string(solid.name);
  throw SetupError(where, "material '" + name + "' is unknown", "known: " + known + "; or give young_modulus in Pa");
}

double givenStiffness(const std::string& text, const std::function<double()>& number, const std::string& where) {
  if (text == "rigid") return ContactMaterial::kRigid;
  const bool word = !text.empty() && text.find_first_of("0123456789") == std::string::npos;
  if (word) throw SetupError(where, "stiffness is '" + text + "'", "give a finite number > 0 in N/m³, or rigid");
  return number();
}

double stiffnessOf(const GivenSolid& solid, double extent, std::string& source) {
  std::ostringstream text;
  text << (solid.name.empty() ? "" : solid.name + ", ") << "E " << solid.young_modulus << " Pa · "
       << confinement(solid.poisson_ratio) << " (ν " << solid.poisson_ratio << ") over the least extent, " << extent << " m";
  if (const Solid* known = solidNamed(solid.name)) text << " [" << known->source << "]";
  source = text.str();
  return surfaceStiffness(solid.young_modulus, solid.poisson_ratio, extent);
}

void readContact(const XmlFile& file, const XmlElement& element, ContactMaterial& material, GivenSolid& solid) {
  const std::string where = file.at(element) + ": <" + element.Name() + ">";
  std::optional<double> modulus;
  std::string name;
  const auto take = [&](const std::string& key, const auto& number, const char* text) {
    const Property* property = propertyNamed(key);
    if (property && property->value == &ContactMaterial::stiffness) {
      material.stiffness = givenStiffness(text ? text : "", number, where);
    } else if (property) {
      material.*property->value = number();
    } else if (key == "young_modulus") {
      modulus = number();
    } else if (key == "material" && text && *text) {
      name = text;
    } else {
      return false;
    }
    return true;
  };
  const double before = material.stiffness;
  material.stiffness = ContactMaterial::kUnset;
  for (const auto* attribute = element.FirstAttribute(); attribute; attribute = attribute->Next()) {
    const auto number = [&] { return *readNumber(file, element, attribute->Name()); };
    if (take(attribute->Name(), number, attribute->Value())) continue;
    throw SetupError(where, std::string("unknown attribute '") + attribute->Name() + "'", "known: " + knownProperties());
  }
  for (const XmlElement* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
    const char* key = child->Name();
    const auto number = [&] { return *childValue(file, element, key); };
    const char* text = child->Attribute("value") ? child->Attribute("value") : child->GetText();
    if (take(std::strncmp(key, "haptic:", 7) == 0 ? key + 7 : key, number, text)) continue;
    throw SetupError(file.at(*child) + ": <" + key + ">", "is unknown in <haptic:contact>", "known: " + knownProperties());
  }
  takeSolid(name, modulus, before, where, material, solid);
  check(material, where);
}

void takeSolid(const std::string& name, const std::optional<double>& modulus, double before, const std::string& where,
               ContactMaterial& material, GivenSolid& solid) {
  const bool stiffness = !std::isnan(material.stiffness);
  if (stiffness + modulus.has_value() + !name.empty() > 1) {
    throw SetupError(where, "says twice how stiff it is", "give one of stiffness, young_modulus and material");
  }
  if (modulus || !name.empty()) {
    solid = givenSolid(name, modulus.value_or(0), where);
  } else if (stiffness) {
    solid = {};
  } else {
    material.stiffness = before;
  }
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
    GivenSolid solid;
    readContact(robot_.xml, *contact, material, solid);
    std::string reason;
    if (solid) material.stiffness = stiffnessOf(solid, 2 * half_extent, reason);
    source = "haptic:contact, " + line(*contact) + (reason.empty() ? "" : ": " + reason);
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
  const bool rigid = material.rigid() || (defaults.rigid() && !material.saysNumber());
  const bool chosen = !rigid && std::isnan(defaults.stiffness) && (material.rest_stiffness > 0 || material.touch_stiffness > 0);
  std::ostringstream text;
  for (const Property& property : kProperties) {
    const double value = effective.*property.value;
    if (std::isnan(value)) continue;
    text << (text.tellp() > 0 ? ", " : "") << property.name << " " << value << (*property.unit ? " " : "")
         << property.unit;
    if (rigid && property.value == &ContactMaterial::stiffness) {
      text << " (rigid)";
      continue;
    }
    if (!std::isnan(material.*property.value)) continue;
    text << (chosen && property.value == &ContactMaterial::stiffness ? " (chosen)" : " (default)");
  }
  return text.str();
}

}  // namespace haptic
