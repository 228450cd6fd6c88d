/// A scene as a YAML list of models with poses, joints, devices and settings.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "haptic_core/loop/delay_line.h"
#include "scene/contact_properties.h"
#include "scene/robot_tree.h"

namespace YAML {
class Node;
}

namespace haptic {

/// A model in a YAML list of models.
struct ListedModel {
  std::string file;   ///< absolute path of a URDF
  std::string where;  ///< line in the list, for errors
  std::string motion; ///< file of positions over time (joint_motion.h); empty: none
  /// Where it stands and how it starts.
  ModelSettings settings;
};

/// A device in a YAML list of models.
struct ListedDevice {
  /// Line in the list, for errors; name of the device's driver; the link that it moves.
  std::string where, device = "spidar", link;
  /// Direct, or by spring and damper.
  PointerCoupling coupling;
  /// World metres per grip metre, and hand newtons per world newton.
  double scale = 1, force_scale = 1;
  AddedDelay delay;  ///< of the loop, beside the wire's
  /// X_WB was given.
  bool has_pose = false;
  /// Device base in the world; read only with `has_pose`.
  Pose X_WB;
  /// Of the scripted hand, in the device's base.
  HandPath path;
  /// Times that the path is run.
  int repeat = 1;
};

/// A scene file that lists models, devices and settings.
struct SceneList {
  /// Name of the scene; path of an SRDF file, or empty.
  std::string name, srdf;
  /// In the order of the file.
  std::vector<ListedModel> models;
  /// In the order of the file.
  std::vector<ListedDevice> devices;
  /// Pairs of links that do not collide, by name with prefix.
  std::vector<std::pair<std::string, std::string>> filters;
  std::vector<std::pair<std::string, std::string>> settings;  ///< name and text, for setWorldSetting
  /// For pairs where neither surface gives a value.
  ContactMaterial default_material;
  GivenSolid solid;  ///< what all surfaces are made of that do not say it
  /// Line of the settings, for errors.
  std::string where_settings;
};

/// Reads `path`; the format is described in urdf/scenes/README.md. Throws SetupError naming file, line, key,
/// remedy.
SceneList readSceneList(const std::string& path);

}  // namespace haptic
