/// A folder for the files that one test writes; it goes away with the test.
#pragma once
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "haptic_core/base/error.h"
#include "scene/scene_file.h"

namespace haptic {

class TemporaryFiles {
 public:
  TemporaryFiles() {
    std::string pattern = (std::filesystem::temp_directory_path() / "scene_test_XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
  }
  ~TemporaryFiles() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  TemporaryFiles(const TemporaryFiles&) = delete;
  TemporaryFiles& operator=(const TemporaryFiles&) = delete;

  std::string write(const std::string& name, const std::string& text) const {
    const auto path = std::filesystem::path(folder_) / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
    return path.string();
  }
  const std::string& folder() const { return folder_; }

 private:
  std::string folder_;
};

/// Loads a URDF given as text.
inline SceneDef loadText(const std::string& urdf, const SceneOptions& options = {}) {
  const TemporaryFiles files;
  return loadScene(files.write("robot.urdf", urdf), options);
}

/// The message of the SetupError that loading gives; empty when it loads.
inline std::string refusal(const std::string& text, const SceneOptions& options = {},
                           const std::string& name = "robot.urdf") {
  const TemporaryFiles files;
  try {
    loadScene(files.write(name, text), options);
  } catch (const SetupError& error) {
    return error.what();
  }
  return "";
}

inline bool mentions(const std::vector<std::string>& lines, const std::string& word) {
  for (const std::string& line : lines) {
    if (line.find(word) != std::string::npos) return true;
  }
  return false;
}

/// A link with a box of the given size [m] and a solid's inertia.
inline std::string boxLink(const std::string& name, double mass = 1, double size = 0.1,
                           const std::string& in_collision = "") {
  const std::string I = std::to_string(mass * size * size / 6), s = std::to_string(size);
  return "<link name=\"" + name + "\"><inertial><mass value=\"" + std::to_string(mass) +
         "\"/><inertia ixx=\"" + I + "\" iyy=\"" + I + "\" izz=\"" + I +
         "\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial><collision><geometry><box size=\"" + s + " " + s +
         " " + s + "\"/></geometry>" + in_collision + "</collision></link>\n";
}

inline std::string joint(
    const std::string& name, const std::string& type, const std::string& parent, const std::string& child,
    const std::string& inside =
        "<axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" effort=\"10\" velocity=\"1\"/>",
    const std::string& xyz = "0 0 1") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><origin xyz=\"" + xyz + "\"/><parent link=\"" +
         parent + "\"/><child link=\"" + child + "\"/>" + inside + "</joint>\n";
}

inline std::string robot(const std::string& inside) {
  return "<?xml version=\"1.0\"?>\n<robot name=\"r\" xmlns:haptic=\"h\">\n" + inside + "</robot>\n";
}

}  // namespace haptic
