/// Triangle meshes from .stl, .dae and .obj files.
#pragma once
#include <string>

#include "haptic_core/geometry/shapes/mass_properties.h"

namespace haptic {

/// What is amiss in a file that is read all the same.
struct MeshOddities {
  int dropped = 0;    ///< triangles with a corner that is not finite, left out
  std::string count;  ///< " counts 6 triangles and has 12, which are taken"; empty: the head of the file says what is there
};

/// All triangles of `path` in metres, node transforms of the file applied, each axis times `scale`. Equal
/// vertices are joined. A Collada file's unit is respected and its up axis left as written, as ROS tools do.
/// `where` names the link in errors. Throws SetupError: unreadable, no triangle.
TriangleMesh readMesh(const std::string& path, const Vector3& scale, const std::string& where, MeshOddities* odd = nullptr);

}  // namespace haptic
