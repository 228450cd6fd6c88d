/// Triangle meshes from .stl, .dae and .obj files.
#pragma once
#include <string>

#include "haptic_core/geometry/shapes/mass_properties.h"

namespace haptic {

/// All triangles of `path` in metres, node transforms of the file applied, each axis times `scale`. Equal
/// vertices are joined. A Collada file's unit is respected and its up axis left as written, as ROS tools do.
/// Triangles with a corner that is not finite are left
/// out, and counted in `dropped`. `where` names the link in errors. Throws SetupError: unreadable, no triangle.
TriangleMesh readMesh(const std::string& path, const Vector3& scale, const std::string& where, int* dropped = nullptr);

}  // namespace haptic
