/// A <collision>'s geometry as convex shapes.
#pragma once
#include <string>

#include "scene/mesh_shapes.h"
#include "scene/robot_file.h"
#include "scene/shape_pieces.h"

namespace haptic {

/// Makes the shapes of one scene.
class CollisionShapes {
 public:
  /// `options` outlives this.
  explicit CollisionShapes(const SceneOptions& options) : meshes_(options) {}

  /// Box, cylinder, sphere, capsule, mesh. A sphere is a true ball, unless <haptic:shape subdivision=> beside
  /// <geometry> asks for a polyhedron; cylinders and capsules are polyhedra where segments= and subdivision= ask. With
  /// type="half_space" all below z = 0 of the collision's frame collides, and the geometry is for other tools and for the
  /// thickness of the elastic layer; with type="ellipsoid", "cone" or "height_field" that collides, and the
  /// geometry is for other tools; with type="ground" all that lies under the mesh collides (ground.h). Meshes: see
  /// mesh_shapes.h. Throws SetupError: no geometry, an unknown one, sizes not positive, no ground (ground.h, height_file.h).
  ShapePieces make(const RobotFile& robot, const LinkXml& link, const XmlElement& collision);

  /// Those of the scene.
  const MeshShapes& meshes() const { return meshes_; }

 private:
  ShapePieces makeGround(const RobotFile& robot, const std::string& where, const XmlElement& shape, const XmlElement& geometry);

  MeshShapes meshes_;
};

}  // namespace haptic
