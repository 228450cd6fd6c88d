#include <algorithm>
#include <cmath>
#include <string>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/convex_shape.h"
#include "scene/mesh_file.h"
#include "scene/packed_scene.h"

namespace haptic {
namespace {

std::vector<Vector3> cornersOf(const TriangleMesh& mesh, double step) {
  std::vector<Vector3> corners;
  for (const auto& triangle : mesh.triangles) {
    for (const int i : triangle) {
      const Vector3& corner = mesh.vertices[static_cast<std::size_t>(i)];
      corners.push_back(Vector3(std::round(corner.x() / step), std::round(corner.y() / step), std::round(corner.z() / step)) * step);
    }
  }
  return corners;
}

VisualDef trianglesOf(const TriangleMesh& mesh, double step, const VisualDef& like) {
  VisualDef visual = like;
  visual.shape = VisualShape::kTriangles;
  visual.size = Vector3::Ones();
  visual.mesh_uri.clear();
  visual.corners = cornersOf(mesh, step);
  return visual;
}

/// What collides on the visual's link, in its colour.
std::vector<VisualDef> collidingShapes(const SceneDef& scene, const VisualDef& like, double step) {
  std::vector<VisualDef> visuals;
  const LinkDef& link = scene.world.articulations[static_cast<std::size_t>(like.articulation)].links[static_cast<std::size_t>(like.link)];
  for (const CollisionDef& collision : link.collisions) {
    visuals.push_back(trianglesOf(collision.shape->triangles(), step, like));
    visuals.back().X_LV = collision.X_LS;
  }
  return visuals;
}

/// The triangles of a visual's file; none where it cannot be read, which changes the picture alone.
TriangleMesh meshOf(const VisualDef& visual) {
  try {
    return readMesh(visual.mesh_uri.substr(std::string("file://").size()), visual.size, visual.name);
  } catch (const SetupError&) {
    return {};
  }
}

}  // namespace

void drawWithoutFiles(SceneDef& scene, double step, int most) {
  std::vector<VisualDef> visuals;
  std::vector<std::pair<int, int>> shown;  // links whose colliding shapes are drawn already
  for (const VisualDef& visual : scene.visuals) {
    if (visual.shape != VisualShape::kMesh) {
      visuals.push_back(visual);
      continue;
    }
    const TriangleMesh mesh = meshOf(visual);
    const int count = static_cast<int>(mesh.triangles.size());
    if (count > 0 && count <= most) {
      most -= count;
      visuals.push_back(trianglesOf(mesh, step, visual));
      continue;
    }
    const std::pair<int, int> link(visual.articulation, visual.link);
    if (std::find(shown.begin(), shown.end(), link) != shown.end()) continue;
    shown.push_back(link);
    for (VisualDef& shape : collidingShapes(scene, visual, step)) visuals.push_back(std::move(shape));
  }
  scene.visuals = std::move(visuals);
}

}  // namespace haptic
