/// Contact properties of a <collision>: <haptic:contact> first, then what other simulators wrote.
#pragma once
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "haptic_core/world/definition.h"
#include "scene/robot_file.h"

namespace haptic {

/// What surfaces are made of, in place of a stiffness.
struct GivenSolid {
  std::string name;          ///< of contact/elastic_layer.h; empty: E was given
  double young_modulus = 0;  ///< [Pa]; 0: nothing was given
  double poisson_ratio = 0;  ///< ν [1]
  /// Whether one was given.
  explicit operator bool() const { return young_modulus > 0; }
};

/// By name, or of a modulus [Pa] where the name is empty. Throws SetupError: no such material, a modulus that is not > 0.
GivenSolid givenSolid(const std::string& name, double young_modulus, const std::string& where);
/// k [N/m³] of the text of a stiffness, of which `number` is that as a number. Throws SetupError for other words than rigid.
double givenStiffness(const std::string& text, const std::function<double()>& number, const std::string& where);
/// Stiffness [N/m³] of a surface of a body of that least extent [m]. `source`: how it came about, for listings.
double stiffnessOf(const GivenSolid& solid, double extent, std::string& source);

/// Of one <haptic:contact> or `material:`, after its numbers were read: at most one of stiffness, young_modulus [Pa] and a
/// name; none of them leaves `solid` and the stiffness that was there `before`. Throws SetupError.
void takeSolid(const std::string& name, const std::optional<double>& modulus, double before, const std::string& where,
               ContactMaterial& material, GivenSolid& solid);

/// Reads <haptic:contact> (attributes, or children of the same names with value="..."): stiffness [N/m³], a
/// number or "rigid", or young_modulus [Pa], or material (a name); damping [N·s/m³], dissipation [s/m], tangential_stiffness [N/m³],
/// tangential_damping [N·s/m³], mu_static, mu_dynamic. Values in `material` and `solid` that the element does not name stay;
/// a stiffness and a solid replace one another. Throws SetupError for unknown names, values out of range (negative, NaN,
/// μ > 10, μ > μ0) and more than one of stiffness, young_modulus and material.
void readContact(const XmlFile& file, const XmlElement& element, ContactMaterial& material, GivenSolid& solid);

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
