/// Meshes that were cut once, kept on disk by their content.
///
/// A file below ~/.cache/haptics/meshes (XDG_CACHE_HOME in place of ~/.cache) per mesh: the pieces with their bits, and the report. Its
/// name is a hash of the mesh's numbers and of the settings, so that a mesh that changes has another file, wherever it lies. The folder
/// may be deleted at any time. What cannot be read, or is damaged, is cut again; what cannot be written is not kept.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic_core/geometry/hulls/mesh_to_convex.h"

namespace haptic {

/// A mesh as its pieces.
struct CutMesh {
  std::vector<std::shared_ptr<const ConvexPolyhedron>> pieces;  ///< one or more
  ConvexReport report;                                          ///< how near they are
};

/// Path of the file that keeps the pieces of `mesh` under `settings`; empty: there is no home.
std::string cachePath(const TriangleMesh& mesh, const ConvexSettings& settings);

/// What the file at `path` holds, its pieces called `name`; nothing: there is none that is whole.
std::optional<CutMesh> readCut(const std::string& path, const std::string& name);

/// Keeps `cut` at `path`, and makes its folder.
void keepCut(const std::string& path, const CutMesh& cut);

}  // namespace haptic
