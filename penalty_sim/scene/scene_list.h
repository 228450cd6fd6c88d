/// A scene as a YAML list of models with poses, joints, devices and settings.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "scene/contact_properties.h"
#include "scene/robot_tree.h"

namespace YAML {
class Node;
}

namespace haptic {

struct ListedModel {
  std::string file;   ///< absolute path of a URDF
  std::string where;  ///< line in the list, for errors
  std::string motion; ///< file of positions over time (joint_motion.h); empty: none
  ModelSettings settings;
};

struct ListedDevice {
  std::string where, device = "spidar", link;
  PointerCoupling coupling;
  double scale = 1, force_scale = 1;
  bool has_pose = false;
  Pose X_WB;
  HandPath path;
  int repeat = 1;
};

struct SceneList {
  std::string name, srdf;
  std::vector<ListedModel> models;
  std::vector<ListedDevice> devices;
  std::vector<std::pair<std::string, std::string>> filters;
  std::vector<std::pair<std::string, std::string>> settings;  ///< name and text, for setWorldSetting
  ContactMaterial default_material;
  GivenSolid solid;  ///< what all surfaces are made of that do not say it
  std::string where_settings;
};

/// Reads `path`; the format is described in urdf/scenes/README.md. Throws SetupError naming file, line, key,
/// remedy.
SceneList readSceneList(const std::string& path);

}  // namespace haptic
