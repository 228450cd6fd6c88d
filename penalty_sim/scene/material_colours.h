/// Colours of a URDF's materials.
#pragma once
#include <array>
#include <map>
#include <optional>
#include <string>

#include "scene/load_report.h"
#include "scene/robot_file.h"

namespace haptic {

/// Red, green, blue and opacity, each within 0..1.
using Colour = std::array<float, 4>;

/// The colours of one robot's visuals, by URDF's rule: a <material> with a name has the colour of the first
/// one of this name that has rgba, below <robot> before those within links; one without a name has its own.
class MaterialColours {
 public:
  /// Reads all materials of `robot`. An rgba that is not four finite numbers is left out with a warning in
  /// `said`, values outside of 0..1 become the nearest.
  MaterialColours(const RobotFile& robot, LoadReport& said);

  /// Nothing where the visual has no material, or one without a colour.
  std::optional<Colour> of(const XmlElement& visual) const;

 private:
  std::map<std::string, Colour> named_;
  std::map<const XmlElement*, Colour> nameless_;
};

}  // namespace haptic
