/// A <collision>'s geometry as convex shapes.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/geometry/shapes/convex_shape.h"
#include "haptic_core/geometry/shapes/mass_properties.h"
#include "scene/robot_file.h"

namespace haptic {

/// One URDF collision: its convex pieces, all in the collision's own frame.
struct ShapePieces {
  /// One or more; shared with other collisions of the same mesh.
  std::vector<std::shared_ptr<const ConvexShape>> pieces;
  std::string text;  ///< "box 0.1 × 0.1 × 0.1 m", "mesh link0.stl: hull, 0.3 mm from the mesh, 124 vertices"
  double half_extent = 0;  ///< half of the shortest side of the box around all pieces [m]
  std::string fixed_only;  ///< why its link must be fixed to the world, "a half-space, which has no end"; empty: it may move
  TriangleMesh picture;    ///< of ground, in the collision's frame, for links without <visual>; empty: none
};

/// Makes and shares shapes of one scene: a mesh that several links use is read and hulled once.
class CollisionShapes {
 public:
  /// Box, cylinder, sphere, capsule, mesh. A sphere is a true ball, unless <haptic:shape subdivision=> beside
  /// <geometry> asks for a polyhedron; cylinders and capsules are polyhedra where segments= and subdivision= ask. With
  /// type="half_space" all below z = 0 of the collision's frame collides, and the geometry is for other tools and for the
  /// thickness of the elastic layer; with type="ellipsoid", "cone" or "height_field" that collides, and the
  /// geometry is for other tools; with type="ground" all that lies under the mesh collides (ground.h). A mesh that
  /// cannot be decomposed is hulled with a warning. Throws SetupError: no geometry, an unknown one, sizes not positive, a mesh not
  /// found, unreadable or flat, no ground (ground.h, height_file.h).
  ShapePieces make(const RobotFile& robot, const LinkXml& link, const XmlElement& collision,
                   std::vector<std::string>& warnings);

 private:
  ShapePieces makeGround(const RobotFile& robot, const std::string& where, const XmlElement& shape, const XmlElement& geometry);
  ShapePieces makeMesh(const RobotFile& robot, const std::string& where, const XmlElement& mesh,
                       std::vector<std::string>& warnings);

  std::map<std::string, ShapePieces> meshes_;  ///< by path and scale
};

}  // namespace haptic
