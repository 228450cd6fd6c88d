#include "scene/link_visuals.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/parse_numbers.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "scene/resource_path.h"

namespace haptic {
namespace {

/// `count` finite numbers of an attribute, or nothing: a visual with other text is left out, and the robot
/// stays.
std::optional<std::vector<double>> drawable(const XmlElement& shape, const char* attribute,
                                            std::size_t count) {
  const char* text = shape.Attribute(attribute);
  auto numbers = parseNumbers(text ? text : "");
  if (!numbers || numbers->size() != count) return std::nullopt;
  const bool finite =
      std::all_of(numbers->begin(), numbers->end(), [](double number) { return std::isfinite(number); });
  return finite ? numbers : std::nullopt;
}

/// False: it has no file or no scale.
bool readMeshVisual(const XmlElement& mesh, VisualDef& visual, std::string& file) {
  const char* name = mesh.Attribute("filename");
  const auto scale = mesh.Attribute("scale") ? drawable(mesh, "scale", 3) : std::vector<double>{1, 1, 1};
  if (!name || !*name || !scale) return false;
  visual.shape = VisualShape::kMesh;
  visual.size = Vector3(scale->data());
  file = name;
  return true;
}

/// Drawn as it collides: rviz has no capsule.
bool readCapsule(double radius, double length, const std::string& where, VisualDef& visual) {
  if (!(radius > 0) || !(length > 0)) return false;
  visual.shape = VisualShape::kTriangles;
  const TriangleMesh mesh = Rod(radius, length, Rod::Ends::kRound, where).triangles();
  for (const auto& triangle : mesh.triangles) {
    for (const int corner : triangle) visual.corners.push_back(mesh.vertices[corner]);
  }
  return true;
}

/// False: no shape that can be drawn. A mesh's `file` is still to be found.
bool readShape(const XmlElement& given, const std::string& where, VisualDef& visual, std::string& file) {
  const XmlElement* const geometry = given.FirstChildElement("geometry");
  const XmlElement* const shape = geometry ? geometry->FirstChildElement() : nullptr;
  const std::string kind = shape ? shape->Name() : "";
  if (kind == "mesh") return readMeshVisual(*shape, visual, file);
  if (kind == "box") {
    const auto size = drawable(*shape, "size", 3);
    visual.shape = VisualShape::kBox;
    if (size) visual.size = Vector3(size->data());
    return size.has_value();
  }
  if (kind != "sphere" && kind != "cylinder" && kind != "capsule") return false;
  const auto radius = drawable(*shape, "radius", 1);
  const auto length = kind == "sphere" ? std::vector<double>{0} : drawable(*shape, "length", 1);
  if (!radius || !length) return false;
  const double r = radius->front(), l = length->front();
  if (kind == "capsule") return readCapsule(r, l, where, visual);
  visual.shape = kind == "sphere" ? VisualShape::kSphere : VisualShape::kCylinder;
  visual.size = Vector3(2 * r, 2 * r, kind == "sphere" ? 2 * r : l);
  return true;
}

}  // namespace

std::vector<VisualDef> readVisuals(const RobotFile& robot, const LinkXml& link,
                                   const MaterialColours& colours, std::vector<std::string>& missing,
                                   LoadReport& said) {
  std::vector<VisualDef> visuals;
  const XmlElement* given = link.element->FirstChildElement("visual");
  for (; given; given = given->NextSiblingElement("visual")) {
    VisualDef visual;
    std::string file;
    const std::string where = robot.xml.at(*given) + ": link '" + link.name + "'";
    if (!readShape(*given, where, visual, file)) {
      said.warnings.push_back(where + ": this <visual> has no shape that can be drawn and is left out");
      continue;
    }
    visual.X_LV = readOrigin(robot.xml, *given);
    if (visual.shape == VisualShape::kMesh) {
      const std::string path = resolveResource(file, robot.xml.path());
      if (path.empty()) {
        if (std::find(missing.begin(), missing.end(), file) == missing.end()) missing.push_back(file);
        continue;
      }
      visual.mesh_uri = "file://" + path;
    }
    const auto colour = colours.of(*given);
    if (colour) visual.colour = *colour;
    visual.own_colours = visual.shape == VisualShape::kMesh && !colour;
    visuals.push_back(visual);
  }
  return visuals;
}

}  // namespace haptic
