/// The robot-level haptic: tags: <haptic:scene>, <haptic:pointer>, <haptic:collision_filter>, <haptic:loop>, <haptic:force>,
/// <haptic:motion>, <haptic:sensor>.
#pragma once
#include <string>
#include <vector>

#include "scene/robot_tree.h"

namespace haptic {

/// True when any element below `element` (itself included) is in the haptic namespace, those called `but` left out.
bool hasExtension(const XmlElement& element, const std::string& but = {});

/// Refuses haptic: children of `element` that are not in `known`.
void refuseUnknownExtensions(const XmlFile& file, const XmlElement& element,
                             const std::vector<std::string>& known);

/// Refuses haptic: tags at places where none is known, and warns when the prefix is not declared (python's
/// XML parsers then refuse the file). Throws SetupError naming tag and line.
void checkExtensions(RobotFile& robot);

/// Sets one entry of the world's settings from text: step, far_step, gravity, accuracy, pressure_law, energy_ledger.
/// Entries that chose a method before 0.3 (integrator, contact_model) set nothing and leave a line in `warnings`. Throws SetupError for
/// unknown names and bad values.
void setWorldSetting(const std::string& where, const std::string& name, const std::string& value, WorldSettings& settings,
                     std::vector<std::string>& warnings);

/// Reads <haptic:scene> into the world's settings, and the material of surfaces that do not say it themselves.
void readSceneTag(RobotFile& robot, WorldSettings& settings, GivenSolid& solid);

/// Reads pointers with their hands, filters, loops, forces, motions and sensors; names get `prefix`, poses are moved by `X_WM`. All
/// links of the model are in `context.frames`.
void readRelations(const RobotFile& robot, const ModelSettings& settings, LoadContext& context);

/// The place of link `name`. Throws SetupError when there is none.
FramePlace findFrame(const LoadContext& context, const std::string& name, const std::string& where);

/// No collision between two links; a link with itself is left out.
void addFilter(const FramePlace& a, const FramePlace& b, WorldDef& world);

}  // namespace haptic
