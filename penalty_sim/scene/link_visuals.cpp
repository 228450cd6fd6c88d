#include "scene/link_visuals.h"

#include <urdf_model/link.h>

#include <algorithm>

#include "scene/resource_path.h"

namespace haptic {
namespace {

Pose poseOf(const urdf::Pose& pose) {
  const auto& q = pose.rotation;
  return {Quaternion(q.w, q.x, q.y, q.z).normalized(),
          Vector3(pose.position.x, pose.position.y, pose.position.z)};
}

bool readShape(const urdf::Geometry& geometry, const RobotFile& robot, VisualDef& visual, std::vector<std::string>& missing) {
  if (geometry.type == urdf::Geometry::BOX) {
    const auto& box = static_cast<const urdf::Box&>(geometry);
    visual.shape = VisualShape::kBox;
    visual.size = Vector3(box.dim.x, box.dim.y, box.dim.z);
  } else if (geometry.type == urdf::Geometry::SPHERE) {
    visual.shape = VisualShape::kSphere;
    visual.size = Vector3::Constant(2 * static_cast<const urdf::Sphere&>(geometry).radius);
  } else if (geometry.type == urdf::Geometry::CYLINDER) {
    const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
    visual.shape = VisualShape::kCylinder;
    visual.size = Vector3(2 * cylinder.radius, 2 * cylinder.radius, cylinder.length);
  } else {
    const auto& mesh = static_cast<const urdf::Mesh&>(geometry);
    const std::string path = resolveResource(mesh.filename, robot.xml.path());
    if (path.empty()) {
      if (std::find(missing.begin(), missing.end(), mesh.filename) == missing.end()) missing.push_back(mesh.filename);
      return false;
    }
    visual.shape = VisualShape::kMesh;
    visual.mesh_uri = "file://" + path;
    visual.size = Vector3(mesh.scale.x, mesh.scale.y, mesh.scale.z);
  }
  return visual.size.allFinite();
}

}  // namespace

std::vector<VisualDef> readVisuals(const urdf::Link& link, const RobotFile& robot,
                                   std::vector<std::string>& missing) {
  std::vector<VisualDef> visuals;
  for (const urdf::VisualSharedPtr& given : link.visual_array) {
    if (!given || !given->geometry) continue;
    VisualDef visual;
    if (!readShape(*given->geometry, robot, visual, missing)) continue;
    visual.X_LV = poseOf(given->origin);
    if (given->material) {
      const urdf::Color& c = given->material->color;
      visual.colour = {c.r, c.g, c.b, c.a};
    }
    visual.own_colours = visual.shape == VisualShape::kMesh && !given->material;
    visuals.push_back(visual);
  }
  return visuals;
}

}  // namespace haptic
