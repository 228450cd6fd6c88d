/// Mesh files as convex pieces, and what stands in for files that are not there.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "scene/load_report.h"
#include "scene/robot_file.h"
#include "scene/scene_options.h"
#include "scene/shape_pieces.h"

namespace haptic {

/// Makes and shares the meshes of one scene: one that several links use is read and cut once.
class MeshShapes {
 public:
  /// `options` outlives this.
  explicit MeshShapes(const SceneOptions& options) : options_(options) {}

  /// Pieces of <mesh> within `surface_error` [m] of its surface; 0: 1 mm, or 1 % of its size where that is more. A mesh that bounds no
  /// volume, or is refused, becomes the nearest sound shape (sound_shape.h). One that is not there or cannot be read becomes what
  /// SceneOptions::missing says. Each replacement is said in the result. Throws SetupError: no filename.
  ShapePieces make(const RobotFile& robot, const LinkXml& link, const std::string& where, const XmlElement& collision,
                   double surface_error);

  /// Throws SetupError where missing files stop the load: one line with all of them. `pictures`: the missing files of visuals.
  void refuseMissing(const std::vector<std::string>& pictures) const;

 private:
  ShapePieces standIn(const RobotFile& robot, const LinkXml& link, const XmlElement& collision, const std::string& reason) const;

  const SceneOptions& options_;
  std::map<std::string, ShapePieces> made_;  ///< by path, scale and surface error
  std::vector<std::string> missing_;         ///< "a.stl (file:line: link 'x')"
  std::vector<std::string> unreadable_;      ///< "file:line: link 'x': mesh a.stl cannot be read (reason); remedy"
};

/// Path of the file in a <mesh>; empty: it is not there. Throws SetupError: it has no filename.
std::string meshPath(const RobotFile& robot, const std::string& where, const XmlElement& mesh);

/// Factors of a <mesh>, 1 without; none is 0.
Vector3 meshScale(const RobotFile& robot, const XmlElement& mesh);

}  // namespace haptic
