/// The links that hands move: <haptic:pointer>, and the sphere that stands in where a scene names none.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "haptic_core/loop/delay_line.h"
#include "scene/robot_tree.h"

namespace haptic {

/// Reads one <haptic:pointer link= device= ...> and its waypoints (grip poses in the device's base, times
/// ascending).
void readPointer(const RobotFile& robot, const XmlElement& tag, const ModelSettings& settings,
                 LoadContext& context);

/// What a hand needs to know about its pointer, filled from attributes of a tag or entries of a list.
struct PointerSettings {
  std::string where;  ///< file and line, for errors
  /// Name that the device's driver goes by.
  std::string device = "spidar";
  std::string link;  ///< that the hand moves, with its model's prefix
  /// Direct, or by spring and damper.
  PointerCoupling coupling;
  /// World metres per grip metre, and hand newtons per world newton.
  double scale = 1, force_scale = 1;
  AddedDelay delay;  ///< of the loop, beside the wire's
  std::optional<Pose> X_WB;  ///< device base; nothing: the grip's home is the pointer's initial pose
  /// Of the scripted hand, in the device's base.
  HandPath path;
  int repeat = 1;  ///< the path is run this often, one after the other
};

/// Adds pointer and hand. Throws SetupError: a merged or held link, a device twice, values out of range.
void addPointer(const PointerSettings& settings, LoadContext& context);

/// Coupling by name: direct or virtual. Throws SetupError.
PointerCoupling::Mode couplingMode(const std::string& name, const std::string& where);
/// Whose axes a coupling's values are along: link or grip. Throws SetupError.
PointerCoupling::Axes couplingAxes(const std::string& name, const std::string& where);
/// A value of a coupling: one number for all axes, or three. Throws SetupError that says `what` it is.
void setCouplingValue(const std::vector<double>& numbers, const std::string& what, double& greatest, AxisShares& shares);

/// Adds a sphere of 10 mm as pointer, clear of all collisions, above the highest surface, and a path that
/// presses there and slides. Where that surface does not stay the path waits, above all that its link reaches
/// by turning about its centre of mass. For scenes that name no pointer.
void addDefaultPointer(LoadContext& context);

}  // namespace haptic
