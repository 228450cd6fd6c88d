/// Choices of whoever loads a scene.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace haptic {

/// What becomes of a collision whose mesh is not there or cannot be read.
enum class MissingMeshes : unsigned char {
  kStop,  ///< the scene is refused, in one line with all of them
  kBox,   ///< a box with the mass and the moments of inertia of its link
  kSkip   ///< it is left out
};

/// A row of `kMissingMeshes`.
struct MissingMeshesName {
  MissingMeshes choice;  ///< the choice
  const char* name;      ///< as options and parameters write it
};

/// All choices.
inline constexpr MissingMeshesName kMissingMeshes[] = {
    {MissingMeshes::kStop, "stop"}, {MissingMeshes::kBox, "box"}, {MissingMeshes::kSkip, "skip"}};

/// How whoever loads a scene writes the choices that a refusal advises.
struct OptionWords {
  std::string density = "--default-density 1000";           ///< kg/m³
  std::string missing = "--missing-meshes box or skip";     ///< of kMissingMeshes
  std::string xacro = "--xacro name:=value";                ///< an argument
};

/// Choices of whoever loads a scene.
struct SceneOptions {
  /// Density [kg/m³] for moving links without <inertial>; 0: a robot without any is refused, single links get
  /// an estimate and a warning.
  double default_density = 0;
  std::string srdf;  ///< file whose <disable_collisions> pairs do not collide; empty: none
  std::vector<std::string> scene_folders;  ///< where scene names are looked up first
  bool add_pointer = true;                 ///< add a sphere for the hand when the scene names no pointer
  /// h [s] in place of the scene's; 0: the scene's. What a hand bears of surfaces that say nothing follows from it.
  double step = 0;
  MissingMeshes missing = MissingMeshes::kStop;  ///< of collisions; a missing visual is not drawn, and said
  std::vector<std::string> xacro;   ///< arguments of xacro files, "name:=value"
  std::optional<std::string> text;  ///< URDF in place of a file's; the file's name is then for messages and relative paths alone
  OptionWords words;                ///< for refusals
  bool rigid = false;               ///< all surfaces are said to be rigid, whatever the files say
  std::function<void(const std::string&)> progress;  ///< told what takes its time, a line a second; empty: nobody is
};

/// The choice called `name`. Throws SetupError that lists the known ones.
MissingMeshes missingMeshesNamed(const std::string& name);

}  // namespace haptic
