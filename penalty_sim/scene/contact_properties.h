/// Contact properties of a <collision>: <haptic:contact> first, then what other simulators wrote.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "haptic_core/world/definition.h"
#include "scene/robot_file.h"

namespace haptic {

/// Reads <haptic:contact> (attributes, or children of the same names with value="..."): stiffness [N/m³],
/// damping [N·s/m³], dissipation [s/m], tangential_stiffness [N/m³], tangential_damping [N·s/m³], mu_static,
/// mu_dynamic. Values in `material` that the element does not name stay. Throws SetupError for unknown names
/// and values out of range (negative, NaN, μ > 10, μ > μ0).
void readContact(const XmlFile& file, const XmlElement& element, ContactMaterial& material);

/// The properties of collisions of one robot.
class ContactProperties {
 public:
  /// Reads the `<gazebo>` tags once.
  explicit ContactProperties(const RobotFile& robot);

  /// Material and its source ("haptic:contact, line 12; mu from <gazebo>, line 40"). `half_extent` [m] of the
  /// shape turns Drake's modulus [Pa] into a foundation stiffness. Values of other simulators that have no
  /// physical meaning here are named in `notes` once per kind.
  ContactMaterial of(const LinkXml& link, const XmlElement& collision, double half_extent,
                     std::string& source, std::vector<std::string>& notes);

 private:
  bool fromDrake(const XmlElement& collision, double half_extent, ContactMaterial& material,
                 std::string& source, std::vector<std::string>& notes);
  void fromBullet(const LinkXml& link, ContactMaterial& material, std::string& source,
                  std::vector<std::string>& notes);
  void fromGazebo(const LinkXml& link, ContactMaterial& material, std::string& source,
                  std::vector<std::string>& notes);
  void noteOnce(const std::string& text, std::vector<std::string>& notes);

  const RobotFile& robot_;
  std::map<std::string, std::vector<const XmlElement*>> gazebo_;  ///< <gazebo reference=LINK>
  std::map<std::string, bool> noted_;
};

/// "stiffness 1e+06 N/m³, mu_static 0.5 (default) …": what the world takes for two such surfaces in touch;
/// values that the files do not give are marked.
std::string contactText(const ContactMaterial& material, const ContactMaterial& defaults);

}  // namespace haptic
